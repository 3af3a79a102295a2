"""States with any leading batch dimensions as rows, and status mappings as arrays of rows."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.state import FloatArray


def flatten(
    states: Mapping[str, FloatArray],
    names: Sequence[str],
    graph: InteractionGraph,
    stands_for: Mapping[str, str] | None = None,
) -> tuple[dict[str, FloatArray], tuple[int, ...]]:
    """States as rows.

    Args:
        states: shape (..., n_variables) per object; leading dimensions broadcast.
        names: objects that are needed.
        graph: names objects and state spaces.
        stands_for: keys of `states` that are further states of an object of another name.

    Returns:
        Arrays of shape (n, n_variables), and the common leading shape, of product n.

    Raises:
        InputError: if a state is missing or has a wrong length.
    """
    arrays = {}
    for name in names:
        obj = (stands_for or {}).get(name, name)
        if name not in states:
            raise InputError(f"the state of {obj} is missing; given are {', '.join(states)}")
        value = np.asarray(states[name], dtype=float)
        space = graph.objects[obj].observable
        if value.ndim == 0 or value.shape[-1] != len(space):
            raise InputError(
                f"state of {obj}: shape {value.shape} given, {len(space)} values needed ({', '.join(space.names)})"
            )
        arrays[name] = value
    shape = np.broadcast_shapes(*(a.shape[:-1] for a in arrays.values()))
    n = math.prod(shape)
    rows = {k: np.broadcast_to(a, (*shape, a.shape[-1])).reshape(n, a.shape[-1]) for k, a in arrays.items()}
    return rows, shape


def forced_status(
    status: Mapping[Interaction, ArrayLike] | None, graph: InteractionGraph, shape: tuple[int, ...], n: int
) -> dict[Interaction, NDArray[np.bool_]]:
    """Status of some interactions as rows, shape (n,) each.

    Raises:
        InputError: for an interaction that the graph lacks.
    """
    out = {}
    for edge, value in (status or {}).items():
        if edge not in graph.edges:
            raise InputError(
                f"{getattr(edge, 'name', edge)!s} is no interaction of the graph; it has "
                f"{', '.join(e.name for e in graph.interactions)}"
            )
        out[edge] = np.broadcast_to(np.asarray(value, dtype=bool), shape).reshape(n)
    return out


def shaped(
    states: Mapping[str, FloatArray], on: Mapping[Interaction, NDArray[np.bool_]], shape: tuple[int, ...]
) -> tuple[dict[str, FloatArray], dict[Interaction, NDArray[np.bool_]]]:
    """States and status of rows, shape (n, ...), in the shape of a batch."""
    return {n: s.reshape(*shape, -1) for n, s in states.items()}, {e: flag.reshape(shape) for e, flag in on.items()}
