"""The microwave oven: its world, its pieces, and from these a plan that is carried out."""

import dataclasses
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from oven_pieces import oven, oven_pieces
from pydrake.multibody.plant import MultibodyPlant

from ichain_drake.cli.evaluate_graph import format_evaluation
from ichain_drake.control.planning.enabling import find_enabling
from ichain_drake.control.planning.frames import Frames
from ichain_drake.control.planning.holding import can_hold
from ichain_drake.control.planning.plan import Plan
from ichain_drake.control.planning.planner import GraphPlanner
from ichain_drake.demonstrations import Demonstration
from ichain_drake.errors import InputError, UnreachableError
from ichain_drake.graph import Interaction
from ichain_drake.learning import InteractionModel, InteractionSpec
from ichain_drake.motion_query import MotionQuery
from ichain_drake.robot.models import model_parser, resolve_model
from ichain_drake.runs.goals.evaluation import score_classifiers
from ichain_drake.runs.goals.run import GraphRun, run_graph
from ichain_drake.runs.learn import learn
from ichain_drake.scenarios.faults import Faults
from ichain_drake.simulation.commands import Commands
from ichain_drake.simulation.episode import Episode, EpisodeLog
from ichain_drake.systems.microwave.demonstrations import script_pieces
from ichain_drake.systems.microwave.layout import LAYOUT, MicrowaveStart
from ichain_drake.systems.microwave.scenario import BUTTON, DOOR, FOOD, HAND, KNOB, Microwave
from ichain_drake.systems.microwave.teleoperation import OvenTeleoperation

OPEN, IN = LAYOUT.door.travel, LAYOUT.button.travel
PLACE = (0.755, 0.045)
STEPS = ("put in", "shut", "switch on", "turn up", "open", "take out")


scenario, pieces = oven, oven_pieces


@cache
def knowledge() -> InteractionModel:
    quick = InteractionSpec(status_estimators=InteractionSpec().status_estimators[:1])
    return learn(scenario().graph, pieces(), spec=quick)


def play(start: MicrowaveStart, hand: OvenTeleoperation, physics: str = "ideal") -> EpisodeLog:
    world = Microwave(("noise.scale=0",), physics).build_world(start, 0)  # type: ignore[arg-type]
    episode = Episode(world, Commands(hand.commands))
    episode.run(len(hand.commands))
    return episode.log()


def whole_task(start: MicrowaveStart) -> OvenTeleoperation:
    """Only this test knows it, as proof that the world allows it."""
    hand = OvenTeleoperation(start.hand).take_food(start.food).lift().carry_in(PLACE)
    hand.take_part("door", start.door).slide("door", 0.0).leave()
    hand.take(LAYOUT.knob.point).to(roll=-1.5).leave().to(roll=0.0)
    hand.take_part("button", 0.0).slide("button", IN).wait(60).slide("button", 0.0).leave()
    hand.take_part("door", 0.0).slide("door", OPEN).leave().take_food(PLACE).lift().carry_out(start.food)
    return hand.take_part("door", OPEN).slide("door", 0.0).leave()


def test_the_graph_is_that_of_the_paper() -> None:
    expected = {(HAND, n) for n in (DOOR, BUTTON, KNOB, FOOD)} | {(n, FOOD) for n in (DOOR, BUTTON, KNOB)}
    assert set(scenario().graph.interactions) == {Interaction(*e) for e in expected}


@pytest.mark.parametrize("physics", ["ideal", "contact"])
def test_the_whole_task_gives_hot_food_where_it_was(physics: str) -> None:
    start = scenario().start(3)
    log = play(start, whole_task(start), physics)
    first, last = log.states[FOOD][0], log.states[FOOD][-1]
    assert first[3] <= 0.2
    assert last[3] >= 0.8
    np.testing.assert_allclose(last[:3], first[:3], atol=0.01)
    assert log.states[DOOR][-1][1] <= 0.005
    assert log.states[BUTTON][-1][0] <= 0.002
    assert not log.active[FOOD][-1].any()


def test_each_gate_alone_keeps_the_food_cold() -> None:
    on = MicrowaveStart(PLACE, 0.1, door=0.0, button=IN, knob=1.5)
    still = OvenTeleoperation(on.hand).wait(10)
    gates: dict[str, dict[str, Any]] = {
        "door": {"door": 0.05}, "button": {"button": 0.0}, "food": {"food": (0.63, -0.28)}, "knob": {"knob": 0.0}
    }  # fmt: skip
    assert play(on, still).states[FOOD][-1][3] > 0.2
    for name, change in gates.items():
        assert play(dataclasses.replace(on, **change), still).states[FOOD][-1][3] == pytest.approx(0.1), name


def test_runs_differ_in_their_start_and_repeat() -> None:
    starts = [scenario().start(k) for k in range(4)]
    assert len({s.food for s in starts}) == 4
    assert starts[2] == Microwave((), "ideal").start(2)
    assert all(s.door == OPEN and s.button == 0.0 and not s.inside for s in starts)


def test_the_plants_oven_is_the_layouts() -> None:
    text = Path(resolve_model("package://ichain_drake_models/microwave/oven.urdf", "test")).read_text(encoding="utf-8")
    for box in LAYOUT.boxes:
        middle = " ".join(f"{(a + b) / 2:.4g}" for a, b in zip(box[:3], box[3:], strict=True))
        assert f'<origin xyz="{middle}"/>' in text
    for faults in (Faults(), Faults(stiffness=1.5)):
        bodies = scenario().bodies(MicrowaveStart((0.6, -0.2), 0.1, door=0.05), faults)
        for name, mount in ((DOOR, LAYOUT.door), (BUTTON, LAYOUT.button), (KNOB, LAYOUT.knob)):
            part = MultibodyPlant(0.0)
            model_parser(part).AddModels(resolve_model(bodies[name].file, "test"))
            part.Finalize()
            joint = part.GetJointByName("move")
            assert (joint.position_lower_limits()[0], joint.position_upper_limits()[0]) == (0.0, mount.travel)


@pytest.mark.parametrize("physics", ["ideal", "contact"])
def test_stiff_controls_lag_behind_the_hand(physics: str) -> None:
    stiff = Microwave(("fault.kind=stiff", "noise.scale=0"), physics)  # type: ignore[arg-type]
    hand = OvenTeleoperation(stiff.start(0).hand).take_part("button", 0.0).slide("button", IN).wait(1).leave()
    hand.take(LAYOUT.knob.point).to(roll=-1.0).wait(1).leave()
    world = stiff.make_world(0)
    episode = Episode(world, Commands(hand.commands))
    episode.run(len(hand.commands))
    first, last = ({n: s[k] for n, s in episode.log().states.items()} for k in (0, -1))
    assert last[BUTTON][0] == pytest.approx(IN / 1.5, rel=0.15)
    assert last[KNOB][3] - first[KNOB][3] == pytest.approx(1.0 / 1.5, rel=0.15)


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("start.food=[0.6]", r"start.food is \[0.6\]; give 2 numbers from -2 to 2, in m"),
        ("start.temperature=[0.5, 0.2]", "start.temperature is .*; give 2 numbers from 0 to 1, from and to"),
        ("start.knob=[0.0, 2.0]", "start.knob is .*; give 2 numbers from 0 to 1.75, from and to, in rad"),
    ],
)
def test_settings_that_cannot_be_are_refused(setting: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        Microwave((setting,), "ideal")


@pytest.mark.parametrize("kind", ["slip", "knock", "dropout"])
def test_faults_meet_the_food(kind: str) -> None:
    wrong = Microwave((f"fault.kind={kind}", "fault.time=[0.5, 0.5]", "noise.scale=0"), "ideal")
    start = wrong.start(0)
    hand = OvenTeleoperation(start.hand).take_food(start.food).lift().wait(3)
    world = wrong.make_world(0)
    episode = Episode(world, Commands(hand.commands))
    episode.run(3)  # 1 s
    port, context = world.GetOutputPort(f"{FOOD}.valid"), world.GetMyContextFromRoot(episode.context)
    assert port.Eval(context)[0] == (kind != "dropout")
    episode.run(len(hand.commands) - 3)
    assert port.Eval(context)[0]
    log = episode.log()
    food, held = log.states[FOOD], log.active[FOOD][:, wrong.graph.parents(FOOD).index(HAND)] > 0.5
    if kind == "slip":
        assert held.any()
        assert not held[-1]
        assert food[-1][2] == pytest.approx(food[0][2], abs=1e-6)
    elif kind == "knock":
        assert not held.any()  # it is no longer where it was seen
        assert np.linalg.norm(food[-1][:2] - food[0][:2]) == pytest.approx(wrong.config.fault.knock)
    else:
        assert held[-1]


@pytest.mark.parametrize(
    ("kind", "message"),
    [("slip", "in contact the plant alone moves things"), ("fire", "microwave has no fault 'fire'")],
)
def test_faults_that_cannot_be_are_refused(kind: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        Microwave((f"fault.kind={kind}",), "contact")


def test_the_hand_finds_its_way_in_only_where_it_left_the_door_open() -> None:
    assert scenario().make_motion() is None
    motion = Microwave((), "contact").make_motion()
    assert motion is not None
    before, inside = np.array([0.54, 0.045, 0.075, 0.0, 0.0]), np.array([0.755, 0.045, 0.075, 0.0, 0.0])
    way = motion.path(MotionQuery(before, inside))
    np.testing.assert_array_equal(way[-1], inside)
    at_handle = np.array([*LAYOUT.door.point, 0.0, 0.0])
    with pytest.raises(UnreachableError, match="door"):
        motion.path(MotionQuery(before, inside, left={DOOR: at_handle}))
    opened = {DOOR: at_handle + [0.0, OPEN, 0.0, 0.0, 0.0]}
    assert len(motion.path(MotionQuery(before, inside, left=opened))) == len(way)
    # A part that is held goes along.
    assert len(motion.path(MotionQuery(at_handle, at_handle + [0.0, 0.1, 0.0, 0.0, 0.0], held=DOOR, left={}))) <= 6


# Pieces.


def passes(values: np.ndarray, low: float, high: float, where: np.ndarray) -> tuple[bool, bool]:
    """Whether values go from below `low` to above `high` somewhere, and whether the other way round."""
    side = np.where(values > high, 1, np.where(values < low, -1, 0))
    known = np.flatnonzero(side * where)
    turns = np.diff(side[known])
    return bool((turns > 0).any()), bool((turns < 0).any())


def shown(piece: Demonstration) -> set[str]:
    """Which steps of the task a piece shows, read from its flags and values, whatever the script meant."""
    table = piece.table
    door, button, knob = (table[c].to_numpy() for c in ("door.y", "button.x", "knob.angle"))
    inside = table["door->food"].to_numpy() > 0.5
    put_in, taken_out = inside[-1] and not inside[0], inside[0] and not inside[-1]
    opened, shut = passes(door, 0.02, 0.09, inside)
    switched_on, _ = passes(button, 0.004, 0.008, inside)
    turned_up, _ = passes(knob, 0.2, 0.6, inside)
    flags = {"put in": put_in, "take out": taken_out, "open": opened, "shut": shut, "switch on": switched_on}
    return {name for name, seen in (flags | {"turn up": turned_up}).items() if seen}


def test_pieces_show_every_edge_and_none_the_whole_task() -> None:
    edges = {e.name: 0 for e in scenario().graph.interactions}
    seen = set()
    for piece in pieces():
        steps = shown(piece)
        assert len(steps) <= 2, (piece.name, steps)
        seen |= steps
        for name in edges:
            flag = piece.table[name].to_numpy() > 0.5
            edges[name] += int(np.sum(flag[1:] & ~flag[:-1]))
    assert seen == set(STEPS)
    assert min(edges.values()) >= 4, edges


def test_pieces_start_from_states_of_their_own() -> None:
    temperatures = {p.start.temperature for p in script_pieces(np.random.default_rng(0))}
    assert len(temperatures) == len(pieces())


# What is learned from them, and done with it.


def test_heating_is_learned_to_depend_on_all_parents_of_the_food() -> None:
    places = {f"position of {FOOD}", f"position of {FOOD} relative to {KNOB}"}  # the knob stays where it is
    for parent in (KNOB, BUTTON):
        columns = set(knowledge().report()["interactions"][f"{parent}->{FOOD}"]["status"]["columns"])
        assert len(columns & places) == 1
        assert columns - places == {f"position of {n}" for n in (DOOR, BUTTON)}


def test_food_behind_a_shut_door_cannot_be_held_and_the_door_is_worth_opening() -> None:
    model, frames = knowledge(), Frames(knowledge())
    carries = GraphPlanner(model).options.carries
    edge, door = Interaction(HAND, FOOD), next(c for c in carries if c.edge.child == DOOR)
    held = {n: v[0] for n, v in model.edges[edge].examples.active.items()}
    held[FOOD][:3] = scenario().camera().from_robot(np.array([*PLACE, 0.07]))
    states = []
    for at in (OPEN, 0.0):
        states.append({n: v.copy() for n, v in held.items()})
        states[-1][DOOR][1] = at
    assert can_hold(model, edge, states).tolist() == [True, False]
    assert can_hold(model, edge, []).shape == (0,)
    found = find_enabling(model, door)
    at_open, at_shut = ([float(e.place[0]) for e in found if e.missing(model, frames, states)[k]] for k in range(2))
    assert max(at_shut) > 0.9 * OPEN
    assert not any(place > 0.9 * OPEN for place in at_open)


def test_cold_food_outside_becomes_hot_food_in_the_shut_oven() -> None:
    run = GraphRun(scenario(), tuple(scenario().config.goal))
    run_graph(run, known=knowledge())
    assert run.goal_reached, (run.reason, run.memory and run.memory.log)
    assert isinstance(run.plan, Plan)
    assert {e for step in run.plan.steps for e in step.chain} >= {Interaction(HAND, n) for n in (DOOR, BUTTON, FOOD)}
    assert run.log is not None
    assert run.log.states[FOOD][0][3] <= 0.2
    assert run.log.states[FOOD][-1][3] >= 0.8


def test_a_stiff_button_is_pushed_further_under_feedback() -> None:
    run = GraphRun(Microwave(("fault.kind=stiff",), "ideal"), ("button.x >= 0.009",))
    run_graph(run, known=knowledge())
    assert run.goal_reached, (run.reason, run.memory and run.memory.log)
    assert run.log is not None
    button, hand = np.diff(run.log.states[BUTTON][:, 0]), np.diff(run.log.states[HAND][:, 0])
    button, hand = button[1:], hand[:-1]  # it follows a frame later
    inward = button > 1e-9
    assert button[inward].sum() > 0.0085
    np.testing.assert_allclose(hand[inward], 1.5 * button[inward], atol=1e-9)


def test_each_border_of_an_interaction_has_figures_of_its_own() -> None:
    lines = score_classifiers(scenario(), knowledge(), pieces()[:6])
    borders = {line["interaction"]: list(line["borders"]) for line in lines}
    assert borders == {
        f"{HAND}->{FOOD}": [HAND, DOOR], f"{KNOB}->{FOOD}": [DOOR, BUTTON], f"{BUTTON}->{FOOD}": [DOOR, BUTTON],
        **{name: [] for name in (f"{HAND}->{DOOR}", f"{HAND}->{BUTTON}", f"{HAND}->{KNOB}", f"{DOOR}->{FOOD}")},
    }  # fmt: skip
    for line in lines:
        parts = list(line["borders"].values())
        assert 0.0 < line["near_miss_f1"] <= 1.0
        if parts:
            assert sum(p["near_misses"] for p in parts) == line["near_misses"]
            assert (
                min(p["near_miss_f1"] for p in parts) <= line["near_miss_f1"] <= max(p["near_miss_f1"] for p in parts)
            )
    found = {"table": [], "classifiers": lines, "held_out": {"pieces": 6, "seeds": [0]}, "skipped": {}}
    shown = [row.split() for row in format_evaluation(scenario(), found).splitlines()]
    assert sum(row[:2] == ["by", DOOR] for row in shown) == 3


@pytest.mark.parametrize("inside", [True, False])
def test_by_contact_food_is_moved_unless_it_is_in_the_oven(inside: bool) -> None:
    wrong = Microwave(("fault.kind=moved", "fault.time=[0.2,0.3]", "fault.away=0", "noise.scale=0"), "contact", seed=1)
    start = wrong.start(0)
    start = dataclasses.replace(start, food=PLACE, door=OPEN) if inside else start
    episode = Episode(wrong.build_world(start, 0, faulty=True), Commands(np.tile(start.hand, (9, 1))))
    episode.run(9)
    food = episode.log().states[FOOD]
    assert np.linalg.norm(food[-1, :3] - food[0, :3]) == pytest.approx(0.0 if inside else 0.1, abs=2e-3)
