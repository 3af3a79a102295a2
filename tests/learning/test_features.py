"""Features and codes of change: inverses, derivatives, and what a body's own frame makes invariant."""

from typing import get_args

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ichain_drake.errors import InputError
from ichain_drake.learning.features import ChangeCode, FeatureKind, StateFeatures, planar_poses
from ichain_drake.state import Role, StateSpace, Variable, wrap_angle


def pose(*names: str, frame: str = "f") -> tuple[Variable, ...]:
    x, y, turn = names
    return (
        Variable(turn, "rad", kind="angle", role=Role("orientation", frame, "z")),
        Variable(y, "m", role=Role("position", frame, "y")),
        Variable(x, "m", role=Role("position", frame, "x")),
    )


# Two poses in frames of their own, out of order, with plain variables before, between and after.
SPACE = StateSpace("s", (Variable("a"), *pose("x", "y", "th"), Variable("b"), *pose("u", "v", "ph", frame="g")))
KINDS = get_args(FeatureKind)
states = st.integers(0, 10**6).map(lambda seed: np.random.default_rng(seed).uniform(-3.1, 3.1, (2, 8)))


def central(function: object, at: np.ndarray, step: float = 1e-6) -> np.ndarray:
    columns = [(function(at + d) - function(at - d)) / (2 * step) for d in step * np.eye(len(at))]  # type: ignore[operator]
    return np.stack(columns, axis=-1)


def test_poses_are_found_by_role() -> None:
    assert planar_poses(SPACE) == [(3, 2, 1), (7, 6, 5)]
    assert planar_poses(SPACE.subspace(["x", "y", "ph"])) == []


@pytest.mark.parametrize("names", [SPACE.names, ("a", "y", "x", "th"), ("x", "a", "b", "ph"), ("th", "ph"), ()])
def test_features_are_plain_variables_cosines_and_sines_in_any_order(names: tuple[str, ...]) -> None:
    """Also where the indices of a sort follow on each other, and are taken as one slice."""
    features, rows = StateFeatures(SPACE.subspace(names), "raw"), np.random.default_rng(0).normal(size=(3, len(names)))
    plain, angles = rows[:, features.plain], rows[:, features.angles]
    np.testing.assert_array_equal(features(rows), np.concatenate([plain, np.cos(angles), np.sin(angles)], axis=1))


@pytest.mark.parametrize("kind", KINDS)
@given(pair=states)
def test_decode_inverts_encode(kind: FeatureKind, pair: np.ndarray) -> None:
    code, (start, after) = ChangeCode(SPACE, kind), pair
    back = code.wrap(code.decode(start, code.encode(start, after)))
    np.testing.assert_allclose(SPACE.difference(back, after), 0.0, atol=1e-12)
    assert (np.abs(back[SPACE.angle_mask]) <= np.pi).all()


@pytest.mark.parametrize("kind", KINDS)
@given(pair=states)
def test_encode_inverts_decode(kind: FeatureKind, pair: np.ndarray) -> None:
    code, (start, change) = ChangeCode(SPACE, kind), pair
    np.testing.assert_allclose(code.encode(start, code.decode(start, change)), change, atol=1e-12)


@pytest.mark.parametrize("kind", KINDS)
@given(pair=states)
def test_derivatives_equal_central_differences(kind: FeatureKind, pair: np.ndarray) -> None:
    code, features, (state, change) = ChangeCode(SPACE, kind), StateFeatures(SPACE, kind), pair
    by_state, by_code = code.jacobians(state, change)
    np.testing.assert_allclose(by_state, central(lambda s: code.decode(s, change), state), atol=1e-8)
    np.testing.assert_allclose(by_code, central(lambda c: code.decode(state, c), change), atol=1e-8)
    np.testing.assert_allclose(features.jacobian(state), central(features, state).reshape(-1, 8), atol=1e-8)


@given(pair=states, turn=st.floats(-3.1, 3.1), move=st.tuples(st.floats(-9, 9), st.floats(-9, 9)))
def test_a_body_code_does_not_see_where_the_body_is(pair: np.ndarray, turn: float, move: tuple[float, float]) -> None:
    """Turning and moving start and end together, about any point, changes nothing; for `raw` it does."""
    moved = pair.copy()
    c, s = np.cos(turn), np.sin(turn)
    moved[:, [3, 2]] = pair[:, [3, 2]] @ np.array([[c, s], [-s, c]]) + move
    moved[:, 1] = wrap_angle(pair[:, 1] + turn)
    body = ChangeCode(SPACE, "body")
    np.testing.assert_allclose(body.encode(*moved), body.encode(*pair), atol=1e-9)


def test_body_features_do_not_see_the_position() -> None:
    features, state = StateFeatures(SPACE, "body"), np.arange(8.0)
    shifted = state + np.array([0, 0, 5, -7, 0, 0, 2, 3.0])
    np.testing.assert_array_equal(features(shifted), features(state))
    assert features.names == ("a", "b", "cos(th)", "cos(ph)", "sin(th)", "sin(ph)")
    assert not np.array_equal(StateFeatures(SPACE, "raw")(shifted), StateFeatures(SPACE, "raw")(state))


def test_features_of_a_forward_move_are_forward() -> None:
    """A step of 1 along the heading is (1, 0) in the body's frame, whatever the heading."""
    space = StateSpace("s", pose("x", "y", "th"))
    for heading in (-2.0, 0.3, 3.0):
        start = np.array([heading, 1.0, 2.0])
        after = start + [0.0, np.sin(heading), np.cos(heading)]
        np.testing.assert_allclose(ChangeCode(space, "body").encode(start, after), [0.0, 0.0, 1.0], atol=1e-12)


def test_leading_dimensions_and_empty_features() -> None:
    batch = np.random.default_rng(0).uniform(-3, 3, (2, 5, 8))
    assert StateFeatures(SPACE, "raw")(batch).shape == (2, 5, 10)
    assert StateFeatures(SPACE, "none")(batch).shape == (2, 5, 0)
    assert StateFeatures(SPACE, "none").jacobian(batch).shape == (2, 5, 0, 8)
    code = ChangeCode(SPACE, "body")
    np.testing.assert_array_equal(code.encode(batch[1], batch[0])[2], code.encode(batch[1, 2], batch[0, 2]))


@pytest.mark.parametrize("space", [SPACE, StateSpace("plain", SPACE.variables[:1])])
def test_derivatives_by_features_are_carried_to_the_state(space: StateSpace) -> None:
    features, rng = StateFeatures(space, "raw"), np.random.default_rng(0)
    by_features, at = rng.standard_normal((2, 3, len(features))), rng.uniform(-3, 3, (2, len(space)))
    np.testing.assert_array_equal(features.by_state(by_features, at), by_features @ features.jacobian(at))


@pytest.mark.parametrize("kind", KINDS)
def test_features_of_rows_are_those_of_each_row(kind: FeatureKind) -> None:
    rows = np.random.default_rng(1).uniform(-3, 3, (2, 8))
    features = StateFeatures(SPACE, kind)
    np.testing.assert_array_equal(features(rows), np.stack([features(row) for row in rows]))
    np.testing.assert_allclose(
        StateFeatures(SPACE, "raw")(rows),
        np.c_[rows[:, [0, 2, 3, 4, 6, 7]], np.cos(rows[:, [1, 5]]), np.sin(rows[:, [1, 5]])],
    )


def test_body_features_need_a_pose() -> None:
    with pytest.raises(InputError, match="lamp has no position x, y with an orientation"):
        StateFeatures(StateSpace("lamp", (Variable("glow"),)), "body")
