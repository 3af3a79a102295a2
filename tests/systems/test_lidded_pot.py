"""The lidded pot: two hands in one world, honest pieces, and the whole job on `ideal`."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from lidded_pot_pieces import lidded_pot as scenario
from lidded_pot_pieces import lidded_pot_model as model
from lidded_pot_pieces import lidded_pot_pieces as pieces

import ichain_drake as ic
from ichain_drake.control.planning.goals import parse_goal
from ichain_drake.control.planning.plan import NoPlan, Plan
from ichain_drake.control.planning.planner import GraphPlanner
from ichain_drake.demonstrations.overview import inferred_graph
from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction
from ichain_drake.learned_graph import LearnedGraph
from ichain_drake.learning import learn_interactions
from ichain_drake.learning.discovery.labels import label_pieces
from ichain_drake.learning.library.parts import load_parts
from ichain_drake.objects import Jug, Pot
from ichain_drake.remote.messages import command_names
from ichain_drake.robot import HandSpec, IdealHand
from ichain_drake.runs.goals.run import GraphRun, run_graph
from ichain_drake.runs.goals.unlabelled import without_flags
from ichain_drake.scenarios.hand_commands import SeveralHands
from ichain_drake.scenarios.seats import choose_seat
from ichain_drake.simulation.commands import Commands
from ichain_drake.simulation.episode import Episode, EpisodeLog
from ichain_drake.simulation.wiring import look, make_planner, start_command
from ichain_drake.systems.lidded_pot.demonstrations import script_pieces
from ichain_drake.systems.lidded_pot.layout import HANDS, JUG, LEFT, LID, POT, RIGHT
from ichain_drake.systems.lidded_pot.scenario import LiddedPot
from ichain_drake.timing import TICK
from ichain_drake.world import World

NAMES = ("y", "z", "roll", "grip")
STEPS = {"hold", "pour", "let go"}


@cache
def played(held: bool) -> EpisodeLog:
    """The right hand pours while the left one holds the lid open, or rests: only this test knows the task."""
    quiet = LiddedPot(("noise.scale=0",), "ideal", seed=3)
    start = quiet.start(0)
    both = SeveralHands(NAMES, start.hands)
    if held:
        both[LEFT].to(y=0.0, z=0.19).grip(True).to(y=0.14)
    hand = both[RIGHT].to(y=start.jug, z=0.12).grip(True).to(z=0.34).to(y=0.0).to(roll=-1.9).wait(9).to(roll=0.0)
    hand.to(y=start.jug).to(z=0.12).grip(False).to(z=0.3)
    if held:
        both[LEFT].grip(False).to(z=0.3)
    episode = Episode(quiet.build_world(start, 0), Commands(both.commands))
    episode.run(len(both.commands))
    return episode.log()


def test_either_hand_acts_on_lid_and_jug() -> None:
    graph = scenario().graph
    assert graph.roots == HANDS
    assert {e.name for e in graph.interactions} == {
        "left_hand->lid", "right_hand->lid", "left_hand->jug", "right_hand->jug", "lid->pot", "jug->pot"
    }  # fmt: skip


def test_with_the_lid_held_open_water_gets_in_and_with_it_shut_none_does() -> None:
    log = played(True)
    assert log.states[POT][-1, 0] > log.states[POT][0, 0] + 0.6
    np.testing.assert_allclose(log.states[JUG][-1, :3], log.states[JUG][0, :3], atol=1e-6)
    assert log.states[LID][-1, 0] == 0.0
    assert log.active[LID][:, 0].any()
    assert not log.active[LID][:, 1].any()
    shut = played(False)
    assert shut.states[POT][-1, 0] == shut.states[POT][0, 0]
    assert not shut.active[POT].any()


@pytest.mark.parametrize("held", [True, False])
def test_water_is_conserved_in_the_diagram(*, held: bool) -> None:
    log = played(held)
    jug, pot = log.states[JUG], log.states[POT]
    flow, spilled = Jug.state_space.index("flow"), Pot.state_space.index("spilled")
    assert np.ptp(jug[:, 3] + jug[:, flow] + pot[:, 0] + pot[:, spilled]) < 1e-9


def test_each_hand_does_its_part_of_the_command_and_has_noise_of_its_own() -> None:
    world = scenario().make_world(0)
    assert [world.system(h) for h in HANDS] == [world.robots[h] for h in HANDS]
    assert world.robot is world.robots[LEFT]
    start = start_command(world)
    assert start.shape == (8,)
    goal = start + np.array([0.02, 0.0, 0.0, 0.0, 0.0, -0.03, 0.0, 1.0])
    episode = Episode(world, Commands(np.array([goal, goal])))
    episode.run(2)
    log = episode.log()
    np.testing.assert_allclose(np.concatenate([log.states[h][-1] for h in HANDS]), goal, atol=1e-12)
    noise = [log.measured[h][:, :2] - log.states[h][:, :2] for h in HANDS]
    assert np.abs(noise[0] - noise[1]).min() > 0


def steps_of(piece: Demonstration) -> set[str]:
    """Which steps of the solution a piece shows, beside moving one thing about."""
    table, found = piece.table, set()
    if table["jug->pot"].any():
        found.add("pour")
    held = table["left_hand->lid"] + table["right_hand->lid"] > 0
    if (held & (table[f"{LID}.y"] > 0.1)).any():
        found.add("hold")
        ends = np.flatnonzero(np.diff(held.to_numpy().astype(int)) < 0)
        found |= {"let go"} if (table[f"{LID}.y"].to_numpy()[ends] > 0.1).any() else set()
    return found


def test_pieces_show_every_interaction_and_none_the_whole_solution() -> None:
    assert len(pieces()) <= 22
    assert len({p.name for p in pieces()}) == len(pieces())
    assert max(len(p) for p in pieces()) * TICK < 70
    for piece in pieces():
        piece.check(scenario().graph, tuple(scenario().graph.objects))
        assert len(steps_of(piece)) <= 2, piece.name
    assert set.union(*(steps_of(p) for p in pieces())) == STEPS
    for edge in scenario().graph.interactions:
        assert sum(p.table[edge.name].any() for p in pieces()) >= 4, edge.name


def test_pieces_hold_the_commands_of_both_hands() -> None:
    names = [f"command.{h}:{v}" for h in HANDS for v in NAMES]
    assert [c for c in pieces()[0].table.columns if c.startswith("command.")] == names
    table = pieces()[4].table  # both hands grip
    for hand in HANDS:
        sent, there = (table[[f"{who}{v}" for v in NAMES[:2]]].to_numpy() for who in (f"command.{hand}:", f"{hand}."))
        assert np.abs(there[1:] - sent[:-1]).max() < 0.005


def test_the_commands_can_be_followed_and_depend_on_the_seed_alone() -> None:
    home = scenario().config.homes
    first, again, other = (list(script_pieces(np.random.default_rng(s), home)) for s in (0, 0, 1))
    for a, b, c in zip(first, again, other, strict=True):
        np.testing.assert_array_equal(a.commands, b.commands)
        assert a.start.jug != c.start.jug or a.start.water != c.start.water
        start = np.concatenate([a.start.hands[h] for h in HANDS])
        steps = np.abs(np.diff(np.vstack([start, a.commands]), axis=0))
        assert steps[:, [0, 1, 4, 5]].max() < 0.041
        assert steps[:, [2, 6]].max() < 0.26


def test_either_robot_s_part_is_learned_and_robots_have_no_motion_of_their_own() -> None:
    learned = model()
    assert set(learned.passive) == {LID, JUG, POT}
    assert {e.name for e in learned.activations} == {f"{h}->{n}" for h in HANDS for n in (LID, JUG)}
    for hand in HANDS:
        states = {n: 0.5 * (learned.low[n] + learned.high[n]) for n in learned.graph.objects}
        other = next(h for h in HANDS if h != hand)
        there = states[hand] + 0.01
        after, _ = learned.acting(hand).step(states, there, strict=False)
        np.testing.assert_array_equal(after[hand], there)
        np.testing.assert_array_equal(after[other], states[other])
        both, _ = learned.step(states, {hand: there, other: states[other] - 0.01}, strict=False)
        np.testing.assert_array_equal(both[other], states[other] - 0.01)


def test_what_a_spring_shuts_stays_where_a_hand_that_rests_holds_it() -> None:
    learned = model()
    for hand in HANDS:
        samples = dict(learned.edges[Interaction(hand, LID)].examples.active)
        rows = np.flatnonzero((samples[LID][:, 0] > 0.12) & (samples[JUG][:, 1] < 0.13))
        states = {n: v[rows] for n, v in samples.items()}
        other = next(h for h in HANDS if h != hand)
        now = states
        for _ in range(6):
            now, _ = learned.acting(other).step(now, now[other], strict=False)
        assert np.abs(now[LID][:, 0] - states[LID][:, 0]).max() < 0.015
        away = {**states, hand: np.tile([0.3, 0.4, 0.0, 0.0], (len(rows), 1))}
        shut, _ = learned.step(away, away[LEFT], strict=False)
        assert np.abs(shut[LID][:, 0]).max() < 0.01


def test_half_a_pot_of_water_from_demonstrations_alone() -> None:
    run = GraphRun(scenario(), tuple(scenario().config.goal), number=1)
    run_graph(run, known=model())
    assert run.goal_reached, run.memory and (run.reason, run.memory.log)
    assert run.log is not None
    assert run.log.states[POT][-1, 0] >= 0.5
    assert run.log.states[LID][-1, 0] < 0.01
    assert isinstance(run.plan, Plan)
    chains = [[s.chain[0].parent, *(e.child for e in s.chain)] for s in run.plan.steps]
    holder, actor = chains[0][0], chains[1][0]
    assert {holder, actor} == set(HANDS)
    assert chains == [[holder, LID], [actor, JUG, POT], [holder, LID]]
    assert [s.release for s in run.plan.steps] == [False, True, True]


def planned(*goal: str, planner: str = "fast") -> Plan | NoPlan:
    start = look(scenario().make_world(1))
    return make_planner(model(), planner).plan(start, parse_goal(goal, model(), start))


def test_the_jug_is_emptied_into_the_pot_whose_lid_has_to_be_open() -> None:
    """Pot and lid don't act on the jug, but there is nowhere else for its water to go."""
    found = planned("jug.water <= 0.6")
    assert isinstance(found, Plan)
    assert any(step.chain[-1].child == POT for step in found.steps)


@pytest.mark.parametrize("goal", ["lid.y >= 0.05", "lid.y >= 0.13"])
def test_a_lid_that_only_a_hand_keeps_open_is_said_to_be(goal: str) -> None:
    found = planned(goal)
    assert isinstance(found, NoPlan)
    assert "holds only while something is kept hold of" in found.reason


def test_to_keep_hold_of_the_lid_may_be_wanted() -> None:
    run = GraphRun(scenario(), ("left_hand->lid", "lid.y >= 0.1"), number=1)
    run_graph(run, known=model())
    assert run.goal_reached, run.reason
    assert isinstance(run.plan, Plan)
    assert not run.plan.steps[-1].release
    assert run.log is not None
    assert run.log.states[LID][-1, 0] >= 0.1


def test_one_hand_alone_is_refused_with_the_reason(tmp_path: Path) -> None:
    ic.save(model(), tmp_path, "lidded_pot")
    single = LiddedPot(("hands=[right_hand]",), "ideal", seed=70_000)
    assert single.graph.roots == (RIGHT,)
    assert not any(LEFT in text for text in single.config.goal)
    known = load_parts(tmp_path, "lidded_pot", single.graph)
    assert set(known.edges) == set(single.graph.interactions)
    learned = learn_interactions([], single.graph, known=known)
    start = look(single.make_world(0))
    found = GraphPlanner(learned).plan(start, parse_goal(single.config.goal, learned, start))
    assert isinstance(found, NoPlan)
    assert "pot.water >= 0.5 can't be met" in found.reason
    assert "a robot kept lid from going back by itself, and right_hand can't hold lid and jug at once" in found.reason


def test_a_library_of_both_is_loaded_as_it_was_saved(tmp_path: Path) -> None:
    ic.save(model(), tmp_path, "lidded_pot")
    loaded = ic.load(tmp_path, scenario())
    states = {n: 0.5 * (model().low[n] + model().high[n]) for n in model().graph.objects}
    for edge in model().graph.interactions:
        assert loaded.edges[edge].status.decide({n: v[None] for n, v in states.items()}) == model().decide(edge, states)


def test_each_hand_has_a_seat_in_which_the_other_stays() -> None:
    assert set(scenario().seats()) == set(HANDS)
    seat = choose_seat(scenario(), RIGHT)
    assert [a.name for a in seat.axes] == ["right_hand y", "right_hand z", "right_hand roll"]
    hands = start_command(seat.world(900))
    moved = seat.command(np.array([1.0, 0.0, 0.0]), hands, hands)
    np.testing.assert_array_equal(moved[:4], hands[:4])
    assert moved[4] > hands[4]
    (grip,) = seat.toggles
    assert seat.toggle(grip.name, hands).tolist() == [*hands[:7], 1.0]
    assert set(scenario().drawings()) == {LID, JUG, POT, *HANDS}


@pytest.mark.parametrize(
    ("setting", "says"),
    [
        ("hands=[]", "hands: none given; they are left_hand and right_hand, or one of them"),
        ("hands=[third]", "hands: third given"),
        ("homes={left_hand: [0.1], right_hand: [0.1, 0.2]}", "say where left_hand and right_hand are: y, z"),
        ("start.water=[0.9, 0.2]", "start.water"),
        ("fault.kind=knock", "lidded_pot has no fault 'knock'"),
    ],
)
def test_bad_settings_are_refused_in_a_line(setting: str, says: str) -> None:
    with pytest.raises(InputError, match=says) as error:
        LiddedPot((setting,), "ideal")
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("physics", ["arm", "contact"])
def test_two_hands_are_for_ideal_physics(physics: str) -> None:
    with pytest.raises(InputError, match=f"physics {physics} has one arm .* two hands is for ideal"):
        LiddedPot((), physics)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="has one arm, and it has several hands .left_hand and right_hand.; choose"):
        scenario().build_world(scenario().start(0), 0, physics)  # type: ignore[arg-type]


@pytest.mark.parametrize("fault", ["slip", "dropout"])
def test_a_fault_meets_the_run_alone(fault: str) -> None:
    faulty = LiddedPot((f"fault.kind={fault}",), "ideal")
    for happens in (False, True):
        jug = faulty.build_world(faulty.start(0), 0, faulty=happens).objects[JUG]
        assert isinstance(jug, Jug)
        assert bool(jug.jug.slips) == (happens and fault == "slip")
        assert bool(jug.settings.dropouts) == (happens and fault == "dropout")


def test_the_learned_graph_takes_what_each_robot_does() -> None:
    learned, graph = LearnedGraph(model()), model().graph
    start = {n: v[7] for n, v in model().edges[Interaction(LEFT, LID)].examples.active.items()}
    context = learned.CreateDefaultContext()
    learned.set_states(context, start)
    on = model().active(start)
    learned.set_active(context, {e: bool(v) for e, v in on.items()})
    ahead = {LEFT: start[LEFT] - [0.01, 0.0, 0.0, 0.0], RIGHT: start[RIGHT] + [0.0, 0.02, 0.0, 0.0]}
    for name, value in ahead.items():
        learned.GetInputPort(name).FixValue(context, value)
    after, _ = model().step(start, ahead, previous=on)
    context.SetDiscreteState(learned.EvalUniquePeriodicDiscreteUpdate(context))
    assert set(learned.states(context)) == set(graph.objects)
    for name, state in learned.states(context).items():
        np.testing.assert_array_equal(state, after[name])


def test_what_takes_one_robot_says_so() -> None:
    bare = [without_flags(p) for p in pieces()]
    with pytest.raises(InputError, match="inferring flags takes one robot; the graph has left_hand, right_hand"):
        label_pieces(bare, scenario().graph)
    with pytest.raises(InputError, match="a chain that follows paths takes one robot"):
        ic.learn(scenario().graph, pieces(), target=POT, target_variables=("water", "change"))


def test_robots_that_do_not_fit_the_graph_are_refused() -> None:
    world = scenario().make_world(0)
    fresh = scenario().make_world(1)
    with pytest.raises(InputError, match="the graph's robots are left_hand, right_hand; given are left_hand"):
        World(world.graph, {LEFT: fresh.robots[LEFT]}, fresh.objects)
    other = IdealHand(HandSpec(["y", "z"], {"x": 0.6}), scenario().config.robot.home_hand())
    with pytest.raises(InputError, match="robot right_hand: its port state has 2 values, the graph declares 4"):
        World(world.graph, {LEFT: fresh.robots[LEFT], RIGHT: other}, fresh.objects)


def test_tables_alone_tell_which_are_the_robots() -> None:
    graph = inferred_graph(pieces())
    assert graph.roots == HANDS
    assert graph.command.names == scenario().graph.command.names
    assert set(graph.edges) == set(scenario().graph.edges)
    pieces()[0].check(graph)


def test_what_goes_over_a_line_names_each_hand() -> None:
    assert command_names(scenario().graph) == tuple(f"{h}.{v}" for h in HANDS for v in NAMES)
