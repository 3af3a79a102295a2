"""The library's own estimators, and estimators by name."""

from typing import Any

import numpy as np
import pytest
from scipy.optimize import approx_fprime
from sklearn.base import is_classifier
from sklearn.exceptions import NotFittedError
from sklearn.linear_model import LinearRegression, Ridge
from sklearn.multioutput import MultiOutputRegressor
from sklearn.preprocessing import PolynomialFeatures
from sklearn.svm import SVR
from sklearn.utils.estimator_checks import parametrize_with_checks
from threadpoolctl import threadpool_limits

from ichain_drake.errors import InputError
from ichain_drake.learning.estimators import (
    OWN,
    PolynomialGaussianProcess,
    PolynomialRegressor,
    RectifiedLinearRegressor,
    estimator_names,
    for_outputs,
    make_estimator,
    registry,
)
from ichain_drake.learning.estimators.evidence import Evidence, grams
from ichain_drake.learning.frozen import freeze
from ichain_drake.learning.frozen.monomials import all_exponents
from ichain_drake.learning.spec import InteractionSpec, make_classifier


def expected_failures(estimator: Any) -> dict[str, str]:
    """The one check that feeds 11 samples of 10 features: too few for degree 2, which is refused on purpose."""
    return (
        {"check_regressor_multioutput": "too few samples for degree 2 are refused"}
        if getattr(estimator, "degree", 1) == 2
        else {}
    )


@parametrize_with_checks(
    [
        PolynomialRegressor(degree=1),
        PolynomialRegressor(),
        PolynomialGaussianProcess(degree=1, max_iter=15),
        PolynomialGaussianProcess(max_iter=15),
        RectifiedLinearRegressor(),
    ],
    expected_failed_checks=expected_failures,
)
def test_scikit_learn_contract(estimator: Any, check: Any) -> None:
    check(estimator)


def table(seed: int, n: int = 60) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    x = rng.normal(size=(n, 2)) * [1.0, 3.0] + [0.0, 10.0]
    y = np.column_stack([1 + x[:, 0] * x[:, 1], np.sin(2 * x[:, 0])]) + [0.5, 0.05] * rng.normal(size=(n, 2))
    return x, y


def design(x: np.ndarray, degree: int) -> np.ndarray:
    """Standardised monomials of standardised inputs, written with scikit-learn."""
    z = (x - x.mean(0)) / x.std(0)
    phi = PolynomialFeatures(degree, include_bias=False).fit_transform(z)
    return (phi - phi.mean(0)) / phi.std(0)


@pytest.mark.parametrize("n", [12, 60])
def test_polynomial_leave_one_out_is_exact(n: int) -> None:
    x, y = table(0, n)
    degree = 4  # 15 monomials: fewer and more than the samples
    alphas = [0.01, 1.0, 30.0]
    fitted = PolynomialRegressor(degree, alphas, clip=None).fit(x, y)
    phi = design(x, degree)
    errors = np.empty((len(alphas), 2))
    for a, alpha in enumerate(alphas):
        left_out = np.empty_like(y)
        for i in range(n):
            kept = np.arange(n) != i
            left_out[i] = y[i] - Ridge(alpha, solver="svd").fit(phi[kept], y[kept]).predict(phi[i : i + 1])[0]
        errors[a] = np.sqrt((left_out**2).mean(axis=0))
    np.testing.assert_allclose(fitted.residual_std_, errors.min(axis=0), rtol=1e-8)
    np.testing.assert_array_equal(fitted.alpha_, np.array(alphas)[errors.argmin(axis=0)])
    for o in range(2):
        reference = Ridge(fitted.alpha_[o], solver="svd").fit(phi, y[:, o])
        np.testing.assert_allclose(fitted.predict(x)[:, o], reference.predict(phi), rtol=1e-8)


@pytest.mark.parametrize("n", [12, 60])
def test_polynomial_spread_is_bayesian_linear_regression(n: int) -> None:
    x, y = table(1, n)
    fitted = PolynomialRegressor(4, [0.5], clip=None).fit(x, y)
    phi = design(x, 4)
    inverse = np.linalg.inv(phi.T @ phi + 0.5 * np.eye(phi.shape[1]))
    quadratic = np.einsum("ij,jk,ik->i", phi, inverse, phi)
    _, std = fitted.predict(x, return_std=True)
    expected = fitted.noise_std_ * np.sqrt(1 + 1 / n + quadratic)[:, None]
    np.testing.assert_allclose(std, expected, rtol=1e-7)


def test_polynomial_spread_covers_new_data() -> None:
    x, y = table(2, 400)
    fitted = PolynomialRegressor(2).fit(x, y[:, 0])
    rows, truth = table(3, 2000)
    mean, std = fitted.predict(rows, return_std=True)
    assert mean.shape == std.shape == (2000,)
    inside = np.mean(np.abs(mean - truth[:, 0]) < 2 * std)
    assert 0.93 < inside < 0.975
    np.testing.assert_allclose(fitted.noise_std_, 0.5, rtol=0.1)


def test_clip_keeps_a_polynomial_from_running_away() -> None:
    x, y = table(4)
    fitted = PolynomialRegressor(3, clip=2.0).fit(x, y)
    edge = x.mean(0) + 2.0 * x.std(0)
    np.testing.assert_allclose(fitted.predict([edge + 100.0]), fitted.predict([edge]), rtol=1e-10)
    assert not freeze(fitted).value_and_jacobian(edge + 100.0)[1].any()


def test_constant_inputs_are_harmless() -> None:
    x, y = table(5)
    x = np.column_stack([x, np.full(len(x), 0.1)])
    for estimator in (PolynomialRegressor(2), PolynomialGaussianProcess(2, max_iter=5)):
        mean, std = estimator.fit(x, y).predict(x, return_std=True)
        assert np.isfinite(mean).all()
        assert np.isfinite(std).all()


def test_process_beats_polynomial_and_knows_its_error() -> None:
    rng = np.random.default_rng(0)

    def truth(x: np.ndarray) -> np.ndarray:
        return np.column_stack([np.sin(2 * x[:, 0]) * x[:, 1] + x[:, 2], x[:, 0] ** 2 - x[:, 1]])

    x, rows = rng.uniform(-2, 2, size=(200, 3)), rng.uniform(-2, 2, size=(500, 3))
    y = truth(x) + 0.05 * rng.normal(size=(200, 2))
    process = PolynomialGaussianProcess().fit(x, y)
    mean, std = process.predict(rows, return_std=True)
    error = np.sqrt(((mean - truth(rows)) ** 2).mean(axis=0))
    polynomial = PolynomialRegressor(3).fit(x, y).predict(rows)
    assert error[0] < 0.3 * np.sqrt(((polynomial - truth(rows)) ** 2).mean(axis=0))[0]
    assert (error < 0.06).all()
    np.testing.assert_allclose(process.noise_std_, 0.05, rtol=0.3)
    measured = truth(rows) + 0.05 * rng.normal(size=(500, 2))
    inside = np.mean(np.abs(measured - mean) < 2 * std, axis=0)
    assert ((inside > 0.9) & (inside < 0.99)).all()


def test_process_is_the_textbook_posterior() -> None:
    x, y = table(6, 30)
    fitted = PolynomialGaussianProcess(1, max_iter=8, clip=None).fit(x, y)
    model = fitted.model_
    z, rows = (x - x.mean(0)) / x.std(0), table(7, 10)[0]
    new = (rows - x.mean(0)) / x.std(0)

    def kernel(a: np.ndarray, b: np.ndarray, o: int) -> np.ndarray:
        delta = (a[:, None] - b) / fitted.length_scales_[o]
        trend = 1.0 + model.trend_variance[o, 1] * a @ b.T
        return model.signal_variance[o] * np.exp(-0.5 * (delta**2).sum(-1)) + trend

    mean, std = fitted.predict(rows, return_std=True)
    for o in range(2):
        scaled = (y[:, o] - y[:, o].mean()) / y[:, o].std()
        inverse = np.linalg.inv(kernel(z, z, o) + model.noise_variance[o] * np.eye(30))
        cross = kernel(new, z, o)
        np.testing.assert_allclose(mean[:, o], cross @ inverse @ scaled * y[:, o].std() + y[:, o].mean(), rtol=1e-6)
        variance = kernel(new, new, o) - cross @ inverse @ cross.T + model.noise_variance[o] * np.eye(10)
        np.testing.assert_allclose(std[:, o], np.sqrt(variance.diagonal()) * y[:, o].std(), rtol=1e-6)


def test_process_leave_one_out_is_exact() -> None:
    x, y = table(8, 25)
    fitted = PolynomialGaussianProcess(0, max_iter=8, clip=None).fit(x, y[:, 0])
    theta = np.log([*fitted.length_scales_[0], fitted.model_.signal_variance[0], fitted.model_.noise_variance[0]])
    z, scaled = (x - x.mean(0)) / x.std(0), (y[:, 0] - y[:, 0].mean()) / y[:, 0].std()
    full, _ = Evidence(z, []).kernel(theta)
    errors = []
    for i in range(25):
        kept = np.arange(25) != i
        errors.append(scaled[i] - full[i, kept] @ np.linalg.solve(full[np.ix_(kept, kept)], scaled[kept]))
    np.testing.assert_allclose(fitted.residual_std_[0], np.sqrt(np.mean(np.square(errors))) * y[:, 0].std(), rtol=1e-6)


def test_evidence_gradient_is_its_derivative() -> None:
    rng = np.random.default_rng(1)
    x, y = rng.normal(size=(25, 3)), rng.normal(size=25)
    exponents = all_exponents(3, 2)
    features = np.prod(x[:, None] ** exponents, axis=2)
    evidence = Evidence(x, grams(features, exponents.sum(axis=1)))
    theta = rng.normal(scale=0.5, size=3 + 2 + 2)
    _, gradient = evidence(theta, y)
    numeric = approx_fprime(theta, lambda t: evidence(t, y)[0], 1e-6)
    np.testing.assert_allclose(gradient, numeric, rtol=1e-4, atol=1e-4)


def test_process_samples_are_limited_and_drawn_by_seed() -> None:
    x, y = table(9, 80)
    options = {"max_iter": 3, "search_samples": 20, "max_samples": 50}
    first, again, other = (PolynomialGaussianProcess(1, random_state=s, **options).fit(x, y) for s in (0, 0, 1))
    assert first.model_.centres.shape == (50, 2)
    assert np.array_equal(first.predict(x), again.predict(x))
    assert not np.array_equal(first.predict(x), other.predict(x))


def test_restarts_never_worsen_the_evidence() -> None:
    x, y = table(10, 40)
    z, scaled = (x - x.mean(0)) / x.std(0), (y[:, 1] - y[:, 1].mean()) / y[:, 1].std()
    values = []
    for restarts in (0, 2):
        model = PolynomialGaussianProcess(0, n_restarts=restarts, clip=None).fit(x, y[:, 1])
        theta = np.log([*model.length_scales_[0], model.model_.signal_variance[0], model.model_.noise_variance[0]])
        values.append(Evidence(z, [])(theta, scaled)[0])
    assert values[1] <= values[0] + 1e-9


@pytest.mark.parametrize("make", [lambda: PolynomialRegressor(3), lambda: PolynomialGaussianProcess(1, max_iter=10)])
def test_fit_does_not_depend_on_the_number_of_threads(make: Any) -> None:
    x, y = table(11, 150)
    results = []
    for threads in (1, 2):
        with threadpool_limits(threads):
            results.append(freeze(make().fit(x, y)).arrays())
    assert all(np.array_equal(results[0][name], results[1][name]) for name in results[0])


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_threshold_and_the_slope_beyond_it_are_found_exactly(sign: float) -> None:
    x = np.random.default_rng(3).uniform(-1.0, 1.0, (80, 2))
    y = sign * np.maximum(0.0, 0.7 * x[:, 0] - 0.4 * x[:, 1] - 0.1)
    fitted = RectifiedLinearRegressor(alpha=1e-12).fit(x, y)
    np.testing.assert_allclose(fitted.predict(x), y, atol=1e-9)
    assert not fitted.predict([[-1.0, 1.0]]).any()
    np.testing.assert_array_equal(freeze(fitted).batch(x)[:, 0], fitted.predict(x))


def test_every_output_has_a_threshold_of_its_own() -> None:
    x = np.linspace(-1.0, 1.0, 50)[:, None]
    y = np.column_stack([np.maximum(0.0, x[:, 0]), -np.maximum(0.0, 0.5 - x[:, 0]), np.zeros(50)])
    np.testing.assert_allclose(RectifiedLinearRegressor(alpha=1e-12).fit(x, y).predict(x), y, atol=1e-9)


def test_too_few_samples_for_the_degree() -> None:
    x, y = table(12, 6)
    needed = r"n_samples = 6 for degree 5 \(21 monomials\); at least 7 are needed"
    with pytest.raises(InputError, match="PolynomialRegressor: " + needed):
        PolynomialRegressor(5).fit(x, y)
    with pytest.raises(InputError, match="PolynomialGaussianProcess: " + needed):
        PolynomialGaussianProcess(5).fit(x, y)
    with pytest.raises(InputError, match=r"n_samples = 4 for degree 1.*at least 5"):
        PolynomialRegressor(1).fit(x[:4], y[:4])


@pytest.mark.parametrize(
    ("estimator", "message"),
    [
        (PolynomialRegressor(0), "degree 0"),
        (PolynomialRegressor(1.5), "degree 1.5"),  # type: ignore[arg-type]
        (PolynomialRegressor(alphas=[]), "alphas"),
        (PolynomialRegressor(alphas=[1.0, 0.0]), "alphas"),
        (PolynomialRegressor(clip=0.0), "clip"),
        (PolynomialGaussianProcess(-1), "degree -1"),
        (PolynomialGaussianProcess(clip=-1.0), "clip"),
        (PolynomialGaussianProcess(max_iter=0), "max_iter 0"),
        (PolynomialGaussianProcess(n_restarts=-1), "n_restarts -1"),
        (PolynomialGaussianProcess(search_samples=4), "search_samples 4"),
        (PolynomialGaussianProcess(max_samples=4), "max_samples 4"),
        (RectifiedLinearRegressor(alpha=0.0), "alpha 0.0"),
        (RectifiedLinearRegressor(max_iter=0), "max_iter 0"),
    ],
)
def test_parameters_out_of_range(estimator: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        estimator.fit(*table(13))


def test_unfitted_own_estimators_say_so() -> None:
    for estimator in (PolynomialRegressor(), PolynomialGaussianProcess(), RectifiedLinearRegressor()):
        with pytest.raises(NotFittedError):
            estimator.predict([[0.0, 0.0]])


@pytest.mark.filterwarnings("ignore:lbfgs failed to converge")
@pytest.mark.parametrize("name", OWN)
def test_own_names_learn_several_outputs_and_freeze(name: str) -> None:
    x, y = table(14, 120)
    estimator = make_estimator(name).fit(x, y)
    rows = table(15, 20)[0]
    model = freeze(estimator, residual_std=1.0)
    np.testing.assert_allclose(model.batch(rows), estimator.predict(rows), atol=1e-8)
    # One threshold an output is little for a product of two inputs and a sine.
    assert estimator.score(x, y) > (0.3 if name == "rectified_linear" else 0.5)


def test_make_estimator_passes_parameters() -> None:
    assert make_estimator("polynomial", degree=3).degree == 3
    assert make_estimator("mlp", hidden_layer_sizes=[4]).regressor[-1].hidden_layer_sizes == (4,)
    assert make_estimator("SVR", C=2.5).C == 2.5
    assert is_classifier(make_estimator("SVC"))
    assert {"polynomial", "Ridge", "RandomForestClassifier"} <= set(estimator_names())


@pytest.mark.parametrize(
    ("name", "parameters", "message"),
    [
        ("polynomal", {}, "no estimator 'polynomal'; did you mean polynomial"),
        ("randomforestregressor", {}, "did you mean RandomForestRegressor"),
        ("sklearn.svm.SVR", {}, "there is no estimator"),
        ("os.system", {}, "there is no estimator 'os.system'"),
        ("StandardScaler", {}, "there is no estimator 'StandardScaler'"),
        ("zzzzzzz", {}, "use polynomial, rectified_linear, gaussian_process"),
        ("polynomial", {"order": 3}, "estimator polynomial has no parameter 'order'; it has degree, alphas"),
        ("Ridge", {"lambda_": 1.0}, "estimator Ridge has no parameter 'lambda_'"),
        ("MultiOutputRegressor", {}, "needs the parameter 'estimator'"),
    ],
)
def test_bad_names_and_parameters(name: str, parameters: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        make_estimator(name, **parameters)


def test_for_outputs_wraps_only_where_needed() -> None:
    assert isinstance(for_outputs(SVR(), 2), MultiOutputRegressor)
    assert isinstance(for_outputs(SVR(), 1), SVR)
    for estimator in (LinearRegression(), PolynomialRegressor(), PolynomialGaussianProcess(), make_estimator("mlp")):
        assert for_outputs(estimator, 2) is estimator


def test_usual_candidates_are_made_without_a_walk_through_scikit_learn(monkeypatch: pytest.MonkeyPatch) -> None:
    """It takes a second, in every process that learns."""
    monkeypatch.setattr(registry, "_sklearn_classes", lambda: pytest.fail("all of scikit-learn is imported"))
    spec = InteractionSpec()
    for candidate in (*spec.effect_estimators, *spec.status_estimators):
        make_classifier(candidate)


def test_one_iteration_may_be_asked_for() -> None:
    RectifiedLinearRegressor(max_iter=1).fit(*table(13))


def test_a_process_searches_from_one_start_before_it_draws_others() -> None:
    x, y = table(12, 30)
    first, other = (PolynomialGaussianProcess(0, max_iter=2, random_state=seed).fit(x, y[:, 0]) for seed in (0, 1))
    np.testing.assert_array_equal(first.predict(x), other.predict(x))
