"""Where a carried object may be brought: as the goal wants it, and along the places that are known."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from toy_models import LAMP_START, TAP_START, lamp, tap

from ichain_drake.control.planning.carries import CarryOption, find_carries
from ichain_drake.control.planning.goals import parse_goal
from ichain_drake.control.planning.places import _acts_on_goal, _along, _distinct, carry_targets, wanted_place
from ichain_drake.control.planning.plan import Condition
from ichain_drake.control.settings import PLANNING
from ichain_drake.graph import Interaction

FALL, TAKE = Interaction("tank", "cup"), Interaction("robot", "cup")


@pytest.mark.parametrize(
    ("lower", "upper", "x"),
    [
        (0.62, 0.66, 0.64),
        (0.7, math.inf, 1.0),
        (1.2, math.inf, 1.2),
        (-math.inf, 0.3, 0.2),
        (-math.inf, 0.1, 0.0),
        (-math.inf, -0.2, -0.2),
    ],
)
def test_what_the_goal_wants_is_the_middle_of_its_range_or_the_nearest_known_place(
    lower: float, upper: float, x: float
) -> None:
    """The cup stands at 0.2; it was let go of at 0, 0.5 and 1."""
    model = tap()
    (carry,) = find_carries(model)
    found = wanted_place(model, carry, TAP_START, [Condition("cup", "x", lower, upper)])  # type: ignore[arg-type]
    np.testing.assert_allclose(found, [x])
    other = [Condition("cup", "water", 0.5, 1.0), Condition("tank", "water", 0.1, 0.2)]
    assert wanted_place(model, carry, TAP_START, other) is None  # type: ignore[arg-type]


def test_poses_lie_in_even_steps_between_the_outermost_along_the_widest_direction() -> None:
    width = np.array([1.0, 0.1])
    places = np.array([[0.5, 0.05], [0.0, 0.0], [1.0, 0.1], [0.25, 0.025]])
    found = _along(places, width)
    assert found.shape == (PLANNING.line, 2)
    share = np.linspace(0.0, 1.0, PLANNING.line)[:, None]
    np.testing.assert_allclose(found[np.argsort(found[:, 0])], share * [1.0, 0.1], atol=1e-12)


def test_a_line_is_laid_only_for_what_acts_on_something_that_has_to_be_held() -> None:
    model = lamp()
    for text, obj, acts in (
        ("lamp.light >= 0.5", "dimmer", True),
        ("lamp.light >= 0.5", "switch", True),
        ("lamp.light >= 0.5", "lamp", False),
        ("lamp.light <= 0.5", "dimmer", False),  # it is dark already
        ("dimmer.x >= 0.5", "dimmer", False),
    ):
        goal = parse_goal([text], model, LAMP_START)
        assert _acts_on_goal(model, obj, LAMP_START, goal.conditions) is acts, (text, obj)  # type: ignore[arg-type]
    water = parse_goal(["cup.water >= 0.5"], tap(), TAP_START).conditions
    assert not _acts_on_goal(tap(), "tank", TAP_START, water)  # type: ignore[arg-type] # what was filled in stays


def test_places_that_are_as_good_as_the_same_are_one_and_where_it_is_now_is_none() -> None:
    width, here = np.array([2.0, 0.5]), np.array([1.0, 1.0])
    same = PLANNING.same * width
    far = here + [1.0, 0.0]
    found = [here + 0.9 * same, far, far + 0.9 * same, far + [0.0, 1.1 * same[1]], far - [1.1 * same[0], 0.0]]
    kept = _distinct(found, here, width)
    np.testing.assert_allclose(kept, [found[1], found[3], found[4]])


def test_a_carried_object_may_be_brought_where_it_takes_part_and_where_it_does_not() -> None:
    """Water falls at 1, where the cup was let go of before; elsewhere it is out of the way."""
    model = tap()
    (carry,) = find_carries(model)
    (targets,) = carry_targets(model, carry, [TAP_START], TAP_START, ())  # type: ignore[list-item, arg-type]
    np.testing.assert_allclose(sorted(t[0] for t in targets), [0.0, 1.0])
    model.gates[FALL] = lambda s: np.full(len(s["cup"]), -1.0)
    (targets,) = carry_targets(model, carry, [TAP_START], TAP_START, ())  # type: ignore[list-item, arg-type]
    np.testing.assert_allclose([t[0] for t in targets], [0.0])


def test_it_may_be_brought_back_where_it_was_seen_to_stand_though_nobody_ever_put_it_there() -> None:
    """It stood at 0.7 and was knocked to 0.2."""
    model = tap()
    (carry,) = find_carries(model)
    stood = replace(carry, stood=(np.array([0.7]),))
    (targets,) = carry_targets(model, stood, [TAP_START], TAP_START, ())  # type: ignore[list-item, arg-type]
    np.testing.assert_allclose(sorted(t[0] for t in targets), [0.0, 0.7, 1.0])


@pytest.mark.parametrize(("share", "goes_along"), [(0.01, False), (0.5, True)])
def test_what_is_not_asked_for_goes_along_only_where_the_motion_clearly_moves_it(
    share: float, goes_along: bool
) -> None:
    model = tap()
    model.acts[TAKE] = lambda p, q, c: (q[..., :1] - p[..., :1]) * np.array([1.0, share])
    model.edges[TAKE].effects.append(SimpleNamespace(variable=1))
    model.low["cup"], model.high["cup"] = np.zeros(2), np.array([4.0, 1.0])
    carry = CarryOption(TAKE, np.array([0, 1]), np.array([[0.5, 0.3]]))
    start = {**TAP_START, "cup": np.array([0.0, 0.1])}
    found = wanted_place(model, carry, start, [Condition("cup", "x", 0.39, 0.41)])  # type: ignore[arg-type]
    assert found is not None
    np.testing.assert_allclose(found, [0.4, 0.3 - 0.1 * share * goes_along])
