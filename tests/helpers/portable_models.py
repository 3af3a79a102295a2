"""Frozen models of every kind, and one as an ONNX file by itself."""

import numpy as np
from sklearn.ensemble import ExtraTreesRegressor
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, WhiteKernel
from sklearn.kernel_ridge import KernelRidge
from sklearn.linear_model import LinearRegression, Ridge
from sklearn.multioutput import MultiOutputRegressor
from sklearn.neighbors import KNeighborsRegressor
from sklearn.neural_network import MLPRegressor
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import PolynomialFeatures, StandardScaler
from sklearn.svm import SVR

from ichain_drake.learning.estimators import PolynomialGaussianProcess, PolynomialRegressor
from ichain_drake.learning.estimators.rectified import RectifiedLinearRegressor
from ichain_drake.learning.frozen import FrozenModel
from ichain_drake.learning.portable.frozen import add_frozen
from ichain_drake.learning.portable.graph import OnnxGraph

RNG = np.random.default_rng(0)
X = RNG.normal(size=(40, 3))
Y = np.stack([np.sin(X[:, 0]) + X[:, 1], X[:, 1] * X[:, 2]], axis=1)


def frozen_bytes(model: FrozenModel) -> bytes:
    graph = OnnxGraph("model")
    graph.output("y", add_frozen(graph, model, graph.input("x", model.n_in)), model.n_out)
    return graph.to_bytes({})


ESTIMATORS = {
    "linear": LinearRegression(),
    "cubic": make_pipeline(StandardScaler(), PolynomialFeatures(3), Ridge()),
    "clipped": PolynomialRegressor(2, clip=1.0),
    "rectified": RectifiedLinearRegressor(),
    "kernel": make_pipeline(StandardScaler(), KernelRidge(kernel="rbf", gamma=0.3)),
    "kernels": MultiOutputRegressor(SVR(C=3.0)),
    "process": GaussianProcessRegressor(RBF([1.0, 2.0, 3.0]) + WhiteKernel(0.01), optimizer=None),
    "process with a trend": PolynomialGaussianProcess(2, max_iter=5),
    "relu": MLPRegressor(hidden_layer_sizes=(8, 8), activation="relu", max_iter=20, random_state=0),
    "tanh": MLPRegressor(hidden_layer_sizes=(8,), activation="tanh", max_iter=20, random_state=0),
    "logistic": MLPRegressor(hidden_layer_sizes=(8,), activation="logistic", max_iter=20, random_state=0),
    "identity": MLPRegressor(hidden_layer_sizes=(8,), activation="identity", max_iter=20, random_state=0),
    "neighbours": KNeighborsRegressor(5),
    "near neighbours": KNeighborsRegressor(5, weights="distance"),
    "trees": make_pipeline(StandardScaler(), ExtraTreesRegressor(5, random_state=0)),
}
