"""What can't be frozen, loaded or evaluated is refused with what to do."""

from typing import Any

import numpy as np
import pytest
from sklearn.compose import TransformedTargetRegressor
from sklearn.ensemble import GradientBoostingRegressor, RandomForestClassifier
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, DotProduct, Matern
from sklearn.kernel_ridge import KernelRidge
from sklearn.linear_model import LinearRegression, LogisticRegression, PoissonRegressor, Ridge
from sklearn.neighbors import KNeighborsRegressor
from sklearn.neural_network import MLPRegressor
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import MinMaxScaler, PolynomialFeatures, StandardScaler
from sklearn.svm import SVC, SVR

from ichain_drake.errors import InputError
from ichain_drake.learning.estimators import PolynomialRegressor
from ichain_drake.learning.frozen import FrozenModel, freeze, from_arrays

X = np.random.default_rng(0).normal(size=(30, 2))
Y = X[:, 0] - X[:, 1] ** 2 + 5.0
LABEL = (Y > 4.0).astype(int)

REFUSED = [
    (PoissonRegressor(), "PoissonRegressor can't be frozen; what can be: .*KernelRidge"),
    (make_pipeline(MinMaxScaler(), Ridge()), "MinMaxScaler before Ridge"),
    (make_pipeline(PolynomialFeatures(), SVR()), "PolynomialFeatures before SVR"),
    (make_pipeline(PolynomialFeatures(1), PolynomialRegressor(1)), "PolynomialFeatures before PolynomialRegressor"),
    (KernelRidge(kernel="poly"), "KernelRidge.*rbf.*'poly'"),
    (SVR(kernel="sigmoid"), "SVR.*rbf.*'sigmoid'"),
    (GaussianProcessRegressor(Matern()), "kernel Matern.*can't be frozen"),
    (GaussianProcessRegressor(RBF() + DotProduct()), "can't be frozen; use ConstantKernel"),
    (GaussianProcessRegressor(RBF() * RBF()), "can't be frozen; use ConstantKernel"),
    (KNeighborsRegressor(metric="manhattan"), "Euclidean metric only"),
    (KNeighborsRegressor(weights=lambda d: 1 / (1 + d)), "uniform or distance weights"),
    (TransformedTargetRegressor(Ridge(), func=np.log, inverse_func=np.exp), "StandardScaler transformer only"),
    (MLPRegressor(loss="poisson", hidden_layer_sizes=(3,)), "MLPRegressor.*squared_error"),
    (GradientBoostingRegressor(init=Ridge(), n_estimators=3), "GradientBoostingRegressor.*init"),
]


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize(("estimator", "message"), REFUSED, ids=[m for _, m in REFUSED])
def test_unsupported_estimator_is_named(estimator: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        freeze(estimator.fit(X, Y))


def test_classifiers_need_exactly_two_classes_and_one_output() -> None:
    three = np.arange(30) % 3
    with pytest.raises(InputError, match="LogisticRegression was fitted on 3 class"):
        freeze(LogisticRegression().fit(X, three))
    with pytest.raises(InputError, match="RandomForestClassifier was fitted on 1 class"):
        freeze(RandomForestClassifier(3).fit(X, np.ones(30)))
    with pytest.raises(InputError, match="several outputs"):
        freeze(RandomForestClassifier(3).fit(X, np.column_stack([LABEL, LABEL])))
    with pytest.raises(InputError, match="break_ties"):
        freeze(SVC(break_ties=True, decision_function_shape="ovr").fit(X, LABEL))


@pytest.mark.parametrize("estimator", [Ridge(), make_pipeline(StandardScaler(), Ridge()), PolynomialRegressor()])
def test_unfitted_estimator_is_refused(estimator: Any) -> None:
    with pytest.raises(InputError, match="is not fitted: call fit"):
        freeze(estimator)


def test_what_is_no_estimator_is_refused() -> None:
    with pytest.raises(InputError, match="not an estimator"):
        freeze("Ridge")


def test_wrong_shapes_are_refused() -> None:
    model = freeze(LinearRegression().fit(X, Y))
    with pytest.raises(InputError, match=r"row of 2 inputs is needed, got shape \(3,\)"):
        model.value(np.zeros(3))
    with pytest.raises(InputError, match=r"row of 2 inputs is needed, got shape \(1, 2\)"):
        model.value_and_jacobian(X[:1])
    with pytest.raises(InputError, match=r"shape \(n, 2\) is needed, got \(2,\)"):
        model.batch(X[0])


@pytest.mark.filterwarnings("ignore:lbfgs failed to converge")
def test_damaged_arrays_are_refused() -> None:
    model = freeze(LinearRegression().fit(X, Y))
    arrays = model.arrays()
    with pytest.raises(InputError, match="'cubist': unknown; known are .*polynomial"):
        from_arrays("cubist", arrays)
    with pytest.raises(InputError, match=r"incomplete or misshapen.*weights"):
        from_arrays(model.kind, {k: v for k, v in arrays.items() if k != "weights"})
    with pytest.raises(InputError, match="weights contains NaN"):
        from_arrays(model.kind, arrays | {"weights": arrays["weights"] * np.nan})
    with pytest.raises(InputError, match="not ordered"):
        from_arrays(model.kind, arrays | {"exponents": arrays["exponents"][::-1]})
    with pytest.raises(InputError, match="has no parts"):
        from_arrays("stacked", arrays)
    network = freeze(MLPRegressor(hidden_layer_sizes=(4,), solver="lbfgs", max_iter=5, random_state=0).fit(X, Y))
    with pytest.raises(InputError, match="activation 'sine'"):
        from_arrays(network.kind, network.arrays() | {"activation": np.array("sine")})


def test_an_estimator_of_ones_own_freezes_itself() -> None:
    class Doubled(LinearRegression):
        def predict(self, rows: Any) -> Any:
            return 2.0 * super().predict(rows)

        def to_frozen(self) -> FrozenModel:
            return freeze(LinearRegression().fit(X, 2.0 * Y))

    np.testing.assert_allclose(freeze(Doubled().fit(X, Y)).batch(X)[:, 0], Doubled().fit(X, Y).predict(X))


@pytest.mark.parametrize("shape", [(4, 2), (4, 4), (3,), (2, 3, 4)])
def test_rows_of_another_width_are_refused(shape: tuple[int, ...]) -> None:
    model = freeze(LinearRegression().fit(np.eye(3), np.ones(3)))
    with pytest.raises(InputError, match=r"shape \(n, 3\) is needed, got"):
        model.batch(np.zeros(shape))
    assert model.batch(np.zeros((0, 3))).shape == (0, 1)
