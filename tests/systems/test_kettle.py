"""Bottle and kettle: the world, the pieces, and the whole job on `ideal`."""

import dataclasses
from functools import cache

import numpy as np
import pytest
from kettle_pieces import kettle, kettle_pieces

from ichain_drake.control.planning.plan import Plan
from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.learning import InteractionSpec
from ichain_drake.learning.chain.link import EstimatorSpec
from ichain_drake.motion_query import MotionQuery
from ichain_drake.objects import Cup, Kettle
from ichain_drake.runs.goals.run import GraphRun, run_graph
from ichain_drake.runs.learn import learn
from ichain_drake.simulation.commands import Commands
from ichain_drake.simulation.episode import Episode, EpisodeLog
from ichain_drake.systems import load_scenario
from ichain_drake.systems.kettle.demonstrations import script_pieces
from ichain_drake.systems.kettle.layout import LAYOUT, KettleStart
from ichain_drake.systems.kettle.scenario import BOTTLE, HAND, KETTLE, SWITCH, KettleScenario
from ichain_drake.systems.kettle.teleoperation import KettleTeleoperation
from ichain_drake.systems.water_dispenser.teleoperation import FORWARD
from ichain_drake.timing import TICK

STEPS = ("pour", "boil", "return")
QUICK = InteractionSpec(status_estimators=(EstimatorSpec.parse("box(reach=0.3)"),))


scenario, pieces = kettle, kettle_pieces


def whole_task(start: KettleStart) -> np.ndarray:
    """Pour, boil, pour back: only this test knows it, as proof that the world allows it."""
    plate = LAYOUT.plate.height
    hand = KettleTeleoperation(start.hand).grasp(LAYOUT.bottle, start.bottle).over_kettle(start.kettle)
    hand.pour(-1.92).wait(8).pour(0.0).release(*start.bottle)
    hand.turn(0.0).grip(True).to(*LAYOUT.switch[:2], 0.12)
    hand.press(LAYOUT.switch, 6.0).wait(118).press(LAYOUT.switch, -20.0).turn(FORWARD).grip(False)
    hand.to(0.55, start.kettle[1], 0.12)
    hand.grasp(LAYOUT.kettle, start.kettle, plate).over_bottle(start.bottle).pour(1.15).wait(8).pour(0.0)
    hand.to(y=start.kettle[1])
    return hand.release(*start.kettle, plate).commands


@cache
def played() -> tuple[KettleStart, EpisodeLog]:
    quiet = KettleScenario(("noise.scale=0",), "ideal", seed=3)
    start = quiet.start(0)
    commands = whole_task(start)
    world = quiet.build_world(start, 0)
    episode = Episode(world, Commands(commands))
    episode.run(len(commands))
    return start, episode.log()


def test_bottle_and_kettle_act_on_each_other() -> None:
    graph = load_scenario("kettle", physics="ideal").graph
    assert {e.name for e in graph.interactions} == {
        "hand->bottle",
        "hand->kettle",
        "hand->switch",
        "bottle->kettle",
        "kettle->bottle",
        "switch->kettle",
    }
    assert (BOTTLE, KETTLE) in graph.components


def test_the_whole_task_gives_a_bottle_of_hot_water_where_it_was() -> None:
    _, log = played()
    for name in (BOTTLE, KETTLE):
        np.testing.assert_allclose(log.states[name][-1][:4], log.states[name][0][:4], atol=1e-3)
    assert log.states[BOTTLE][0, 5] < 0.25
    assert log.states[BOTTLE][-1, 5] > 0.9
    assert log.states[BOTTLE][-1, 4] > 0.95 * log.states[BOTTLE][0, 4]
    into_bottle, into_kettle = log.active[BOTTLE][:, 1], log.active[KETTLE][:, 1]
    assert np.flatnonzero(into_kettle).max() < np.flatnonzero(into_bottle).min()


def test_water_and_heat_are_conserved_in_the_diagram() -> None:
    _, log = played()
    bottle, kettle = Cup.space([KETTLE]).view, Kettle.space([BOTTLE]).view
    water, heat = [], []
    for a, b in ((bottle(s), kettle(t)) for s, t in zip(log.states[BOTTLE], log.states[KETTLE], strict=True)):
        water.append(sum(v.water + v.spilled + v.flow for v in (a, b)))
        heat.append(sum(v.water * v.temperature + v.spilled_heat + v.flow_heat for v in (a, b)) - b.heat_added)
    assert np.ptp(water) < 1e-9
    assert np.ptp(heat) < 1e-9


def steps_of(piece: Demonstration) -> set[str]:
    """Which steps of the solution a piece shows."""
    table, found = piece.table, set()
    change = table.iloc[-1] - table.iloc[0]
    if table["bottle->kettle"].any() and change["kettle.water"] > 0.1:
        found.add("pour")
    if table["switch->kettle"].any():
        found.add("boil")
    if table["kettle->bottle"].any() and change["bottle.water"] > 0.1:
        found.add("return")
    return found


def test_pieces_show_every_interaction_and_none_shows_two_steps() -> None:
    assert len(pieces()) <= 16
    assert len({p.name for p in pieces()}) == len(pieces())
    assert max(len(p) for p in pieces()) * TICK < 65
    for piece in pieces():
        piece.check(scenario().graph, tuple(scenario().graph.objects))
        assert len(steps_of(piece)) <= 1, piece.name
    assert set.union(*(steps_of(p) for p in pieces())) == set(STEPS)
    for edge in scenario().graph.interactions:
        flags = [np.diff(p.table[edge.name].to_numpy()) for p in pieces()]
        assert sum((f > 0).sum() for f in flags) >= 4, edge.name
        assert sum((f < 0).sum() for f in flags) >= 4, edge.name
        assert sum(p.table[edge.name].any() for p in pieces()) >= 4, edge.name


def test_the_commands_can_be_followed_tick_by_tick_and_depend_on_the_seed_alone() -> None:
    first, again, other = (list(script_pieces(np.random.default_rng(s))) for s in (0, 0, 1))
    for a, b, c in zip(first, again, other, strict=True):
        np.testing.assert_array_equal(a.commands, b.commands)
        assert a.start.water != c.start.water or a.start.bottle != c.start.bottle
        steps = np.diff(np.vstack([a.start.hand, a.commands]), axis=0)
        assert np.linalg.norm(steps[:, :3], axis=1).max() < 0.062
        assert np.abs(steps[:, 3:5]).max() < 0.26


def test_a_pour_keeps_the_mouth_where_it_is() -> None:
    for vessel, roll in ((LAYOUT.bottle, -1.9), (LAYOUT.kettle, 1.1)):
        hand = KettleTeleoperation((0.55, 0.0, 0.1, 0.0, FORWARD, 0.0)).grasp(vessel, (0.7, 0.0))
        before = len(hand.commands)
        arm = np.array(vessel.arm())
        mouth = hand.now[:3] + arm
        for row in hand.pour(roll).commands[before:]:
            c, s = np.cos(row[3]), np.sin(row[3])
            turned = np.array([arm[0], c * arm[1] - s * arm[2], s * arm[1] + c * arm[2]])
            np.testing.assert_allclose(row[:3] + turned, mouth, atol=2e-3)


def test_hot_water_in_the_bottle_from_demonstrations_alone() -> None:
    knowledge = learn(scenario().graph, pieces(), spec=QUICK)
    run = GraphRun(scenario(), tuple(scenario().config.goal), number=1)
    run_graph(run, known=knowledge)
    assert run.goal_reached, run.memory and (run.reason, run.memory.log)
    assert run.log is not None
    assert run.log.states[BOTTLE][-1, 4] >= 0.6
    assert run.log.states[BOTTLE][-1, 5] >= 0.9
    assert isinstance(run.plan, Plan)
    edges = [step.chain[-1].name for step in run.plan.steps]
    assert edges.index("bottle->kettle") < edges.index("switch->kettle") < edges.index("kettle->bottle")


def test_bodies_are_given_for_everything_that_is_mechanical() -> None:
    contact = KettleScenario((), "contact")
    world = contact.build_world(contact.start(0), 0)
    episode = Episode(world, Commands(np.array([contact.start(0).hand])))
    episode.run(1)
    log = episode.log()
    for name, shape, place, floor in (
        (BOTTLE, LAYOUT.bottle, contact.start(0).bottle, 0.0),
        (KETTLE, LAYOUT.kettle, contact.start(0).kettle, LAYOUT.plate.height),
    ):
        mouth = contact.camera().to_robot(log.states[name][-1, :3])
        np.testing.assert_allclose(mouth, shape.mouth_at(place, floor), atol=2e-3)
    assert set(contact.drawings()) == {BOTTLE, KETTLE, SWITCH}
    assert set(scenario().drawings()) == {BOTTLE, KETTLE, SWITCH, HAND}


def test_the_hand_carries_the_bottle_around_a_kettle_that_it_never_touched() -> None:
    motion = KettleScenario((), "arm").make_motion()
    assert motion is not None
    assert scenario().make_motion() is None
    hand = np.array([0.70, -0.15, 0.13, 0.0, FORWARD, 1.0])
    over = np.array([*LAYOUT.plate_middle, 0.30, 0.0, FORWARD, 1.0])
    through = motion.planner.path(MotionQuery(hand, over, BOTTLE))
    around = motion.path(MotionQuery(hand, over, BOTTLE))
    top = LAYOUT.plate.height + LAYOUT.kettle.height

    def bottom_near_the_spout(path: np.ndarray) -> float:
        tip = np.array(LAYOUT.kettle.mouth_at(LAYOUT.plate_middle))
        near = np.hypot(path[:, 0] - tip[0], path[:, 1] - tip[1]) < LAYOUT.bottle.radius
        return float(np.min(path[near, 2] - LAYOUT.bottle.hand[1], initial=np.inf))

    assert bottom_near_the_spout(through) < top
    assert bottom_near_the_spout(around) > top
    np.testing.assert_array_equal(around[-1], over)


@pytest.mark.parametrize(
    ("setting", "physics", "says"),
    [
        ("start.bottle=[0.7]", "ideal", "start.bottle"),
        ("start.water=[0.9, 0.2]", "ideal", "start.water"),
        ("start.spread=-1", "ideal", "start.spread"),
        ("fault.stiffness=0", "ideal", "fault.stiffness"),
        ("fault.kind=slip", "contact", "in contact the plant alone moves things"),
        ("fault.kind=flood", "ideal", "flood"),
    ],
)
def test_bad_settings_are_refused_in_a_line(setting: str, physics: str, says: str) -> None:
    with pytest.raises(InputError, match=says) as error:
        KettleScenario((setting,), physics)  # type: ignore[arg-type]
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("fault", ["slip", "knock", "stiff", "dropout"])
def test_every_fault_happens_to_the_run_alone(fault: str) -> None:
    faulty = KettleScenario((f"fault.kind={fault}", "fault.time=[1.0, 1.0]"), "ideal")
    start = dataclasses.replace(faulty.start(0), hand=(0.6, 0.0, 0.3, 0.0, FORWARD, 0.0))
    for world in (faulty.build_world(start, 0), faulty.build_world(start, 0, faulty=True)):
        bottle, kettle, switch = (world.objects[n] for n in (BOTTLE, KETTLE, SWITCH))
        assert isinstance(bottle, Cup)
        assert isinstance(kettle, Kettle)
        seen = {
            "slip": bool(bottle.cup.faults.slips) and bool(kettle.cup.faults.slips),
            "knock": bool(bottle.cup.faults.knocks) and not kettle.cup.faults.knocks,
            "stiff": switch.mount.stiff > 1.0,  # type: ignore[attr-defined]
            "dropout": bool(bottle.settings.dropouts) and bool(kettle.settings.dropouts),
        }
        happens = seen[fault]
        assert sum(seen.values()) == happens
    assert happens


def test_by_contact_the_bottle_alone_is_moved_while_the_hand_is_away() -> None:
    wrong = KettleScenario(("fault.kind=moved", "fault.time=[0.4,0.5]", "noise.scale=0"), "contact", seed=1)
    log = Episode(wrong.make_world(0), Commands(np.tile(wrong.start(0).hand, (12, 1))))
    log.run(12)
    states = log.log().states
    shift = {n: states[n][-1, :3] - states[n][0, :3] for n in (BOTTLE, KETTLE)}
    assert np.linalg.norm(shift[BOTTLE]) == pytest.approx(wrong.config.fault.moved, abs=1e-3)
    assert abs(states[BOTTLE][-1, 3]) < 1e-2, "it stands"
    assert np.linalg.norm(shift[KETTLE]) < 1e-3
    for kind in ("slip", "knock"):
        with pytest.raises(InputError, match=f"fault.kind {kind}: in contact the plant alone moves things"):
            KettleScenario((f"fault.kind={kind}",), "contact", seed=1)
