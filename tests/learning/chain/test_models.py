"""Forward and inverse models: one row as a batch, derivatives, noise, limits."""

from typing import get_args

import numpy as np
import pytest

from ichain_drake.learning.chain.models import ActionKind, ForwardModel, InverseModel
from ichain_drake.learning.estimators import make_estimator
from ichain_drake.learning.features import FeatureKind, StateFeatures
from ichain_drake.learning.frozen import FrozenModel, freeze
from ichain_drake.state import Role, StateSpace, Variable

CHILD = StateSpace(
    "child",
    (
        Variable("x", "m", role=Role("position", "f", "x")),
        Variable("y", "m", role=Role("position", "f", "y")),
        Variable("th", "rad", kind="angle", role=Role("orientation", "f", "z")),
        Variable("v", "m/s"),
    ),
)
PARENT = StateSpace("parent", (Variable("p"), Variable("q", "rad", kind="angle")))
RNG = np.random.default_rng(0)


def frozen(n_in: int, n_out: int) -> FrozenModel:
    """Some smooth function."""
    rng = np.random.default_rng(n_in)
    rows = rng.uniform(-2, 2, (200, n_in))
    outputs = np.sin(rows @ rng.standard_normal((n_in, n_out)))
    return freeze(make_estimator("polynomial", degree=2).fit(rows, outputs))


def forward(features: FeatureKind, action: ActionKind) -> ForwardModel:
    n_parent = len(StateFeatures(PARENT, "raw")) * (2 if action == "both" else 1)
    return ForwardModel(
        CHILD, PARENT, features, action, frozen(len(StateFeatures(CHILD, features)) + n_parent, len(CHILD))
    )


def batch(n: int = 6) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    return tuple(np.random.default_rng(1).uniform(-1.5, 1.5, (n, k)) for k in (4, 2, 2))  # type: ignore[return-value]


every_kind = pytest.mark.parametrize(
    ("features", "action"), [(f, a) for f in get_args(FeatureKind) for a in get_args(ActionKind)]
)


@every_kind
def test_linearize_gives_the_prediction_and_its_central_differences(features: FeatureKind, action: ActionKind) -> None:
    model, at = forward(features, action), batch()
    after, *derivatives = model.linearize(*at)
    np.testing.assert_allclose(CHILD.difference(after, model.predict(*at)), 0, atol=1e-12)
    for which, derivative in enumerate(derivatives):
        for column in range(at[which].shape[1]):
            ends = []
            for sign in (1e-6, -1e-6):
                moved = [a.copy() for a in at]
                moved[which][:, column] += sign
                ends.append(model.predict(*moved))
            np.testing.assert_allclose(derivative[..., column], CHILD.difference(*ends) / 2e-6, atol=1e-7)


@every_kind
def test_derivatives_of_a_roll_out_are_those_of_each_tick_to_the_bit(features: FeatureKind, action: ActionKind) -> None:
    model, (child, parent, after) = forward(features, action), batch()
    ticks = [(child[k : k + 1], parent[k : k + 1], after[k : k + 1]) for k in range(len(child))]
    noted = [model.predict_noted(*tick) for tick in ticks]
    together = model.derivatives([note for _, note in noted])
    for k, (tick, (predicted, _)) in enumerate(zip(ticks, noted, strict=True)):
        alone = model.linearize(*tick)
        for given, expected in zip((predicted, *(of[k] for of in together)), alone, strict=True):
            np.testing.assert_array_equal(given, expected)


@every_kind
def test_one_row_equals_the_batch_and_angles_are_wrapped(features: FeatureKind, action: ActionKind) -> None:
    model, (child, parent, after) = forward(features, action), batch()
    child[:, 2] = 3.1
    predicted = model.predict(child, parent, after)
    assert (np.abs(predicted[:, 2]) <= np.pi).all()
    for i in range(len(child)):
        np.testing.assert_allclose(model.predict_row(child[i], parent[i], after[i]), predicted[i], atol=1e-12)


def test_the_action_convention_decides_which_parent_state_counts() -> None:
    child, parent, after = batch()
    for action, by_now, by_next in (("next", False, True), ("current", True, False), ("both", True, True)):
        model = forward("raw", action)  # type: ignore[arg-type]
        plain = model.predict(child, parent, after)
        assert np.array_equal(model.predict(child, parent + 0.1, after), plain) is not by_now
        assert np.array_equal(model.predict(child, parent, after + 0.1), plain) is not by_next


def test_noise_is_that_of_the_coded_change() -> None:
    """In the body's frame: noise along the heading moves the child along its heading."""
    model, (child, parent, after) = forward("body", "next"), batch(3)
    normal, scale = np.zeros((3, 4)), np.array([0.5, 0.2, 0.1, 0.1])
    predicted = model.predict(child, parent, after)
    np.testing.assert_array_equal(model.sample(child, parent, after, normal, scale), predicted)
    normal[:, 0] = 1.0
    moved = CHILD.difference(model.sample(child, parent, after, normal, scale), predicted)
    np.testing.assert_allclose(moved[:, 0], 0.5 * np.cos(child[:, 2]), atol=1e-12)
    np.testing.assert_allclose(moved[:, 1], 0.5 * np.sin(child[:, 2]), atol=1e-12)
    assert model.spread(child, parent, after).shape == (3, 4)


def inverse(limit: float) -> InverseModel:
    n_in = len(StateFeatures(CHILD, "body")) + 2
    ends = np.full(2, limit)
    return InverseModel(CHILD, PARENT, (0, 1), "body", 1, frozen(n_in, 2), -ends, ends)


def test_an_inverse_answers_within_the_demonstrated_range_and_row_by_row_alike() -> None:
    child, wanted = batch()[0], batch()[1]
    free, held = inverse(np.inf)(child, wanted), inverse(0.3)(child, wanted)
    np.testing.assert_array_equal(held, np.clip(free, -0.3, 0.3))
    assert np.abs(free).max() > 0.3
    for i in range(len(child)):
        np.testing.assert_allclose(inverse(np.inf)(child[i : i + 1], wanted[i : i + 1])[0], free[i], atol=1e-12)


def test_an_inverse_in_the_bodys_frame_does_not_see_the_position() -> None:
    child, wanted = batch()[0], batch()[1]
    shift = np.array([3.0, -5.0])
    moved = child + np.append(shift, [0.0, 0.0])
    np.testing.assert_allclose(inverse(9.0)(moved, wanted + shift), inverse(9.0)(child, wanted), atol=1e-9)
    np.testing.assert_array_equal(child, batch()[0])  # the given state is not changed
