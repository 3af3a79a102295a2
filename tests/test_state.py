"""State spaces: what a variable may be, and arithmetic that respects angles, bounds and hidden variables."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ichain_drake.errors import InputError
from ichain_drake.state import Role, StateSpace, Variable, columns, wrap_angle

POSE = StateSpace(
    "rover",
    (
        Variable("x", "m", -1.0, 1.0, role=Role("position", "map", "x")),
        Variable("heading", "rad", -math.pi, math.pi, "angle", Role("orientation", "map", "z")),
        Variable("drift", "m/s", hidden=True),
        Variable("tilt", "rad", measured_in="plant"),
    ),
)
angles = st.floats(-1e4, 1e4)


@given(angles)
def test_wrapped_angles_are_in_the_half_open_range_and_point_the_same_way(angle: float) -> None:
    wrapped = float(wrap_angle(angle))
    assert -math.pi <= wrapped < math.pi
    assert math.cos(wrapped - angle) == pytest.approx(1.0, abs=1e-9)


def test_wrapping_just_below_the_lower_end_does_not_round_to_the_upper_end() -> None:
    """The remainder of a tiny negative number rounds up to a whole turn."""
    assert wrap_angle(np.nextafter(-math.pi, -10.0)) < math.pi


@given(angles)
def test_an_angle_alone_is_wrapped_as_in_an_array(angle: float) -> None:
    at_end = np.nextafter(-math.pi, -10.0)
    np.testing.assert_array_equal(wrap_angle([angle, at_end]), [wrap_angle(angle), wrap_angle(at_end)])


def test_columns_are_the_variables_of_any_batch() -> None:
    states = np.arange(24.0).reshape(2, 3, 4)
    assert columns(states[0, 0]) == [0.0, 1.0, 2.0, 3.0]
    assert all(np.ndim(value) == 0 and not isinstance(value, np.ndarray) for value in columns(states[0, 0]))
    for i, values in enumerate(columns(states)):
        np.testing.assert_array_equal(values, states[..., i])


@given(angles, angles)
def test_difference_goes_the_short_way_and_leads_back(to: float, start: float) -> None:
    """`start + (to - start)` is `to`, up to whole turns; no angle differs by more than half a turn."""
    delta = POSE.difference([0.5, to, 0, 0], [-0.5, start, 0, 0])
    assert delta[0] == 1.0
    assert abs(delta[1]) <= math.pi
    assert math.cos(start + delta[1] - to) == pytest.approx(1.0, abs=1e-9)


def test_difference_and_clip_take_any_leading_dimensions() -> None:
    state = np.full((2, 3, 4), 5.0)
    assert POSE.difference(state, np.zeros(4)).shape == (2, 3, 4)
    # Bounds hold for x; an angle is not clipped.
    np.testing.assert_array_equal(POSE.clip(state)[0, 0], [1.0, 5.0, 5.0, 5.0])


def test_a_difference_without_angles_is_plain() -> None:
    assert StateSpace("s", (Variable("a"),)).difference([9.0], [1.0]).tolist() == [8.0]


def test_lookups_by_name_and_role() -> None:
    assert len(POSE) == 4
    assert POSE.names == ("x", "heading", "drift", "tilt")
    assert POSE.index("tilt") == 3
    assert POSE.indices(["tilt", "x"]).tolist() == [3, 0]
    assert POSE.role_indices("orientation").tolist() == [1]
    assert POSE.plant_indices.tolist() == [3]
    assert POSE.view([1.0, 2.0, 3.0, 4.0]).drift == 3.0


def test_hidden_variables_are_not_observable() -> None:
    assert POSE.observable.names == ("x", "heading", "tilt")
    assert POSE.observable_indices.tolist() == [0, 1, 3]


def test_a_part_of_a_state_space_can_leave_out_the_amount_that_a_role_refers_to() -> None:
    """A goal may name a temperature alone; the role that needs the amount is dropped, the variable stays."""
    cup = StateSpace(
        "cup",
        (Variable("water", "l", role=Role("amount")), Variable("warm", "C", role=Role("intensive", of="water"))),
    )
    assert cup.subspace(["warm"]).variables == (Variable("warm", "C"),)
    assert cup.subspace(["warm", "water"]).variables[0].role == Role("intensive", of="water")
    hidden = StateSpace("cup", (Variable("water", hidden=True, role=Role("amount")), cup.variables[1]))
    assert hidden.observable.names == ("warm",)


def test_check_returns_floats_and_names_what_is_wrong() -> None:
    assert POSE.check([1, 2, 3, 4], "start").dtype == float
    assert POSE.check(np.zeros((5, 4)), "start").shape == (5, 4)
    with pytest.raises(InputError, match=r"rover start: shape \(3,\).*4 values.*x, heading"):
        POSE.check(np.zeros(3), "rover start")
    with pytest.raises(InputError, match="rover start: heading is not a finite number"):
        POSE.check([[0, 0, 0, 0], [0, np.nan, 0, 0]], "rover start")
    with pytest.raises(InputError, match="x is not a finite number"):
        POSE.check([np.inf, 0, 0, 0], "rover start")


@pytest.mark.parametrize("name", ["", "a.b", "a->b"])
def test_a_variable_name_that_would_break_a_column_is_refused(name: str) -> None:
    with pytest.raises(InputError, match="variable name"):
        Variable(name)


@pytest.mark.parametrize("bounds", [(1.0, 0.0), (math.nan, 1.0)])
def test_bounds_out_of_order_are_refused(bounds: tuple[float, float]) -> None:
    with pytest.raises(InputError, match="variable a: lower bound"):
        Variable("a", "m", *bounds)


def test_a_doubled_variable_is_refused() -> None:
    with pytest.raises(InputError, match="cup: variable a is declared twice"):
        StateSpace("cup", (Variable("a"), Variable("a")))


def test_a_role_that_refers_to_a_missing_amount_is_refused() -> None:
    with pytest.raises(InputError, match="warm refers to water"):
        StateSpace("cup", (Variable("warm", role=Role("intensive", of="water")),))


def test_an_unknown_variable_is_named_with_those_that_exist() -> None:
    with pytest.raises(InputError, match="rover has no variable 'speed'; it has x, heading"):
        POSE.index("speed")


def test_an_angle_that_is_no_number_stays_none():
    assert math.isnan(wrap_angle(math.nan))
    assert math.isnan(wrap_angle(np.array(math.nan)))
    np.testing.assert_array_equal(wrap_angle([4.0, math.nan]), [wrap_angle(4.0), math.nan])
