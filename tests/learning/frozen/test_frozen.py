"""Frozen models predict, differentiate and survive saving exactly as the estimators they were made from."""

import io
import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sklearn.compose import TransformedTargetRegressor
from sklearn.ensemble import (
    ExtraTreesClassifier,
    ExtraTreesRegressor,
    GradientBoostingRegressor,
    RandomForestClassifier,
    RandomForestRegressor,
)
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel
from sklearn.kernel_ridge import KernelRidge
from sklearn.linear_model import (
    ARDRegression,
    BayesianRidge,
    ElasticNet,
    HuberRegressor,
    Lasso,
    LassoCV,
    LinearRegression,
    LogisticRegression,
    Ridge,
    RidgeCV,
)
from sklearn.model_selection import GridSearchCV
from sklearn.multioutput import MultiOutputRegressor
from sklearn.neighbors import KNeighborsRegressor
from sklearn.neural_network import MLPRegressor
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import PolynomialFeatures, StandardScaler
from sklearn.svm import SVC, SVR, LinearSVR, NuSVR
from sklearn.tree import DecisionTreeClassifier, DecisionTreeRegressor

from ichain_drake.errors import InputError
from ichain_drake.learning.estimators import PolynomialGaussianProcess, PolynomialRegressor
from ichain_drake.learning.frozen import FrozenModel, freeze, from_arrays


def process(scales: float | list[float] = 1.5, **options: object) -> GaussianProcessRegressor:
    """A Gaussian process with fixed hyper-parameters: what is tested is freezing, not the search."""
    kernel = ConstantKernel(2.0) * RBF(scales) + WhiteKernel(0.05)
    return GaussianProcessRegressor(kernel, optimizer=None, **options)


def network(activation: str) -> MLPRegressor:
    return MLPRegressor(hidden_layer_sizes=(8, 5), activation=activation, solver="lbfgs", max_iter=20, random_state=0)


def scaled(*steps: object) -> object:
    return make_pipeline(StandardScaler(), *steps)


PER_OUTPUT = {  # predict one output only
    "lasso_cv": lambda: scaled(LassoCV(cv=3)),
    "bayesian_ridge": lambda: scaled(PolynomialFeatures(2), BayesianRidge()),
    "ard": lambda: scaled(PolynomialFeatures(2, include_bias=False), StandardScaler(), ARDRegression()),
    "huber": lambda: scaled(HuberRegressor()),
    "linear_svr": lambda: scaled(LinearSVR()),
    "svr": lambda: scaled(SVR(C=3.0)),
    "svr_linear": lambda: scaled(SVR(kernel="linear")),
    "svr_empty_tube": lambda: scaled(SVR(epsilon=1e3)),
    "nu_svr": lambda: scaled(NuSVR(gamma=0.2)),
    "boosting": lambda: GradientBoostingRegressor(n_estimators=15, random_state=0),
    "boosting_zero": lambda: GradientBoostingRegressor(n_estimators=15, init="zero", random_state=0),
}
SMOOTH = {
    "linear": LinearRegression,
    "ridge": lambda: scaled(PolynomialFeatures(3), StandardScaler(), Ridge(0.1)),
    "ridge_unscaled": lambda: make_pipeline(PolynomialFeatures((2, 2), interaction_only=True), RidgeCV()),
    "only_shifted": lambda: make_pipeline(StandardScaler(with_std=False), Lasso(0.01)),
    "passthrough": lambda: make_pipeline("passthrough", StandardScaler(with_mean=False), ElasticNet(0.01)),
    "grid": lambda: GridSearchCV(scaled(KernelRidge(kernel="rbf")), {"kernelridge__alpha": [0.1, 1.0]}, cv=2),
    "target": lambda: TransformedTargetRegressor(scaled(PolynomialFeatures(2), Ridge()), transformer=StandardScaler()),
    "target_network": lambda: TransformedTargetRegressor(scaled(network("tanh")), transformer=StandardScaler()),
    "target_kernel": lambda: TransformedTargetRegressor(
        scaled(KernelRidge(kernel="rbf", gamma=0.3)), transformer=StandardScaler()
    ),
    "target_process": lambda: TransformedTargetRegressor(process(), transformer=StandardScaler()),
    "kernel_ridge": lambda: KernelRidge(kernel="rbf", alpha=0.1),
    "process": lambda: scaled(process(normalize_y=True)),
    "process_alone": lambda: GaussianProcessRegressor(RBF(0.7), optimizer=None, alpha=1e-6),
    "processes": lambda: MultiOutputRegressor(process([1.0, 2.0, 0.5], normalize_y=True)),
    "processes_fitted": lambda: MultiOutputRegressor(
        GaussianProcessRegressor(
            ConstantKernel(1.0, (0.1, 10.0)) * RBF([1.0] * 3, (0.3, 3.0)) + WhiteKernel(0.1, (0.01, 1.0))
        )
    ),
    "tanh": lambda: scaled(network("tanh")),
    "logistic": lambda: scaled(network("logistic")),
    "identity": lambda: scaled(network("identity")),
    "relu": lambda: scaled(network("relu")),
    "several_scalers": lambda: MultiOutputRegressor(scaled(PolynomialFeatures(2), Ridge())),
    "polynomial": lambda: PolynomialRegressor(3, clip=1.5),
    "polynomials": lambda: MultiOutputRegressor(PolynomialRegressor(2)),
    "polynomial_target": lambda: TransformedTargetRegressor(PolynomialRegressor(2), transformer=StandardScaler()),
    "polynomial_process": lambda: PolynomialGaussianProcess(2, max_iter=5),
    "constant_trend_process": lambda: PolynomialGaussianProcess(0, max_iter=5),
    "distance_neighbours": lambda: scaled(KNeighborsRegressor(4, weights="distance")),
    "all_neighbours": lambda: KNeighborsRegressor(40, weights="distance"),
} | {name: (lambda make=make: MultiOutputRegressor(make())) for name, make in PER_OUTPUT.items() if "boost" not in name}
STEPPED = {
    "tree": lambda: DecisionTreeRegressor(random_state=0),
    "stump": lambda: DecisionTreeRegressor(max_depth=1),
    "forest": lambda: RandomForestRegressor(12, random_state=0),
    "extra_trees": lambda: scaled(ExtraTreesRegressor(12, random_state=0)),
    "boosting": lambda: MultiOutputRegressor(PER_OUTPUT["boosting"]()),
    "boosting_zero": lambda: MultiOutputRegressor(PER_OUTPUT["boosting_zero"]()),
    "target_trees": lambda: TransformedTargetRegressor(
        DecisionTreeRegressor(random_state=0), transformer=StandardScaler()
    ),
    "neighbours": lambda: KNeighborsRegressor(5),
    "target_neighbours": lambda: TransformedTargetRegressor(KNeighborsRegressor(3), transformer=StandardScaler()),
}
ESTIMATORS = SMOOTH | STEPPED
CLASSIFIERS = {
    "svc": lambda: scaled(SVC(C=5.0)),
    "svc_linear": lambda: SVC(kernel="linear"),
    "logistic": lambda: scaled(PolynomialFeatures(2), LogisticRegression()),
    "forest": lambda: RandomForestClassifier(15, random_state=0),
    "extra_trees": lambda: ExtraTreesClassifier(15, random_state=0),
    "tree": lambda: DecisionTreeClassifier(max_depth=3, random_state=0),
}


def table(seed: int, n: int = 40) -> tuple[np.ndarray, np.ndarray]:
    """Inputs with different units and offsets, shape (n, 3), and two outputs, shape (n, 2)."""
    rng = np.random.default_rng(seed)
    x = rng.normal(size=(n, 3)) * [0.5, 1.0, 2.0] + [1.0, -2.0, 3.0]
    y = np.column_stack([np.sin(x[:, 0]) + 0.3 * x[:, 1], 5.0 + x[:, 1] * x[:, 2]]) + 0.05 * rng.normal(size=(n, 2))
    return x, y


def saved_and_loaded(model: FrozenModel) -> FrozenModel:
    """Through a real .npz, without pickle."""
    file = io.BytesIO()
    np.savez(file, **model.arrays())
    file.seek(0)
    with np.load(file, allow_pickle=False) as arrays:
        return from_arrays(model.kind, arrays)


def fit(make: object, seed: int) -> tuple[object, np.ndarray]:
    x, y = table(seed)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # few iterations on purpose
        return make().fit(x, y), table(seed + 1)[0]  # type: ignore[operator]


@pytest.mark.parametrize("name", ESTIMATORS)
@settings(max_examples=3, deadline=None, derandomize=True)
@given(seed=st.integers(0, 10**6))
def test_frozen_equals_predict_and_survives_saving(name: str, seed: int) -> None:
    estimator, rows = fit(ESTIMATORS[name], seed)
    model = freeze(estimator)
    expected = estimator.predict(rows)  # type: ignore[attr-defined]
    size = np.abs(expected).max()
    assert (model.n_in, model.n_out) == (3, 2)
    values = np.array([model.value(row) for row in rows])
    np.testing.assert_allclose(values, expected, rtol=0, atol=1e-9 * size)
    np.testing.assert_allclose(model.batch(rows), values, rtol=0, atol=1e-11 * size)
    by_row = [model.value_and_jacobian(row) for row in rows]
    batch_values, batch_jacobians = model.batch_jacobian(rows)
    np.testing.assert_allclose([v for v, _ in by_row], values, rtol=0, atol=1e-12 * size)
    np.testing.assert_allclose(batch_values, values, rtol=0, atol=1e-12 * size)
    jacobians = np.array([j for _, j in by_row])
    np.testing.assert_allclose(batch_jacobians, jacobians, rtol=0, atol=1e-11 * (size + np.abs(jacobians).max()))

    loaded = saved_and_loaded(model)
    assert np.array_equal(loaded.batch(rows), model.batch(rows))
    for row, value in zip(rows, values, strict=True):
        assert np.array_equal(loaded.value(row), value)
        assert np.array_equal(loaded.value_and_jacobian(row)[1], model.value_and_jacobian(row)[1])
    assert loaded.has_spread == model.has_spread
    if model.has_spread:
        assert np.array_equal(loaded.batch_spread(rows), model.batch_spread(rows))


@pytest.mark.parametrize("name", SMOOTH)
@settings(max_examples=2, deadline=None, derandomize=True)
@given(seed=st.integers(0, 10**6))
def test_jacobian_is_the_derivative(name: str, seed: int) -> None:
    estimator, rows = fit(SMOOTH[name], seed)
    model = freeze(estimator)
    step = 1e-6
    for row in rows[:10]:
        _, jacobian = model.value_and_jacobian(row)
        ahead = np.array([model.value(row + step * e) for e in np.eye(3)]).T
        behind = np.array([model.value(row - step * e) for e in np.eye(3)]).T
        # A kink (relu, clipping, another neighbour) within the step has no derivative to compare with.
        here = model.value(row)[:, None]
        smooth = np.abs((ahead - here) - (here - behind)) < 1e-8 * (1 + np.abs(here))
        assert smooth.mean() > 0.5 or name in {"relu", "distance_neighbours"}
        size = 1e-5 * (1 + np.abs(jacobian).max())
        np.testing.assert_allclose(jacobian[smooth], ((ahead - behind) / (2 * step))[smooth], rtol=0, atol=size)


@pytest.mark.parametrize("name", STEPPED)
def test_piecewise_constant_models_have_zero_jacobian(name: str) -> None:
    estimator, rows = fit(STEPPED[name], 3)
    _, jacobians = freeze(estimator).batch_jacobian(rows)
    assert jacobians.shape == (len(rows), 2, 3)
    assert not jacobians.any()


@pytest.mark.parametrize("labels", [(0, 1), ("off", "on"), (False, True)])
@pytest.mark.parametrize("name", CLASSIFIERS)
def test_classifier_is_positive_for_its_second_class(name: str, labels: tuple[object, object]) -> None:
    x, y = table(5, 120)
    target = np.where(y[:, 1] > y[:, 1].mean(), labels[1], labels[0])
    classifier = CLASSIFIERS[name]().fit(x, target)
    rows = table(6, 60)[0]
    model = freeze(classifier)
    values = model.batch(rows)
    assert values.shape == (60, 1)
    clear = np.abs(values[:, 0]) > 1e-9
    said = np.where(values[:, 0] >= 0, labels[1], labels[0])
    assert (said == classifier.predict(rows))[clear].all()
    assert set(said) == {str(label) for label in labels} or set(said) == set(labels)
    if hasattr(classifier, "decision_function"):
        np.testing.assert_allclose(values[:, 0], classifier.decision_function(rows), atol=1e-9)
    else:
        np.testing.assert_allclose(values[:, 0], classifier.predict_proba(rows)[:, 1] - 0.5, atol=1e-12)
    assert np.array_equal(saved_and_loaded(model).batch(rows), values)


def test_single_output_and_one_neighbour_on_a_point() -> None:
    x, y = table(1)
    model = freeze(KNeighborsRegressor(3, weights="distance").fit(x, y[:, 0]))
    assert model.value(x[4]).shape == (1,)
    assert model.value(x[4])[0] == y[4, 0]
    assert not model.value_and_jacobian(x[4])[1].any()


def test_row_evaluation_repeats_bit_by_bit_for_any_memory_layout() -> None:
    for name in ("ridge", "process", "polynomial_process", "tanh", "forest"):
        estimator, rows = fit(ESTIMATORS[name], 2)
        model = freeze(estimator)
        for row in rows[:5]:
            strided = np.repeat(row, 2)[::2]
            shifted = np.concatenate([[0.0], row])[1:]
            value = model.value(row)
            assert np.array_equal(model.value(strided), value)
            assert np.array_equal(model.value(shifted), value)
            assert np.array_equal(model.value(list(row)), value)


@pytest.mark.filterwarnings("ignore:The optimal value found")
def test_equal_kernels_share_their_centres() -> None:
    x, y = table(2)
    shared = freeze(MultiOutputRegressor(process([1.0, 2.0, 0.5])).fit(x, y))
    own = freeze(MultiOutputRegressor(GaussianProcessRegressor(RBF([1.0] * 3, (0.3, 3.0)), alpha=0.1)).fit(x, y))
    assert (shared.kind, own.kind) == ("gaussian_process", "gaussian_process")
    assert shared.arrays()["length_scales"].shape == (1, 3)
    assert own.arrays()["length_scales"].shape == (2, 3)


def test_far_from_the_origin_kernels_keep_their_digits() -> None:
    x, y = table(4)
    x = x + 1e4
    estimator = KernelRidge(kernel="rbf", gamma=0.5, alpha=0.1).fit(x, y)
    exact = np.exp(-0.5 * ((x[:, None] - x) ** 2).sum(-1)) @ estimator.dual_coef_
    np.testing.assert_allclose(freeze(estimator).batch(x), exact, atol=1e-10)


@pytest.mark.parametrize("rows_each", [1, 3])
@pytest.mark.parametrize("name", ESTIMATORS)
def test_derivatives_of_several_evaluations_at_once_are_those_of_each_to_the_bit(name: str, rows_each: int) -> None:
    estimator, rows = fit(ESTIMATORS[name], 4)
    model = freeze(estimator)
    parts = rows[: 4 * rows_each].reshape(4, rows_each, 3)
    noted = [model.batch_noted(part) for part in parts]
    jacobians = model.jacobians([note for _, note in noted])
    for part, (value, _), jacobian in zip(parts, noted, jacobians, strict=True):
        expected_value, expected = model.batch_jacobian(part)
        np.testing.assert_array_equal(value, expected_value)
        np.testing.assert_array_equal(jacobian, expected)


@pytest.mark.parametrize("name", ["kernel_ridge", "process", "polynomial_process"])
def test_many_rows_are_evaluated_in_parts_and_noted_all_the_same(name: str) -> None:
    estimator, _ = fit(ESTIMATORS[name], 4)
    model, rows = freeze(estimator), table(9, 600)[0]
    (value, note), (expected_value, expected) = model.batch_noted(rows), model.batch_jacobian(rows)
    np.testing.assert_array_equal(value, expected_value)
    np.testing.assert_array_equal(model.jacobians([note])[0], expected)
    np.testing.assert_allclose(model.batch(rows), [model.value(row) for row in rows], atol=1e-11 * np.abs(value).max())


@pytest.mark.parametrize("name", ESTIMATORS)
def test_tables_side_by_side_give_the_bits_of_each_alone_or_are_refused(name: str) -> None:
    estimator, rows = fit(ESTIMATORS[name], 4)
    model = freeze(estimator)
    tables = rows[:41, None]  # an odd number, and more than are evaluated at once
    if not model.takes_batches:
        with pytest.raises(InputError, match="is needed, got"):
            model.batch(tables)
        return
    (values, note), alone = model.batch_noted(tables), [model.batch_noted(part) for part in tables]
    np.testing.assert_array_equal(values, [value for value, _ in alone])
    np.testing.assert_array_equal(model.jacobians([note])[0], [model.jacobians([n])[0] for _, n in alone])
    np.testing.assert_array_equal(model.batch(tables), [model.batch(part) for part in tables])
