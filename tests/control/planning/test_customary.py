"""Conditions that always held when an interaction was shown: asked for once it fails where nothing foretold it."""

from dataclasses import replace
from pathlib import Path

import chest
import numpy as np
import pytest
from chest import DOORWAY, GRAPH, LEAST_OPEN, OPEN, SHUT, Chest, learned, readings, run
from hypothesis import given, settings
from hypothesis import strategies as st

from ichain_drake.control.execution.executor import Memory, Mode
from ichain_drake.control.planning.experience import Experience
from ichain_drake.control.planning.goals import parse_goal
from ichain_drake.control.planning.plan import Plan
from ichain_drake.control.planning.planner import GraphPlanner, SearchSettings
from ichain_drake.demonstrations import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning import InteractionModel, InteractionSpec, learn_interactions
from ichain_drake.learning.library import load_graph, save_graph
from ichain_drake.runs.goals.run import GraphRun
from ichain_drake.state import FloatArray

TAKE, LID, IN = Interaction("hand", "ball"), Interaction("hand", "lid"), Interaction("lid", "ball")
OUT, INTO = "ball.x <= 0.4", "ball.x >= 0.65"


def at_ball(model: InteractionModel, lid: FloatArray) -> dict[str, FloatArray]:
    """A demonstrated grasp, with the lid somewhere, shape (1, n_variables) each."""
    samples = model.edges[TAKE].examples.active
    row = int(np.argmax(model.decide(TAKE, samples)))
    return {n: v[[row]] for n, v in samples.items()} | {"lid": lid[None]}


def test_what_always_held_is_kept_beside_the_classifier() -> None:
    model = learned()[0]
    assert {e: model.customary(e) for e in GRAPH.interactions} == {LID: (), TAKE: ("position of lid",), IN: ()}
    report = model.report()["interactions"]["hand->ball"]["status"]
    assert report["customary"] == ["position of lid"]
    assert "position of lid" not in report["columns"]
    careful = model.cautious([TAKE])
    for lid, as_shown in ((OPEN, True), (SHUT, False)):
        states = at_ball(model, lid)
        assert model.decide(TAKE, states) >= 0
        assert (careful.decide(TAKE, states) >= 0) == as_shown
        assert careful.decide(LID, states) == model.decide(LID, states)
    with pytest.raises(InputError, match="no learned interaction ball->lid"):
        model.cautious([Interaction("ball", "lid")])


def test_the_report_says_what_was_asked_for_in_the_end() -> None:
    model = learned()[0]
    finished = GraphRun(scenario=None, expressions=(OUT,), model=model)  # type: ignore[arg-type]
    assert finished.cautious == {}
    finished.memory = Memory(np.zeros(4), experience=Experience(cautious=(TAKE,)))
    assert finished.cautious == {"hand->ball": ["position of lid"]}


def falls(world: Chest) -> list[int]:
    """Ticks at which the ball was let go of over nothing."""
    held = [r["hand->ball"] for r in world.rows]
    return [
        k for k, r in enumerate(world.rows[1:], 1)
        if held[k - 1] and not held[k] and r["ball.x"] < DOORWAY and r["ball.z"] > 0.03
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("inside", "goal", "motion", "cause"),
    [(True, OUT, False, "lost"), (True, OUT, True, "reach"), (False, INTO, True, "reach")],
)
def test_after_a_failure_that_nothing_foretold_it_is_done_as_it_was_shown(
    inside: bool, goal: str, motion: bool, cause: str
) -> None:
    """Taken through the lid the ball doesn't come along; or the way is blocked, before or after it is taken."""
    world = Chest(77, inside=inside)
    memory = run(world, goal, motion=motion)
    assert (memory.mode, memory.reason, memory.replans) == (Mode.REACHED, "goal reached", 1)
    assert [text.split(":")[0] for _, text in memory.log] == [cause, "cautious"]
    assert memory.log[1][1] == "cautious: hand->ball only as it was shown, by position of lid"
    first, second = memory.plans
    assert [step.chain for step in first.steps] == [(TAKE,)]
    assert [step.chain for step in second.steps] == [(LID,), (TAKE,)]
    assert (first.cautious, second.cautious) == ((), (TAKE,))
    assert world.lid[1] > LEAST_OPEN
    assert (world.ball[0] < DOORWAY) == inside
    assert not falls(world)


def test_where_nothing_fails_nothing_more_is_asked() -> None:
    world = Chest(77, inside=False, lid=OPEN)
    memory = run(world, INTO, motion=True)
    assert (memory.mode, memory.replans, memory.experience.cautious) == (Mode.REACHED, 0, ())
    assert memory.plans[0].cautious == ()


def test_what_slips_on_its_way_is_no_reason_to_ask_for_more() -> None:
    world, slipped = Chest(77, inside=False, lid=OPEN), []
    tick = world.tick

    def slippery(hand: FloatArray, grip: float) -> None:
        tick(hand, grip)
        if world.held == "ball" and world.ball[0] > 0.45 and not slipped:
            world.held = ""
            slipped.append(world.ball.copy())

    world.tick = slippery  # type: ignore[method-assign]
    memory = run(world, INTO)
    assert slipped
    assert (memory.mode, memory.experience.cautious) == (Mode.REACHED, ())
    assert memory.replans >= 1


def test_without_a_plan_as_shown_there_is_the_plan_without() -> None:
    model = learned()[0]
    start = readings(Chest(77, inside=True))
    goal = parse_goal([OUT, "not hand->ball"], model, start)
    short = GraphPlanner(model, SearchSettings(steps=1))
    found = short.plan(start, goal, Experience(cautious=(TAKE,)))
    assert isinstance(found, Plan)
    assert (len(found.steps), found.cautious) == (1, ())
    assert short.plan(start, goal, Experience(cautious=(LID,))).cautious == ()  # type: ignore[union-attr]
    assert len(GraphPlanner(model).plan(start, goal, Experience(cautious=(TAKE,))).steps) == 2  # type: ignore[union-attr]


def test_what_is_held_already_is_put_down_whatever_was_customary() -> None:
    """The grasp is seen by what it is, not by what was customary."""
    model, _, planner = learned()
    world = Chest(77, inside=False, lid=SHUT, firm=False)
    world.go(world.ball, 0.0)
    world.go(world.hand, 1.0)
    world.go(world.hand + [0.05, 0.1, 0.2], 1.0)
    start = readings(world)
    assert model.decide(TAKE, start) >= 0 > model.cautious([TAKE]).decide(TAKE, start)
    found = planner.plan(
        start, parse_goal(["lid.y >= 0.25", "not hand->ball"], model, start), Experience(cautious=(TAKE,))
    )
    assert isinstance(found, Plan)
    assert [s.chain for s in found.steps] == [(TAKE,), (LID,)]


def in_other_words() -> tuple[InteractionGraph, list[Demonstration]]:
    words = {"hand": "zeb", "lid": "aro", "ball": "mul"}
    edges = [f"{words[e.parent]}->{words[e.child]}" for e in reversed(GRAPH.interactions)]
    graph = InteractionGraph({words[n]: s for n, s in reversed(GRAPH.objects.items())}, edges)

    def renamed(column: str) -> str:
        for old, new in words.items():
            column = column.replace(old, new)
        return column

    return graph, [Demonstration(p.table.rename(columns=renamed), {}, p.name) for p in reversed(chest.pieces())]


def test_names_and_order_play_no_part() -> None:
    spec = InteractionSpec(status_estimators=InteractionSpec().status_estimators[:1])
    plain = learn_interactions(chest.pieces(), GRAPH, spec)
    graph, pieces = in_other_words()
    other = learn_interactions(pieces, graph, spec).edges[Interaction("zeb", "mul")].customary
    assert other.labels == ("position of aro",)
    np.testing.assert_array_equal(other.low, plain.edges[TAKE].customary.low)
    np.testing.assert_array_equal(other.high, plain.edges[TAKE].customary.high)


@pytest.fixture(scope="module")
def loaded(tmp_path_factory: pytest.TempPathFactory) -> InteractionModel:
    library = tmp_path_factory.mktemp("library")
    save_graph(learned()[0], library, "chest")
    found = load_graph(library, "chest", GRAPH)
    assert found is not None
    return found


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), rows=st.integers(1, 4))
def test_saved_and_loaded_it_decides_the_same_to_the_last_bit(loaded: InteractionModel, seed: int, rows: int) -> None:
    model, rng = learned()[0], np.random.default_rng(seed)
    states = {n: rng.uniform(model.low[n] - 0.1, model.high[n] + 0.1, (rows, len(model.low[n]))) for n in GRAPH.objects}
    one, other = (m.cautious([TAKE]).decide(TAKE, states) for m in (model, loaded))
    assert one.tobytes() == other.tobytes()
    assert loaded.report() == model.report()


@pytest.mark.parametrize("high", [np.array([1.0]), np.full(3, -9.0)])
def test_conditions_that_fit_no_inputs_are_refused(tmp_path: Path, high: FloatArray) -> None:
    model = learned()[0]
    edge = model.edges[TAKE]
    forged = replace(edge, customary=replace(edge.customary, high=high))
    save_graph(replace(model, edges=model.edges | {TAKE: forged}), tmp_path, "chest")
    with pytest.raises(InputError, match="model.edges, hand->ball, customary: low and high are no ranges"):
        load_graph(tmp_path, "chest", GRAPH)
