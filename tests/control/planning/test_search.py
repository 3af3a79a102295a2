"""What a search takes for a step."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from toy_models import TAP_START, tap
from winding import SHADE_START, shade

from ichain_drake.control.planning.goals import parse_goal
from ichain_drake.control.planning.plan import Condition, NoPlan, PlanStep, States
from ichain_drake.control.planning.repertoire import find_repertoire
from ichain_drake.control.planning.search import Search
from ichain_drake.control.planning.search_node import SearchNode
from ichain_drake.control.planning.search_settings import SearchSettings
from ichain_drake.control.planning.side import Side
from ichain_drake.control.planning.simulate import Outcome
from ichain_drake.control.settings import PLANNING
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.state import StateSpace, Variable

TAP, CUP = Interaction("robot", "tap"), Interaction("robot", "cup")
PRESSED = {**TAP_START, "robot": np.array([2.0, 0.0]), "tap": np.ones(1)}


def search(
    *goal: str, start: States = TAP_START, settings: SearchSettings | None = None, record: Any = None, **more: Any
) -> Search:
    """Over the tap's graph: a cup is filled where the tank's water falls while the tap is pressed."""
    model: Any = tap()
    touching = tuple(e for e, on in model.active(start).items() if e.parent == "robot" and on.all())
    wanted = replace(parse_goal(goal, model, start), **more)
    return Search(
        model, settings or SearchSettings(), [Side(model, find_repertoire(model), start, touching)], start, wanted,
        None, touching, record(model) if record else None,
    )  # fmt: skip


def at(states: States, **more: Any) -> SearchNode:
    return SearchNode({n: np.asarray(v, dtype=float) for n, v in states.items()}, (), 0, (), **more)


def chains(found: object) -> list[str]:
    assert isinstance(found, SearchNode), found
    return [s.chain[-1].name + ("" if s.until else " carried") for s in found.steps]


def test_what_holds_needs_no_step_unless_an_interaction_is_not_as_it_should_be() -> None:
    assert chains(search("cup.water <= 0.1").run()) == []
    let_go = search("cup.water <= 0.1", start=PRESSED, inactive=(TAP,)).run()
    assert chains(let_go) == ["robot->tap carried"], "a button under the hand is let go of first"
    assert isinstance(let_go, SearchNode)
    assert let_go.ticks == let_go.steps[0].ticks == PLANNING.retake // 2
    assert let_go.cost == pytest.approx(PLANNING.retake // 2)
    assert let_go.states["tap"][0] == 0.0
    assert let_go.states["robot"][0] != 2.0
    assert let_go.unmet == ()
    assert chains(search("cup.water <= 0.1", start=PRESSED, active=(TAP,)).run()) == [], "or stays where it is"


def test_interactions_that_must_or_must_not_be_active_are_asked_of_each_state() -> None:
    free, pressed = at(TAP_START), at(PRESSED)
    assert search("cup.water <= 0.1")._forbidden([free, pressed]) == [False, False]
    assert search("cup.water <= 0.1", inactive=(TAP,))._forbidden([free, pressed]) == [False, True]
    assert search("cup.water <= 0.1", active=(TAP,))._forbidden([free, pressed]) == [True, False]
    assert search("cup.water <= 0.1", active=(TAP,), inactive=(CUP,))._forbidden([pressed]) == [False]
    assert search("cup.water <= 0.1", active=(TAP,), inactive=(TAP,))._forbidden([free, pressed]) == [True, True]
    assert search("cup.water <= 0.1", inactive=(TAP,))._forbidden([]) == []
    dry = at({**TAP_START, "cup": [0.2, 0.5]})
    asked = search("cup.water <= 0.1", inactive=(TAP,))
    assert asked._done([free, pressed, dry]) == [free]


def test_a_search_says_whether_it_left_anything_out() -> None:
    """The cup has to be brought under the tap first: two steps, and three with the way back."""
    goal = ("cup.water >= 0.5", "cup.x == start")
    found = search(*goal)
    assert chains(found.run()) == ["robot->cup carried", "tank->cup", "robot->cup carried"]
    assert not found.dropped
    for settings in (
        SearchSettings(steps=2),
        *(SearchSettings(expansions=n) for n in (1, 2)),
        SearchSettings(width=1, expansions=2),
    ):
        less = search(*goal, settings=settings)
        failure = less.run()
        assert isinstance(failure, NoPlan)
        assert less.dropped
        assert "was not found to be met" in failure.reason
        assert failure.tree
    assert len(chains(search(*goal, settings=SearchSettings(steps=3)).run())) == 3
    empty = search("cup.water >= 0.5", start={**TAP_START, "tank": np.zeros(2)})
    failure = empty.run()
    assert isinstance(failure, NoPlan)
    assert not empty.dropped
    assert "can't be met" in failure.reason


def test_effort_is_counted_in_states_and_simulated_options() -> None:
    one = search("cup.water >= 0.5", settings=SearchSettings(expansions=1))
    first = at(TAP_START)
    children = one._children([first, first])
    assert one.expansions == 2
    assert one.rollouts >= len(children) > 0
    again = one._expand([first])
    assert one.expansions == 3
    keys = [one._key(n) for n in again]
    assert len(set(keys)) == len(keys), "of like states one is kept"
    assert one._expand([first]) == [], "and none that was seen before"
    assert [n.ticks for n in again] == sorted(n.ticks for n in again)


def test_of_two_ways_to_like_states_the_cheaper_is_kept() -> None:
    one = search("cup.water >= 0.5")
    there = {**TAP_START, "cup": np.array([1.0, 0.05])}
    step = PlanStep((CUP,), predicted=there, ticks=5)
    slow, quick = (replace(at(there), steps=(replace(step, ticks=t),), ticks=t) for t in (30, 20))
    for order in ((slow, quick), (quick, slow)):
        one.closed.clear()
        one._children = lambda layer, order=order: list(order)  # type: ignore[method-assign]
        assert [n.ticks for n in one._expand([at(TAP_START)])] == [20]


@pytest.mark.parametrize(("failures", "ticks"), [(0, 10), (1, 15), (3, 25), (None, None)])
def test_an_option_that_failed_takes_longer_another_way_unless_it_is_left(
    failures: int | None, ticks: int | None
) -> None:
    one = search("cup.water >= 0.5")
    one.record = SimpleNamespace(failures=lambda step, states: failures)  # type: ignore[assignment]
    before = replace(at(TAP_START), steps=(PlanStep((CUP,), ticks=7),), ticks=7, cost=9.0)
    there = {**TAP_START, "cup": np.array([1.0, 0.6])}
    children = one._child(before, PlanStep((CUP,), ticks=10, probability=0.5), there, ())
    if ticks is None:
        assert children == []
        return
    (child,) = children
    assert child.steps[:1] == before.steps
    assert (child.steps[1].ticks, child.steps[1].variant) == (ticks, failures)
    assert (child.ticks, child.cost) == (7 + ticks, pytest.approx(9.0 + 2 * ticks))
    assert child.unmet == ()
    assert one._child(before, PlanStep((CUP,), ticks=10), TAP_START, ())[0].unmet == (0,)


def test_a_carried_object_takes_a_grasp_and_its_way() -> None:
    one = search("cup.x >= 0.9")
    (carry,) = one.sides[0].options.carries
    assert one._way(carry, np.array([0.2]), np.array([0.9])) == 7
    assert one._way(carry, np.array([0.9]), np.array([0.25])) == 7
    assert one._pose(carry, np.array([0.9])) == {("cup", "x"): 0.9}
    found = one.run()
    assert isinstance(found, SearchNode)
    (step,) = found.steps
    place = step.wanted[("cup", "x")]
    assert place >= 0.9
    assert step.after == step.wanted
    assert step.ticks == PLANNING.retake + one._way(carry, np.array([0.2]), np.array([place]))
    assert step.release
    assert found.states["cup"][0] == pytest.approx(place)
    assert step.probability == 1.0, "it is held surely, there too"


def test_where_it_is_to_be_held_the_object_is_not_let_go_of() -> None:
    found = search("cup.x >= 0.9", active=(CUP,)).run()
    assert isinstance(found, SearchNode)
    assert not found.steps[-1].release
    assert found.held == (CUP,)
    assert search("cup.x >= 0.9", inactive=(CUP,))._forbidden([found]) == [True]


def test_what_is_held_where_it_is_wanted_is_let_go_of_there() -> None:
    holding = {**TAP_START, "robot": np.array([1.0, 1.0]), "cup": np.array([1.0, 0.05])}
    assert chains(search("cup.water >= 0.5", start=holding).run()) == ["robot->cup carried", "tank->cup"]


@pytest.mark.parametrize(("way", "steps"), [(0.1, 1), (0.0, 0), (-0.1, 0)])
def test_a_drive_that_does_not_go_its_way_is_no_step(monkeypatch: pytest.MonkeyPatch, way: float, steps: int) -> None:
    made = search("cup.water >= 0.5", start={**TAP_START, "cup": np.array([1.0, 0.05])})
    (side,) = made.sides

    def ends(model: Any, started: Any, *more: Any) -> list[list[Outcome]]:
        out = []
        for states, drive in started:
            driven, after = drive.chain[-1].child, {n: v.copy() for n, v in states.items()}
            after[driven][drive.variable] += drive.direction * way
            out.append([Outcome(after, float(after[driven][drive.variable]), 5)])
        return out

    monkeypatch.setattr("ichain_drake.control.planning.search.simulate", ends)
    found = made._driven(side, [at(made.start)])
    assert len(found) == steps * len(side.options.drives)


def test_a_drive_ends_where_it_was_predicted_to() -> None:
    under = {**TAP_START, "cup": np.array([1.0, 0.05])}
    found = search("cup.water >= 0.5", start=under).run()
    assert isinstance(found, SearchNode)
    (step,) = found.steps
    assert step.until is not None
    assert step.until[:3] == ("cup", "water", 1)
    end = step.until[3]
    assert 0.5 <= end < 0.6
    assert step.wanted == {("cup", "water"): end}
    assert (step.before, step.after) == ({}, {})
    assert step.hold is not None
    assert step.hold[0] == pytest.approx(2.0, abs=0.05)
    assert step.ticks >= PLANNING.retake + (0.5 - 0.05) / 0.04
    assert found.states["cup"][1] == pytest.approx(end, abs=0.05)


def test_a_motion_that_ends_at_a_condition_is_watched_by_what_that_is_about() -> None:
    """However far down the chain: a knob is turned until the shade is up, or for as long as was foreseen."""
    model: Any = shade()
    goal = parse_goal(["shade.height >= 0.6", "knob.angle >= 9"], model, SHADE_START)
    one = Search(
        model, SearchSettings(), [Side(model, find_repertoire(model), SHADE_START)], SHADE_START, goal, None, ()
    )  # fmt: skip
    turn, wind = Interaction("robot", "knob"), Interaction("knob", "shade")
    before = at({**SHADE_START, "shade": np.array([0.3])})
    until = ("knob", "angle", 1, 2.0)
    motion: Any = SimpleNamespace()
    for met, height, expected in ((0, 0.62, ("shade", "height", 1, 0.62)), (0, 0.1, ("shade", "height", -1, 0.1))):
        outcome: Any = SimpleNamespace(met=met, states={**SHADE_START, "shade": np.array([height])}, ticks=9)
        step = one._moving(before, SimpleNamespace(chain=(turn,), motion=motion), outcome, until)  # type: ignore[arg-type]
        assert (step.chain, step.until) == ((turn, wind), expected)
        assert step.wanted == {("shade", "height"): height}
        assert (step.ticks, step.motion) == (PLANNING.retake + 9, motion)
    for met in (None, 1):
        outcome = SimpleNamespace(met=met, states={**SHADE_START, "knob": np.array([2.0])}, ticks=9)
        step = one._moving(before, SimpleNamespace(chain=(turn,), motion=motion), outcome, until)  # type: ignore[arg-type]
        assert (step.chain, step.until) == ((turn,), until), "what it moves itself needs no more"


def test_a_condition_two_links_further_down_is_watched_along_both() -> None:
    spaces = {n: StateSpace(n, (Variable("x"),)) for n in "rabc"}
    graph = InteractionGraph(spaces, ["r->a", "a->b", "b->c"])
    one: Any = SimpleNamespace(model=SimpleNamespace(graph=graph), surer=(Condition("c", "x", 1.0, 2.0),))
    states = {n: np.array([1.5]) for n in "rabc"}
    first = Interaction("r", "a")
    drive: Any = SimpleNamespace(chain=(first,), motion=None)
    outcome: Any = SimpleNamespace(met=0, states=states, ticks=1)
    step = Search._moving(one, at({n: [0.0] for n in "rabc"}), drive, outcome, ("a", "x", 1, 0.5))
    assert [e.name for e in step.chain] == ["r->a", "a->b", "b->c"]
    assert step.until == ("c", "x", 1, 1.5)
