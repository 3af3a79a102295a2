"""No plan is made again as it was once execution has contradicted it."""

from dataclasses import replace

import numpy as np
import pytest
import toy_models
from toy_models import LAMP_START, TAP_START, lamp, tap
from winding import SHADE_START, shade

from ichain_drake.control.planning.experience import Contradiction, Experience, Record, expected_ticks
from ichain_drake.control.planning.goals import parse_goal
from ichain_drake.control.planning.plan import Plan
from ichain_drake.control.planning.planner import GraphPlanner
from ichain_drake.state import Role, Variable

CASES = {
    "shade": (shade, SHADE_START, "shade.height >= 0.7"),
    "tap": (tap, TAP_START, "cup.water >= 0.5"),
    "lamp": (lamp, LAMP_START, "lamp.light >= 0.5"),
}


def as_it_is(plan: Plan) -> tuple[object, ...]:
    return tuple((s.chain, s.until and s.until[:3], tuple(sorted(s.wanted.items())), s.variant) for s in plan.steps)


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("seed", range(3))
def test_the_same_plan_is_never_made_twice(name: str, seed: int) -> None:
    make, start, text = CASES[name]
    model, rng = make(), np.random.default_rng(seed)
    planner, goal = GraphPlanner(model), parse_goal([text], model, start)
    seen: set[object] = set()
    contradictions: list[Contradiction] = []
    for _ in range(6):
        found = planner.plan(start, goal, Experience(tuple(contradictions)))
        if not isinstance(found, Plan):
            return
        assert as_it_is(found) not in seen
        seen.add(as_it_is(found))
        k = int(rng.integers(len(found.steps)))
        contradictions.append(Contradiction(found.steps[k], start if k == 0 else found.steps[k - 1].predicted))


def test_an_option_that_failed_costs_more_and_is_another_one_until_it_is_left() -> None:
    model = tap()
    planner, goal = GraphPlanner(model), parse_goal(["0.3 <= tank.water <= 0.4"], model, TAP_START)
    first = planner.plan(TAP_START, goal)
    assert isinstance(first, Plan)
    failed = Contradiction(first.steps[0], TAP_START)
    again = planner.plan(TAP_START, goal, Experience((failed,)))
    assert isinstance(again, Plan)
    assert again.steps[0].variant == 1
    assert again.ticks == expected_ticks(first.steps[0].ticks, 1) > first.ticks
    left = planner.plan(TAP_START, goal, Experience((failed, failed)))
    assert not isinstance(left, Plan) or left.steps[0].chain != first.steps[0].chain or len(left.steps) > 1


def test_a_failure_elsewhere_says_nothing() -> None:
    model = tap()
    found = GraphPlanner(model).plan(TAP_START, parse_goal(["cup.x >= 0.9"], model, TAP_START))
    assert isinstance(found, Plan)
    record = Record(model, [Contradiction(found.steps[0], TAP_START)])
    assert record.failures(found.steps[0], TAP_START) == 1
    assert record.failures(found.steps[0], {**TAP_START, "cup": np.array([0.5, 0.05])}) == 0


@pytest.fixture
def placed(monkeypatch: pytest.MonkeyPatch) -> toy_models.ToyModel:
    """The lamp, its dimmer and switch at places of which readings tell."""
    monkeypatch.setattr(toy_models, "X", Variable("x", "m", role=Role("position", frame="table", axis="x")))
    return lamp()


def test_where_there_was_no_way_there_is_none_as_long_as_everything_stands_where_it_did(
    placed: toy_models.ToyModel,
) -> None:
    goal = parse_goal(["dimmer.x >= 0.9"], placed, LAMP_START)
    found = GraphPlanner(placed).plan(LAMP_START, goal)
    assert isinstance(found, Plan)
    (step,) = found.steps
    no_way, elsewhere = Contradiction(step, LAMP_START, "with it"), {**LAMP_START, "switch": np.array([0.9])}
    assert Record(placed, [no_way]).failures(step, LAMP_START) is None
    assert Record(placed, [no_way]).failures(step, elsewhere) == 0, "the switch may have been in the way"
    assert Record(placed, [Contradiction(step, LAMP_START)]).failures(step, elsewhere) == 1
    assert Record(placed, [no_way], final=False).failures(step, LAMP_START) == 1


def test_without_a_way_to_something_nothing_can_be_done_with_it(placed: toy_models.ToyModel) -> None:
    goal = parse_goal(["dimmer.x >= 0.9"], placed, LAMP_START)
    found = GraphPlanner(placed).plan(LAMP_START, goal)
    assert isinstance(found, Plan)
    (step,) = found.steps
    other = replace(step, wanted={("dimmer", "x"): 0.0})
    assert Record(placed, [Contradiction(step, LAMP_START, "with it")]).failures(other, LAMP_START) == 0
    to_it = Record(placed, [Contradiction(step, LAMP_START, "to it")])
    assert to_it.failures(other, LAMP_START) is None
    assert to_it.failures(other, {**LAMP_START, "lamp": np.ones(1)}) is None, "light is in nobody's way"
    assert to_it.failures(other, {**LAMP_START, "dimmer": np.array([0.9])}) == 0


def test_what_may_be_in_the_way_is_moved_even_if_it_acts_on_nothing_that_is_wanted(placed: toy_models.ToyModel) -> None:
    planner, goal = GraphPlanner(placed), parse_goal(["dimmer.x >= 0.9"], placed, LAMP_START)
    found = planner.plan(LAMP_START, goal)
    assert isinstance(found, Plan)
    no_way = Contradiction(found.steps[0], LAMP_START, "to it")
    around = planner.plan(LAMP_START, goal, Experience((no_way,)))
    assert isinstance(around, Plan)
    assert [s.chain[0].child for s in around.steps] == ["switch", "dimmer"]
    moved = [Contradiction(found.steps[0], {**LAMP_START, "switch": np.array([x])}, "to it") for x in (0.1, 0.9)]
    again = planner.plan(LAMP_START, goal, Experience((no_way, *moved)))
    assert isinstance(again, Plan)
    assert [s.chain[0].child for s in again.steps] == ["dimmer"], "nothing helped: by another reading there may be one"
    assert again.steps[0].variant == 1
