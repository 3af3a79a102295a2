"""Frozen models as nodes of an ONNX graph, one function a kind."""

from __future__ import annotations

from functools import singledispatch

import numpy as np

from ichain_drake.errors import InputError
from ichain_drake.learning.frozen.gaussian_process import GaussianProcess
from ichain_drake.learning.frozen.kernel import KernelSum
from ichain_drake.learning.frozen.model import FrozenModel
from ichain_drake.learning.frozen.neighbours import Neighbours
from ichain_drake.learning.frozen.network import Network
from ichain_drake.learning.frozen.polynomial import Polynomial
from ichain_drake.learning.frozen.stacked import Stacked
from ichain_drake.learning.frozen.trees import Trees
from ichain_drake.learning.portable.graph import OnnxGraph
from ichain_drake.learning.status.box import Box

_ACTIVATIONS = {"logistic": "Sigmoid", "tanh": "Tanh", "relu": "Relu"}


def add_frozen(graph: OnnxGraph, model: FrozenModel, inputs: str) -> str:
    """A model's prediction.

    Args:
        graph: grows.
        model: the frozen model.
        inputs: unscaled rows, shape (n, n_in).

    Returns:
        shape (n, n_out).

    Raises:
        InputError: if it is of a kind of somebody's own.
    """
    scaling, z = model.inputs, inputs
    if model.n_in:
        z = graph("Div", graph("Sub", z, scaling.mean), scaling.scale)
        if np.isfinite(scaling.clip):
            z = graph("Min", graph("Max", z, np.float64(-scaling.clip)), np.float64(scaling.clip))
    return _add(model, graph, z)


@singledispatch
def _add(model: FrozenModel, graph: OnnxGraph, z: str) -> str:
    raise InputError(f"a frozen {model.kind} model can't be written as ONNX")


@_add.register
def _(model: Polynomial, graph: OnnxGraph, z: str) -> str:
    # Every monomial is a product of as many entries of [1, z] as the degree says.
    degree = max(int(model.exponents.sum(axis=1).max()), 1)
    slots = np.zeros((degree, len(model.exponents)), dtype=np.int64)
    for j, row in enumerate(model.exponents):
        factors = [i + 1 for i, exponent in enumerate(row) for _ in range(exponent)]
        slots[: len(factors), j] = factors
    padded = graph.join([graph.rows(z, model.n_in, [1.0]), z])
    product = graph.columns(padded, slots[0])
    for factor in slots[1:]:
        product = graph("Mul", product, graph.columns(padded, factor))
    return graph("MatMul", product, model.weights.T)


@_add.register
def _(model: KernelSum, graph: OnnxGraph, z: str) -> str:
    row = graph("Unsqueeze", z, np.array([1]))
    outputs = []
    for block, (centres, scales) in enumerate(zip(model.centres, model.length_scales, strict=True)):
        away = graph("Div", graph("Sub", row, centres), scales)
        squared = graph("ReduceSum", graph("Mul", away, away), np.array([2]), keepdims=0)
        bumps = graph("Exp", graph("Mul", squared, np.float64(-0.5)))
        weights = model.weights if len(model.centres) == 1 else model.weights[[block]]
        outputs.append(graph("MatMul", bumps, weights.T))
    return graph("Add", graph.join(outputs), model.offset)


@_add.register
def _(model: GaussianProcess, graph: OnnxGraph, z: str) -> str:
    first, *more = (_add(part, graph, z) for part in model.mean_parts)
    for part in more:
        first = graph("Add", first, part)
    return first


@_add.register
def _(model: Network, graph: OnnxGraph, z: str) -> str:
    last = len(model.matrices) - 1
    for i, (matrix, bias) in enumerate(zip(model.matrices, model.biases, strict=True)):
        z = graph("Add", graph("MatMul", z, matrix.T), bias)
        if i < last and model.activation in _ACTIVATIONS:
            z = graph(_ACTIVATIONS[model.activation], z)
    return z


@_add.register
def _(model: Neighbours, graph: OnnxGraph, z: str) -> str:
    away = graph("Sub", graph("Unsqueeze", z, np.array([1])), model.points)
    squared = graph("ReduceSum", graph("Mul", away, away), np.array([2]), keepdims=0)
    squared, nearest = graph.smallest(squared, min(int(model.n_neighbours), len(model.points)))
    if bool(model.by_distance):
        distance = graph("Sqrt", squared)
        on_point = graph.numbers(graph("Equal", distance, np.float64(0.0)))
        any_on = graph("Greater", graph("ReduceMax", on_point, np.array([1]), keepdims=1), np.float64(0.0))
        shares = graph("Where", any_on, on_point, graph("Reciprocal", distance))
    else:
        shares = graph("Add", graph("Mul", squared, np.float64(0.0)), np.float64(1.0))
    total = graph("ReduceSum", shares, np.array([1]), keepdims=1)
    weights = graph("Unsqueeze", graph("Div", shares, total), np.array([2]))
    targets = graph("Gather", model.targets, nearest, axis=0)
    return graph("ReduceSum", graph("Mul", weights, targets), np.array([1]), keepdims=0)


@_add.register
def _(model: Stacked, graph: OnnxGraph, z: str) -> str:
    return graph.join([add_frozen(graph, part, z) for part in model.parts])


@_add.register
def _(model: Trees, graph: OnnxGraph, z: str) -> str:
    z = graph.rounded(z)  # as scikit-learn compares
    node = graph.spread_over(z, model.roots)
    for _ in range(int(model.depth)):
        seen = graph("GatherElements", z, graph("Gather", model.features, node), axis=1)
        low = graph.numbers(graph("LessOrEqual", seen, graph("Gather", model.thresholds, node)), whole=True)
        place = graph("Add", node, graph("Mul", low, np.int64(len(model.features))))
        node = graph("Gather", model.children.ravel(), place)
    leaves = graph("Gather", model.leaf_values, node, axis=0)
    return graph("Add", graph("ReduceSum", leaves, np.array([1]), keepdims=0), model.offset)


@_add.register
def _(model: Box, graph: OnnxGraph, z: str) -> str:
    if not model.n_in:
        raise InputError("a box without inputs has no rows; its value is gain + offset")
    inside = graph("Div", graph("Abs", graph("Sub", z, model.middle)), model.half)
    least = graph("Sub", np.float64(1.0), graph("ReduceMax", inside, np.array([1]), keepdims=1))
    return graph("Add", graph("Mul", graph("Min", least, np.float64(1.0)), model.gain), model.offset)
