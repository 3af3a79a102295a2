"""Derivatives through learned models: frozen models on Drake's AutoDiffXd, by value and Jacobian."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydrake.autodiffutils import AutoDiffXd

from ichain_drake.learning.frozen.model import FrozenModel
from ichain_drake.state import FloatArray


def values_of(x: NDArray[Any]) -> FloatArray:
    """The plain numbers in an array of floats or of `AutoDiffXd` (mixed, if need be), in the same shape."""
    if x.dtype != object:
        return x
    floats = np.array([e.value() if isinstance(e, AutoDiffXd) else float(e) for e in x.ravel()])
    return floats.reshape(x.shape)


def chain_rule(value: FloatArray, jacobian: FloatArray, x: NDArray[Any]) -> NDArray[Any]:
    """Put derivatives on a value that was computed in floats.

    Args:
        value: f at the plain numbers in x, shape (n_out,).
        jacobian: df/dx there, shape (n_out, n_in).
        x: inputs, shape (n_in,), AutoDiffXd; plain numbers and constants may be mixed in.

    Returns:
        AutoDiffXd, shape (n_out,), with exactly the given values; derivatives with respect to whatever x's are.
    """
    gradients = [e.derivatives() if isinstance(e, AutoDiffXd) else np.zeros(0) for e in x]
    seeds = np.zeros((len(x), max((len(g) for g in gradients), default=0)))
    for i, g in enumerate(gradients):
        if len(g):  # a constant has an empty gradient
            seeds[i] = g
    chained = jacobian @ seeds
    result = np.empty(len(value), dtype=object)
    for o in range(len(value)):
        result[o] = AutoDiffXd(value[o], chained[o])
    return result


def evaluate(frozen: FrozenModel, x: NDArray[Any]) -> NDArray[Any]:
    """Evaluate a frozen model at one row of floats or of `AutoDiffXd`.

    One float evaluation and one small matrix product (chain rule), instead of AutoDiff arithmetic through every
    monomial or kernel centre.

    Args:
        frozen: the model.
        x: inputs, shape (n_in,), floats or AutoDiffXd (plain numbers may be mixed in).

    Returns:
        shape (n_out,), of floats or AutoDiffXd; derivatives with respect to whatever x's are.

    Raises:
        InputError: on a wrong shape.
    """
    if x.dtype != object:
        return frozen.value(x)
    value, jacobian = frozen.value_and_jacobian(values_of(x))
    return chain_rule(value, jacobian, x)
