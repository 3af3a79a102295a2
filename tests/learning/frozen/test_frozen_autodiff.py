"""Frozen models on AutoDiffXd: value and Jacobian by the chain rule."""

import numpy as np
import pytest
from pydrake.autodiffutils import AutoDiffXd, ExtractGradient, ExtractValue, InitializeAutoDiff
from sklearn.linear_model import Ridge
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import PolynomialFeatures

from ichain_drake.errors import InputError
from ichain_drake.learned_graph.autodiff import evaluate
from ichain_drake.learning.estimators import PolynomialGaussianProcess
from ichain_drake.learning.frozen import FrozenModel, freeze

RNG = np.random.default_rng(0)
X = RNG.normal(size=(40, 3))
Y = np.column_stack([X[:, 0] * X[:, 1], np.sin(X[:, 2])])


@pytest.fixture(scope="module", params=["polynomial", "process"])
def model(request: pytest.FixtureRequest) -> FrozenModel:
    if request.param == "polynomial":
        return freeze(make_pipeline(PolynomialFeatures(3), Ridge(1e-3)).fit(X, Y))
    return freeze(PolynomialGaussianProcess(1, max_iter=5).fit(X, Y))


def test_floats_give_the_row_evaluation(model: FrozenModel) -> None:
    assert np.array_equal(evaluate(model, X[0]), model.value(X[0]))


def test_gradient_is_the_jacobian_times_the_seeds(model: FrozenModel) -> None:
    seeds = RNG.normal(size=(3, 5))
    result = evaluate(model, InitializeAutoDiff(X[1], seeds).ravel())
    value, jacobian = model.value_and_jacobian(X[1])
    assert np.array_equal(ExtractValue(result).ravel(), value)
    np.testing.assert_allclose(ExtractGradient(result), jacobian @ seeds, rtol=1e-13)


def test_gradient_equals_autodiff_arithmetic_through_the_monomials() -> None:
    coef = RNG.normal(size=(1, 10))
    pipeline = make_pipeline(PolynomialFeatures(2), Ridge()).fit(X, Y[:, 0])
    pipeline[-1].coef_, pipeline[-1].intercept_ = coef, np.array([0.7])
    x = InitializeAutoDiff(X[2]).ravel()
    direct = AutoDiffXd(0.7)
    for weight, powers in zip(coef[0], pipeline[0].powers_, strict=True):
        term = AutoDiffXd(weight)
        for variable, power in zip(x, powers, strict=True):
            for _ in range(power):
                term = term * variable
        direct = direct + term
    result = evaluate(freeze(pipeline), x)
    np.testing.assert_allclose(result[0].value(), direct.value(), rtol=1e-13)
    np.testing.assert_allclose(result[0].derivatives(), direct.derivatives(), rtol=1e-12)


def test_constants_may_be_mixed_in(model: FrozenModel) -> None:
    mixed = np.array([AutoDiffXd(X[3, 0], [1.0, 0.0]), X[3, 1], AutoDiffXd(X[3, 2])], dtype=object)
    result = evaluate(model, mixed)
    jacobian = model.value_and_jacobian(X[3])[1]
    expected = np.column_stack([jacobian[:, 0], np.zeros(2)])
    np.testing.assert_allclose(ExtractGradient(result), expected, rtol=1e-13)


def test_constants_alone_give_no_gradient(model: FrozenModel) -> None:
    result = evaluate(model, np.array([AutoDiffXd(v) for v in X[4]], dtype=object))
    assert np.array_equal([r.value() for r in result], model.value(X[4]))
    assert all(r.derivatives().size == 0 for r in result)


def test_wrong_shape_is_refused(model: FrozenModel) -> None:
    with pytest.raises(InputError, match="row of 3 inputs"):
        evaluate(model, InitializeAutoDiff(np.zeros(2)).ravel())
    with pytest.raises(InputError, match="row of 3 inputs"):
        evaluate(model, InitializeAutoDiff(np.zeros(3)))
