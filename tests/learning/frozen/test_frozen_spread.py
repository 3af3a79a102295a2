"""Predictive spreads: exact where the estimator has one, the given constant elsewhere."""

from dataclasses import replace

import numpy as np
import pytest
from sklearn.compose import TransformedTargetRegressor
from sklearn.ensemble import RandomForestRegressor
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel
from sklearn.linear_model import LinearRegression, Ridge
from sklearn.multioutput import MultiOutputRegressor
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler

from ichain_drake.errors import InputError
from ichain_drake.learning.estimators import PolynomialGaussianProcess, PolynomialRegressor
from ichain_drake.learning.frozen import freeze


def table(seed: int, n: int = 40) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    x = rng.normal(size=(n, 2))
    return x, np.column_stack([x[:, 0] ** 2 - x[:, 1], 3 * np.sin(x[:, 1])]) + 0.1 * rng.normal(size=(n, 2))


KERNELS = [
    ConstantKernel(2.0) * RBF([1.0, 0.5]) + WhiteKernel(0.1),
    WhiteKernel(0.02) + RBF(0.8) * ConstantKernel(0.5),
    RBF(0.3),
]


@pytest.mark.parametrize("kernel", KERNELS, ids=str)
@pytest.mark.parametrize("normalize", [False, True])
def test_process_spread_is_sklearns(kernel: object, normalize: bool) -> None:
    x, y = table(0)
    rows = table(1)[0]
    single = make_pipeline(
        StandardScaler(), GaussianProcessRegressor(kernel, optimizer=None, alpha=1e-4, normalize_y=normalize)
    ).fit(x, y)
    _, expected = single.predict(rows, return_std=True)
    expected = expected if expected.ndim == 2 else np.repeat(expected[:, None], 2, axis=1)
    model = freeze(single)
    np.testing.assert_allclose(model.batch_spread(rows), expected, rtol=1e-7)
    np.testing.assert_allclose(model.spread(rows[3]), expected[3], rtol=1e-7)

    fitted = MultiOutputRegressor(
        GaussianProcessRegressor(kernel, alpha=1e-4, normalize_y=normalize, random_state=0)
    ).fit(x, y)
    expected = np.column_stack([part.predict(rows, return_std=True)[1] for part in fitted.estimators_])
    np.testing.assert_allclose(freeze(fitted).batch_spread(rows), expected, rtol=1e-5)


def test_a_given_spread_scales_with_the_outputs() -> None:
    x, y = table(3)
    model = freeze(Ridge().fit(x, y), residual_std=np.array([0.1, 0.4]))
    scaled = model.rescaled(np.array([2.0, 0.5]), np.array([1.0, -1.0]))
    np.testing.assert_allclose(scaled.batch_spread(x), np.tile([0.2, 0.2], (len(x), 1)))
    np.testing.assert_allclose(scaled.batch(x), model.batch(x) * [2.0, 0.5] + [1.0, -1.0])


@pytest.mark.parametrize("make", [PolynomialRegressor, lambda: PolynomialGaussianProcess(1, max_iter=10)])
def test_spread_scales_with_the_target(make: object) -> None:
    x, y = table(2)
    estimator = make()  # type: ignore[operator]
    wrapped = TransformedTargetRegressor(estimator, transformer=StandardScaler()).fit(x, y)
    inner, scale = freeze(wrapped.regressor_), wrapped.transformer_.scale_
    np.testing.assert_allclose(freeze(wrapped).batch_spread(x), inner.batch_spread(x) * scale, rtol=1e-12)


def test_given_residual_std_is_the_spread_of_models_without_one() -> None:
    x, y = table(3)
    forest = RandomForestRegressor(5, random_state=0).fit(x, y)
    model = freeze(forest, residual_std=[0.1, 0.2])
    assert model.has_spread
    np.testing.assert_array_equal(model.batch_spread(x[:4]), np.tile([0.1, 0.2], (4, 1)))
    np.testing.assert_array_equal(freeze(forest, residual_std=0.3).spread(x[0]), [0.3, 0.3])
    assert not freeze(forest).has_spread
    with pytest.raises(InputError, match="no predictive spread.*residual_std"):
        freeze(forest).spread(x[0])


def test_own_spread_goes_before_a_given_one_also_side_by_side() -> None:
    x, y = table(4)
    polynomials = MultiOutputRegressor(PolynomialRegressor()).fit(x, y)
    own = np.column_stack([part.predict(x, return_std=True)[1] for part in polynomials.estimators_])
    np.testing.assert_allclose(freeze(polynomials, residual_std=9.0).batch_spread(x), own, rtol=1e-12)
    mixed = MultiOutputRegressor(make_pipeline(StandardScaler(), RandomForestRegressor(4, random_state=0))).fit(x, y)
    np.testing.assert_array_equal(freeze(mixed, residual_std=[0.5, 0.6]).spread(x[0]), [0.5, 0.6])


@pytest.mark.parametrize("std", [[0.1, 0.2, 0.3], -1.0, np.nan, [[0.1, 0.2]]])
def test_bad_residual_std_is_refused(std: object) -> None:
    x, y = table(5)
    with pytest.raises(InputError, match="residual_std"):
        freeze(Ridge().fit(x, y), residual_std=std)  # type: ignore[arg-type]


def test_a_polynomial_has_a_spread_by_either_of_its_own_and_a_given_one() -> None:
    x, y = table(4)
    line = LinearRegression().fit(x, y)
    assert not freeze(line).has_spread
    assert freeze(line, residual_std=np.array([0.1, 0.4])).has_spread
    own = freeze(PolynomialRegressor(2).fit(x, y))
    assert replace(own, residual_std=None).has_spread
