"""What stays where it is let go of, and what has to be held: out of where it was held and where it was let go of."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.stats import norm
from toy_models import TAP_START, tap

from ichain_drake.control.planning.carries import CarryOption
from ichain_drake.control.planning.goals import parse_goal
from ichain_drake.control.planning.letting_go import in_hand, stays
from ichain_drake.control.planning.plan import Condition, NoPlan, Plan
from ichain_drake.control.planning.planner import GraphPlanner
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import StateSpace, Variable

HOLD = Interaction("hand", "cup")
GRAPH = InteractionGraph(
    {
        "hand": StateSpace("hand", (Variable("x", "m"),)),
        "cup": StateSpace("cup", (Variable("x", "m"), Variable("z", "m"), Variable("water"))),
    },
    [HOLD.name],
)
NOISE = 1e-3


def model(lifted: float, rows: int = 100) -> Any:
    """A cup that was held at x from 0 to 1, for a share of the rows at a height of 0.3, else at 0."""
    x = np.linspace(0.0, 1.0, rows)
    z = np.where(np.arange(rows) % 100 < 100 * lifted, 0.3, 0.0)
    held = {"hand": x[:, None] - 0.1, "cup": np.column_stack([x, z, np.full(rows, 0.5)])}
    loose = {"hand": np.full((1, 1), 9.0), "cup": np.array([[0.2, 0.3, 0.5]])}  # a wrong flag
    active = {n: np.concatenate([held[n], loose[n]]) for n in held}
    return SimpleNamespace(
        graph=GRAPH,
        edges={HOLD: SimpleNamespace(examples=SimpleNamespace(active=active), alignment=None, relative=False)},
        decide=lambda edge, states: np.where(states["hand"][:, 0] < 5.0, 1.0, -1.0),
        noise={"cup": np.full(3, NOISE)},
        low={"cup": np.zeros(3)},
        high={"cup": np.ones(3)},
    )


def carry(times: int) -> CarryOption:
    """It was let go of so often, at x from 0.1 to 0.9 and a height of 0."""
    places = np.column_stack([np.linspace(0.1, 0.9, times), np.zeros(times)])
    return CarryOption(HOLD, np.array([0, 1]), places)


@pytest.mark.parametrize("lifted", [0.1, 0.4, 0.7])
def test_where_it_was_held_often_but_never_let_go_of_it_does_not_stay(lifted: float) -> None:
    """How often that takes is the binomial probability's matter, at the declared number of standard errors."""
    needed = int(np.ceil(np.log(norm.sf(LEARNING.sure)) / np.log(1.0 - lifted)))
    place = np.array([0.5, 0.3])
    assert stays(model(lifted), carry(needed - 1), place)
    assert not stays(model(lifted), carry(needed), place)


def test_it_stays_where_it_was_let_go_of_within_noise_and_a_little_further_on() -> None:
    often = carry(50)
    for place, ok in (
        ([0.5, 0.0], True),
        ([0.5, 0.99 * LEARNING.surely * NOISE], True),
        ([0.5, 1.5 * LEARNING.surely * NOISE], False),
        ([1.5, 0.0], False),  # a tenth of the rows were beyond 0.9, and none of 50 times was it let go of there
        ([0.5, -0.1], True),  # it was never held there either
    ):
        assert stays(model(0.5), often, np.array(place)) is ok, place
    assert stays(model(0.5), carry(5), np.array([1.5, 0.0]))


def test_it_stays_where_it_was_seen_to_stand_whoever_put_it_there() -> None:
    shelf = np.array([0.5, 0.3])
    assert not stays(model(0.5), carry(50), shelf)
    assert stays(model(0.5), replace(carry(50), stood=(shelf,)), shelf)
    assert not stays(model(0.5), replace(carry(50), stood=(np.array([0.5, 0.2]),)), shelf), "it hangs above the shelf"


def test_nothing_is_known_of_what_was_never_held_or_never_let_go_of() -> None:
    never = model(0.5)
    never.decide = lambda edge, states: np.full(len(states["hand"]), -1.0)
    place = np.array([0.5, 0.3])
    assert stays(never, carry(50), place)
    assert in_hand(never, carry(50), {"hand": np.zeros(1), "cup": np.zeros(3)}, []) is None
    assert stays(model(0.5), CarryOption(HOLD, np.array([0, 1]), np.zeros((0, 2))), place)


def test_it_is_held_as_in_the_nearest_demonstrated_row_that_the_goal_allows() -> None:
    now = {"hand": np.array([9.0]), "cup": np.array([0.75, 0.0, 0.5])}
    conditions = [
        Condition("cup", "z", 0.25, np.inf),
        Condition("cup", "water", 0.9, 1.0),
        Condition("hand", "x", 5, 6),
    ]
    pose, robot = in_hand(model(0.5), carry(9), now, conditions) or (None, None)
    np.testing.assert_allclose(pose, [49 / 99, 0.3])  # the last row in which it was up
    np.testing.assert_allclose(robot, [49 / 99 - 0.1])
    pose, robot = in_hand(model(0.5), carry(9), now, [Condition("cup", "z", 0.31, 0.4)]) or (None, None)
    np.testing.assert_allclose(pose, [49 / 99, 0.31])  # it was never that high: as near as it was, and on


def test_without_conditions_it_is_held_where_it_is() -> None:
    now = {"hand": np.array([9.0]), "cup": np.array([0.756, 0.01, 0.5])}
    pose, robot = in_hand(model(0.5), carry(9), now, []) or (None, None)
    np.testing.assert_allclose(pose, [0.756, 0.01])
    np.testing.assert_allclose(robot, [75 / 99 - 0.1])


def test_what_is_to_be_held_is_held_in_the_end() -> None:
    toy: Any = tap()
    planner = GraphPlanner(toy)
    plan = planner.plan(TAP_START, parse_goal(["robot->cup", "cup.x >= 0.9"], toy, TAP_START))
    assert isinstance(plan, Plan), plan
    assert not plan.steps[-1].release
    assert toy.decide(Interaction("robot", "cup"), plan.steps[-1].predicted) >= 0
    let_go = planner.plan(TAP_START, parse_goal(["cup.x >= 0.9"], toy, TAP_START))
    assert isinstance(let_go, Plan) and let_go.steps[-1].release


def test_the_robot_ends_with_one_thing_in_hand_and_touches_no_other() -> None:
    toy: Any = tap()
    planner = GraphPlanner(toy)
    for texts, why in (
        (["robot->tap"], "robot->tap: robot ends away from everything but what it holds, and it can't carry tap"),
        (["robot->cup", "robot->tap"], "it holds one object at a time"),
    ):
        found = planner.plan(TAP_START, parse_goal(texts, toy, TAP_START))
        assert isinstance(found, NoPlan)
        assert why in found.reason
