"""Two robots: one keeps hold of what would not stay, while the other acts."""

from collections.abc import Mapping

import numpy as np
from toy_models import TWO_HANDS_START, ToyModel, lamp, two_hands

from ichain_drake.control.planning.format import format_plan
from ichain_drake.control.planning.goals import parse_goal
from ichain_drake.control.planning.keeping import find_keeps, missing_hand
from ichain_drake.control.planning.plan import Condition, Goal, NoPlan, Plan
from ichain_drake.control.planning.planner import GraphPlanner
from ichain_drake.graph import Interaction, InteractionGraph

FULL = Condition("bucket", "filled", 0.5, np.inf)


def planned(model: ToyModel, goal: list[str], start: Mapping[str, np.ndarray] = TWO_HANDS_START) -> Plan | NoPlan:
    return GraphPlanner(model).plan(start, parse_goal(goal, model, start))  # type: ignore[arg-type]


def chains(plan: Plan | NoPlan) -> list[str]:
    assert isinstance(plan, Plan), plan.reason
    return ["->".join([s.chain[0].parent, *(e.child for e in s.chain)]) for s in plan.steps]


def alone(model: ToyModel, robot: str) -> ToyModel:
    """The same without the other robot."""
    gone = next(r for r in model.graph.roots if r != robot)
    objects = {n: s for n, s in model.graph.objects.items() if n != gone}
    model.graph = InteractionGraph(objects, [e for e in model.graph.interactions if e.parent != gone])
    model.edges = {e: learned for e, learned in model.edges.items() if e.parent != gone}
    for learned in model.edges.values():
        for part in (learned.examples.active, learned.examples.deactivations.after):
            part.pop(gone, None)
    return model


def test_what_goes_back_by_itself_can_be_kept_hold_of_where_it_makes_something_possible() -> None:
    model = two_hands()
    for robot in model.graph.roots:
        keeps = find_keeps(model.acting(robot))
        assert {(k.edge.name, k.enables.name) for k in keeps} == {
            (f"{robot}->flap", "flap->bucket"),
            (f"{robot}->flap", "valve->bucket"),
        }
        for keep in keeps:
            assert keep.child[0] > 0.3
            assert keep.robot[0] == keep.child[0]


def test_one_robot_alone_keeps_hold_of_nothing() -> None:
    assert not find_keeps(lamp())
    assert not find_keeps(alone(two_hands(), "one"))


def test_one_holds_while_the_other_acts_and_lets_go_in_the_end() -> None:
    plan = planned(two_hands(), ["bucket.filled >= 0.5"])
    first, second, last = chains(plan)
    (holder, actor) = (first.partition("->")[0], second.partition("->")[0])
    assert first == f"{holder}->flap"
    assert second == f"{actor}->valve->bucket"
    assert last == first
    assert holder != actor
    assert isinstance(plan, Plan)
    assert [s.release for s in plan.steps] == [False, True, True]
    kept, done, free = (s.predicted for s in plan.steps)
    assert kept["flap"][0] > 0.3
    assert done["flap"][0] == kept["flap"][0]  # it stays while the other acts
    assert done["bucket"][0] >= 0.5
    assert free["flap"][0] == 0.0
    assert "hold it" in format_plan(plan, two_hands().graph, TWO_HANDS_START)


def test_what_is_held_already_is_not_taken_again_and_let_go_of() -> None:
    start = {**TWO_HANDS_START, "other": np.array([0.6, 0.0, 1.0]), "flap": np.array([0.6])}
    assert chains(planned(two_hands(), ["bucket.filled >= 0.5"], start)) == ["one->valve->bucket", "other->flap"]
    full = {**start, "bucket": np.array([0.8])}
    assert chains(planned(two_hands(), ["bucket.filled >= 0.5"], full)) == ["other->flap"]


def test_with_one_robot_there_is_no_plan_and_the_reason_is_that_it_can_not_hold_both() -> None:
    model = alone(two_hands(), "one")
    start = {n: v for n, v in TWO_HANDS_START.items() if n != "other"}
    found = planned(model, ["bucket.filled >= 0.5"], start)
    assert isinstance(found, NoPlan)
    why = (
        "valve->bucket was active only while a robot kept flap from going back by itself, and one can't hold flap and "
        "valve at once"
    )
    assert found.reason.endswith(why)
    assert missing_hand(model, FULL) == why  # type: ignore[arg-type]


def test_nothing_is_missing_where_nothing_has_to_be_held_or_there_are_two() -> None:
    assert not missing_hand(two_hands(), FULL)  # type: ignore[arg-type]
    assert not missing_hand(lamp(), Condition("lamp", "light", 0.5, np.inf))  # type: ignore[arg-type]


def test_each_robot_holds_one_object_at_a_time() -> None:
    model = two_hands()
    both = tuple(Interaction(r, "valve") for r in model.graph.roots)
    planner = GraphPlanner(model)  # type: ignore[arg-type]
    assert planner._not_in_hand(Goal((), (), both)) is None
    refused = planner._not_in_hand(Goal((), (), (both[0], Interaction("one", "flap"))))
    assert refused is not None
    assert "one object at a time" in refused.reason
