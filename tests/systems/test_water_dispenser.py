"""The water dispenser's world: cycle, events, camera, noise, faults, a whole task."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from pydrake.geometry import Meshcat, MeshcatParams
from pydrake.systems.analysis import Simulator

from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.objects import Button, Cup, ObjectSettings, Tank, WorldObject
from ichain_drake.robot import IdealHand
from ichain_drake.simulation.commands import Commands
from ichain_drake.simulation.episode import Episode, EpisodeLog
from ichain_drake.systems.water_dispenser.layout import LAYOUT, DispenserStart
from ichain_drake.systems.water_dispenser.scenario import CUP, DISPENSE, HAND, POWER, TANK, WaterDispenser
from ichain_drake.systems.water_dispenser.teleoperation import FORWARD, Teleoperation
from ichain_drake.timing import FRAME, FRAMES_PER_TICK
from ichain_drake.visualization import RecordedEpisode, Recording, Scene, write_playback
from ichain_drake.world.world import World

QUIET = ("noise.scale=0",)


def play(scenario: WaterDispenser, start: DispenserStart, commands: np.ndarray, run: int = 0, **kw: bool) -> EpisodeLog:
    world = scenario.build_world(start, run, **kw)
    episode = Episode(world, Commands(commands))
    episode.run(len(commands))
    return episode.log()


def pour_and_place(start: DispenserStart) -> np.ndarray:
    """Grasp, pour half, put it on the tray."""
    hand = Teleoperation(start.hand).fetch(start.cup).carry_over_inlet().tilt(-1.3).wait(4).tilt(0.0)
    hand.to(0.59, -0.05).to(0.585, 0.06, 0.10).to(z=0.082).to(0.68)
    return hand.put(0.68, 0.06, LAYOUT.tray.height).commands


def whole_task(start: DispenserStart) -> np.ndarray:
    """Pour, heat, place, dispense, retrieve: only this test knows it, as proof that the world allows it."""
    home, (x, y, _) = start.cup, LAYOUT.outlet
    hand = Teleoperation(start.hand).fetch(home).carry_over_inlet().tilt(-1.95).wait(10).tilt(0.0).carry_back(*home)
    hand.put(*home).turn(0.0).grip(True).to(*LAYOUT.power[:2], 0.12)
    hand.press(LAYOUT.power, 6.0).wait(225).press(LAYOUT.power, -20.0).turn(FORWARD).grip(False)
    hand.to(home[0] - 0.085, home[1], 0.1).fetch(home).carry_below_outlet().put(x, y, LAYOUT.tray.height)
    hand.turn(0.0).grip(True).to(*LAYOUT.dispense[:2], 0.12).press(LAYOUT.dispense, 6.0).wait(50)
    hand.press(LAYOUT.dispense, -20.0).turn(FORWARD).grip(False).to(x - 0.085, y, 0.08)
    return hand.fetch((x, y), LAYOUT.tray.height).carry_out().to(y=home[1]).put(*home).commands


def test_the_graph_has_the_seven_interactions_of_the_paper() -> None:
    graph = WaterDispenser((), "ideal").graph
    assert {e.name for e in graph.interactions} == {
        "hand->cup",
        "hand->power",
        "hand->dispense",
        "cup->tank",
        "dispense->tank",
        "power->tank",
        "tank->cup",
    }
    assert (CUP, TANK) in graph.components


def test_the_whole_task_gives_a_cup_of_hot_water_where_it_was() -> None:
    scenario = WaterDispenser((), "ideal", seed=4)
    start = scenario.start(0)
    log = play(scenario, start, whole_task(start))
    first, last = log.states[CUP][0], log.states[CUP][-1]
    assert first[5] < 0.25
    assert last[5] > 0.9
    assert last[4] > 0.9 * first[4]
    np.testing.assert_allclose(last[:3], first[:3], atol=1e-3)
    assert log.active[CUP][-1].tolist() == [0.0, 0.0]


def test_the_diagram_of_the_cycle_equals_a_plain_loop() -> None:
    scenario = WaterDispenser(QUIET, "ideal")
    start = dataclasses.replace(scenario.start(0), tank_amount=0.3, tank_temperature=0.8)
    commands = pour_and_place(start)
    world = scenario.build_world(start, 0)
    episode = Episode(world, Commands(commands))
    states = {n: episode.value(n, "state") for n in world.graph.objects}
    modes: dict[str, dict[str, bool]] = {n: dict.fromkeys(o.parents, False) for n, o in world.objects.items()}
    for name, system in world.objects.items():  # the initialization event
        modes[name] = dict(system.decide_active(states[name], states, modes[name], None))
    episode.run(len(commands))
    log = episode.log()
    for frame in range(len(log.times)):
        for name in world.objects:
            np.testing.assert_array_equal(log.states[name][frame], states[name], err_msg=f"{name} in frame {frame}")
        before = states | {HAND: log.states[HAND][frame]}
        settled = dict(before)
        for name, system in world.objects.items():
            modes[name] = dict(system.decide_active(before[name], before, modes[name], None))
            settled[name] = np.array(system.settle(before[name], before, modes[name]))
        states = {
            n: o.step(settled[n], settled, {p: np.float64(on) for p, on in modes[n].items()}, np.zeros(0), FRAME)
            for n, o in world.objects.items()
        }
    assert log.active[TANK][:, 0].max() == log.active[CUP][:, 1].max() == 1.0


def test_water_and_heat_are_conserved_in_the_diagram() -> None:
    scenario = WaterDispenser(QUIET, "ideal")
    start = dataclasses.replace(scenario.start(0), tank_amount=0.5, tank_temperature=0.8)
    log = play(scenario, start, np.concatenate([pour_and_place(start), whole_task(start)[-60:]]))
    cup, tank = Cup.state_space.view, Tank.state_space.view
    water, heat = [], []
    for a, b in ((cup(s), tank(t)) for s, t in zip(log.states[CUP], log.states[TANK], strict=True)):
        water.append(a.water + a.spilled + a.flow + b.amount + b.spilled + b.flow)
        held = a.water * a.temperature + b.amount * b.temperature
        heat.append(held + a.spilled_heat + a.flow_heat + b.spilled_heat + b.flow_heat - b.heat_added)
    assert np.ptp(water) < 1e-9
    assert np.ptp(heat) < 1e-9


def test_a_mode_decided_at_t_is_in_force_from_t() -> None:
    """Whatever the tank takes in a frame is what its flag of that frame says, in every frame of the run."""
    scenario = WaterDispenser(QUIET, "ideal")
    start = dataclasses.replace(scenario.start(0), tank_amount=0.0)
    log = play(scenario, start, pour_and_place(start))
    tank, cup = Tank.state_space, Cup.state_space
    gained = np.diff(log.states[TANK][:, tank.index("amount")])
    flow = log.states[CUP][:-1, cup.index("flow")]
    takes = log.states[TANK][1:, tank.index("from_cup")]
    np.testing.assert_allclose(gained, takes * flow, atol=1e-15)
    # A log row is taken before the update of its instant, the flag in force from then on is in the next.
    np.testing.assert_array_equal(takes, log.active[TANK][1:, 0])
    assert takes.max() == 1.0


def test_turning_the_camera_changes_coordinates_only() -> None:
    logs, scenarios = [], []
    for yaw in (0.0, 40.0, -100.0):
        scenario = WaterDispenser((*QUIET, f"camera.yaw_deg={yaw}"), "ideal")
        start = scenario.start(3)
        logs.append(play(scenario, start, pour_and_place(start)))
        scenarios.append(scenario)
    rims = [s.camera().to_robot(log.states[CUP][:, :3]) for s, log in zip(scenarios, logs, strict=True)]
    for log, rim in zip(logs[1:], rims[1:], strict=True):
        np.testing.assert_allclose(rim, rims[0], atol=1e-12)
        np.testing.assert_allclose(log.states[CUP][:, 3:], logs[0].states[CUP][:, 3:], atol=1e-12)
        np.testing.assert_array_equal(log.states[TANK], logs[0].states[TANK])
        for name in (CUP, TANK, POWER, DISPENSE):
            np.testing.assert_array_equal(log.active[name], logs[0].active[name])
    assert np.abs(logs[0].states[CUP][:, 0] - logs[1].states[CUP][:, 0]).max() > 0.1


def _renamed(scenario: WaterDispenser, start: DispenserStart, names: dict[str, str], *, reverse: bool) -> World:
    """The scenario's world under other names, objects and interactions in another order; ids stay with the objects."""
    hand, cup, power, dispense, tank = (names[n] for n in (HAND, CUP, POWER, DISPENSE, TANK))
    spec = scenario.config.robot.hand
    spaces = {
        hand: spec.space,
        cup: Cup.space([tank]),
        power: Button.state_space,
        dispense: Button.state_space,
        tank: Tank.space([cup]),
    }
    edges = [(names[e.parent], names[e.child]) for e in scenario.graph.interactions]
    order = reversed if reverse else list
    graph = InteractionGraph({n: spaces[n] for n in order(list(spaces))}, list(order(edges)))
    parents = {n: {p: spaces[p] for p in graph.parents(n)} for n in spaces}

    def settings(number: int) -> ObjectSettings:
        return ObjectSettings(number, 7)

    cup_settings = scenario.cup_settings()
    cup_settings = dataclasses.replace(cup_settings, outlets={tank: cup_settings.outlets[TANK]})
    tank_settings = dataclasses.replace(scenario.tank_settings(), drain=dispense, heater=power)
    rim = (*start.cup, cup_settings.height)
    plain = Cup(cup, parents[cup], cup_settings, settings=settings(1))
    poured = plain.state_at(rim, start.water, start.temperature)
    objects: dict[str, WorldObject] = {
        cup: Cup(cup, parents[cup], cup_settings, initial=poured, settings=settings(1)),
        power: Button(power, parents[power], scenario.button_mount(POWER), settings=settings(2)),
        dispense: Button(dispense, parents[dispense], scenario.button_mount(DISPENSE), settings=settings(3)),
        tank: Tank(tank, parents[tank], tank_settings, settings=settings(4)),
    }
    return World(graph, IdealHand(spec, spec.full(np.array(start.hand)), 7), objects)


def test_noise_and_run_depend_on_no_name_and_no_order() -> None:
    scenario = WaterDispenser((), "ideal")
    start = scenario.start(0)
    commands = pour_and_place(start)[:60]
    same = {n: n for n in (HAND, CUP, POWER, DISPENSE, TANK)}
    words = dict(zip(same, ("zeta", "quill", "marsh", "elbow", "anvil"), strict=True))
    logs = []
    for names, reverse in ((same, False), (words, True)):
        world = _renamed(scenario, start, names, reverse=reverse)
        episode = Episode(world, Commands(commands))
        episode.run(len(commands))
        logs.append(episode.log())
    for name, word in words.items():
        np.testing.assert_array_equal(logs[1].measured[word], logs[0].measured[name])
        if name != TANK:
            np.testing.assert_array_equal(logs[1].states[word], logs[0].states[name])


def test_starts_vary_with_seed_and_run_and_repeat() -> None:
    starts = [WaterDispenser((), "ideal", seed).start(run) for seed, run in ((0, 0), (0, 0), (0, 1), (1, 0))]
    assert starts[0] == starts[1]
    assert len({s.cup for s in starts}) == len({s.water for s in starts}) == 3
    for s in starts:
        assert 0.7 <= s.water <= 0.95
        assert abs(s.cup[0] - 0.68) <= 0.02
        assert abs(s.cup[1] + 0.16) <= 0.05


def test_two_runs_are_equal_and_another_run_has_other_noise() -> None:
    scenario = WaterDispenser((), "ideal")
    start = scenario.start(0)
    commands = pour_and_place(start)[:20]
    first, again, other = (play(scenario, start, commands, run) for run in (0, 0, 1))
    for name in scenario.graph.objects:
        np.testing.assert_array_equal(first.measured[name], again.measured[name])
    assert np.abs(first.measured[CUP] - other.measured[CUP]).max() > 0
    np.testing.assert_array_equal(first.states[CUP], other.states[CUP])
    assert first.measured[HAND][:, :3].std(axis=0).max() > 0
    difference = first.measured[HAND] - first.states[HAND]
    assert difference[:, 0].std() == pytest.approx(0.0005, rel=0.25)


@pytest.mark.parametrize("kind", ["slip", "knock", "stiff", "dropout", "moved"])
def test_faults_happen_in_runs_and_never_in_demonstrations(kind: str) -> None:
    scenario = WaterDispenser((f"fault.kind={kind}", "fault.time=[5, 8]"), "ideal", seed=1)
    start = scenario.start(0)
    hand = Teleoperation(start.hand)
    if kind == "stiff":
        hand.turn(0.0).grip(True).to(0.5, 0.18, 0.12).press(LAYOUT.power, 6.0).wait(5)
    elif kind in ("knock", "moved"):
        hand.by(*([0.0, 0.0, 0.15] if kind == "moved" else [0.0, 0.0, 0.0])).wait(30)
    else:
        hand.fetch(start.cup).by(z=0.1).wait(20)
    faulty, sound = (play(scenario, start, hand.commands, faulty=f) for f in (True, False))
    if kind == "stiff":
        assert (faulty.states[POWER][:, 0].max(), sound.states[POWER][:, 0].max()) == (4.0, 6.0)
    elif kind in ("knock", "moved"):
        moved = [log.states[CUP][-1, :2] - log.states[CUP][0, :2] for log in (faulty, sound)]
        assert np.linalg.norm(moved[0]) == pytest.approx(0.05 if kind == "knock" else 0.1)
        assert np.linalg.norm(moved[1]) == 0.0
    elif kind == "slip":
        assert (faulty.active[CUP][-1, 0], sound.active[CUP][-1, 0]) == (0.0, 1.0)
    else:
        world = scenario.make_world(0)
        simulator = Simulator(world)
        context = simulator.get_mutable_context()
        world.GetInputPort("hand_command").FixValue(context, np.array(start.hand))
        valid = []
        for frame in range(1, 300):
            simulator.AdvanceTo(frame * FRAME)
            valid.append(world.GetOutputPort("cup.valid").Eval(context)[0])
        assert valid.count(0.0) == pytest.approx(3 * FRAMES_PER_TICK, abs=1)


def test_bad_settings_are_refused() -> None:
    with pytest.raises(InputError, match="camera_shift is .* give 3 numbers"):
        WaterDispenser(("camera_shift=[0, 1]",), "ideal")
    with pytest.raises(InputError, match="start.water is .* from 0 to 1, from and to"):
        WaterDispenser(("start.water=[0.5, 1.5]",), "ideal")
    with pytest.raises(InputError, match="fault.stiffness is 0"):
        WaterDispenser(("fault.stiffness=0",), "ideal")
    with pytest.raises(InputError, match="there is no key 'spil'"):
        WaterDispenser(("fault.spil=0",), "ideal")
    with pytest.raises(InputError, match="fault.kind slip: in contact the plant alone moves things"):
        WaterDispenser(("fault.kind=slip",), "contact")
    with pytest.raises(InputError, match="has no fault 'fire'"):
        WaterDispenser(("fault.kind=fire",), "ideal")


@pytest.mark.parametrize("physics", ["arm", "contact"])
def test_with_an_arm_the_cup_is_grasped_poured_and_put_below_the_outlet(physics: str) -> None:
    scenario = WaterDispenser(QUIET, physics)
    start = dataclasses.replace(scenario.start(0), tank_amount=0.1)
    log = play(scenario, start, pour_and_place(start))
    rim = scenario.camera().to_robot(log.states[CUP][-1, :3])
    np.testing.assert_allclose(rim, [0.68, 0.06, 0.11], atol=4e-3)
    assert abs(log.states[CUP][-1, 3]) < 0.02
    poured = log.states[TANK][-1, 0] - 0.1
    assert poured > 0.3
    assert log.states[CUP][-1, 4] == pytest.approx(start.water - poured, abs=1e-6)
    assert log.active[CUP][-1].tolist() == [0.0, 1.0]


def test_in_contact_a_press_moves_the_buttons_body_and_the_machine_stands_in_the_plant() -> None:
    scenario = WaterDispenser(QUIET, "contact")
    start = dataclasses.replace(scenario.start(0), hand=(0.5, 0.18, 0.13, 0.0, 0.0, 1.0), tank_amount=0.5)
    hand = Teleoperation(start.hand).press(LAYOUT.power, -5.0).press(LAYOUT.power, 6.0).wait(3)
    log = play(scenario, start, hand.press(LAYOUT.power, -20.0).commands)
    assert log.states[POWER][:, 0].max() == 6.0
    assert log.states[POWER][-1, 0] == 0.0
    assert log.states[DISPENSE][:, 0].max() == 0.0
    assert log.states[TANK][-1, 1] > log.states[TANK][0, 1]
    plant = scenario.build_world(start, 0).robot.plant
    assert plant.num_constraints() == 1  # the finger's mimic alone
    machine = plant.GetModelInstanceByName("machine")
    boxes = plant.GetCollisionGeometriesForBody(plant.get_body(plant.GetBodyIndices(machine)[0]))
    assert len(boxes) == len(LAYOUT.boxes) + 1


def test_the_layout_is_that_of_the_models() -> None:
    scenario = WaterDispenser((), "arm")
    robot = scenario.build_world(scenario.start(0), 0).robot
    inspector = robot.scene_graph.model_inspector()
    machine = robot.plant.GetModelInstanceByName("machine")
    body = robot.plant.get_body(robot.plant.GetBodyIndices(machine)[0])
    found = []
    for geometry in robot.plant.GetCollisionGeometriesForBody(body):
        shape, middle = inspector.GetShape(geometry), inspector.GetPoseInFrame(geometry).translation()
        if hasattr(shape, "size"):
            found.append((*(middle - 0.5 * shape.size()), *(middle + 0.5 * shape.size())))
    np.testing.assert_allclose(sorted(found), sorted(LAYOUT.boxes), atol=1e-9)


@pytest.mark.parametrize("physics", ["ideal", "contact"])
def test_the_playback_shows_water_and_lit_buttons(physics: str, tmp_path: Path) -> None:
    scenario = WaterDispenser(QUIET, physics)
    start = dataclasses.replace(scenario.start(0), hand=(0.5, 0.26, 0.07, 0.0, 0.0, 1.0), tank_amount=0.5)
    hand = Teleoperation(start.hand).press(LAYOUT.dispense, 6.0).wait(2).press(LAYOUT.dispense, -5.0)
    log = play(scenario, start, hand.commands)
    episode = RecordedEpisode("press", log.times, log.states, plant_positions=log.plant_positions)
    recording = Recording(scenario.name, physics, 0, scenario.graph.objects, (episode,))
    file = tmp_path / "play.html"
    write_playback(recording, scenario.drawings(), file, plant=scenario.drawn_plant())
    assert file.stat().st_size > 100_000

    scene = Scene(Meshcat(MeshcatParams(host="127.0.0.1")))
    for name, drawing in scenario.drawings().items():
        drawing.setup(scene.under(name))
        for time, state in zip(log.times, log.states[name], strict=True):
            drawing.update(scene.under(name), float(time), state)
    moved = {path for path, tracks in scene.tracks.items() if any(len(t.values) > 1 for t in tracks)}
    for path in ("tank/gauge/water", "tank/jet", "dispense/cap", "dispense/cap/body/<object>"):
        assert f"/drake/{path}" in moved, path
    assert scene.meshcat.HasPath("/drake/tank/part_0") == (physics == "ideal")
    assert scene.meshcat.HasPath("/drake/cup/cup/glass") == (physics == "ideal")


def test_a_machine_that_is_moved_must_be_seen_and_stands_elsewhere_in_runs_alone() -> None:
    moved = ("machine.shift=[0.0, 0.1]", "machine.turn_deg=30")
    with pytest.raises(InputError, match="a machine that is moved must be seen"):
        WaterDispenser(moved, "ideal")
    scenario = WaterDispenser((*moved, "machine.seen=true"), "ideal")
    assert scenario.start(0).stands is not None
    assert all(piece.start.stands is None for piece in scenario.script(np.random.default_rng(0)))
