"""Gymnasium's spaces as named variables, and their values as flat arrays, there and back."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ichain_drake.errors import InputError
from ichain_drake.objects.gymnasium.extra import require_gymnasium
from ichain_drake.state import FloatArray, Variable


def _leaves(space: Any, name: str) -> Iterator[tuple[str, Any]]:
    """Simple spaces inside a space, each with a name, in the order in which Gymnasium flattens them."""
    spaces = require_gymnasium("spaces")
    if isinstance(space, spaces.Dict):
        for key, inner in space.spaces.items():
            yield from _leaves(inner, f"{name}_{key}" if name else str(key))
    elif isinstance(space, spaces.Tuple):
        for k, inner in enumerate(space.spaces):
            yield from _leaves(inner, f"{name}_{k}" if name else str(k))
    elif isinstance(space, spaces.Box | spaces.Discrete | spaces.MultiDiscrete | spaces.MultiBinary):
        yield name, space
    else:
        raise InputError(
            f"a space of kind {type(space).__name__} has no fixed number of values; say which variables to read"
        )


def space_size(space: Any) -> int:
    """How many numbers a value of a space is.

    Raises:
        InputError: if that is not fixed (text, graphs, sequences).
    """
    return sum(int(np.prod(leaf.shape, dtype=int)) for _, leaf in _leaves(space, ""))


def space_variables(space: Any, name: str) -> tuple[Variable, ...]:
    """One variable for each number in a space, with the space's bounds.

    Args:
        space: a Gymnasium space.
        name: what the variables are called; several are numbered, those of a dictionary carry its keys.

    Raises:
        InputError: if the number of values is not fixed.
    """
    return tuple(v for label, leaf in _leaves(space, name) for v in _leaf_variables(leaf, label or name))


def _leaf_variables(leaf: Any, name: str) -> list[Variable]:
    size = int(np.prod(leaf.shape, dtype=int))
    lower, upper = _bounds(leaf)
    names = [name] if leaf.shape == () else [f"{name}_{k}" for k in range(size)]
    whole = not np.issubdtype(leaf.dtype, np.floating)
    out = []
    for label, low, high in zip(names, lower, upper, strict=True):
        kind = "binary" if whole and (low, high) == (0.0, 1.0) else "integer" if whole else "real"
        out.append(Variable(label.replace(".", "_"), "1", float(low), float(high), kind))  # type: ignore[arg-type]
    return out


def _bounds(leaf: Any) -> tuple[FloatArray, FloatArray]:
    """Lowest and highest value of each number of a simple space."""
    spaces = require_gymnasium("spaces")
    if isinstance(leaf, spaces.Box):
        return np.ravel(leaf.low).astype(float), np.ravel(leaf.high).astype(float)
    size = int(np.prod(leaf.shape, dtype=int))
    if isinstance(leaf, spaces.MultiBinary):
        return np.zeros(size), np.ones(size)
    first = np.ravel(np.asarray(leaf.start, dtype=float))
    count = np.ravel(np.asarray(leaf.n if isinstance(leaf, spaces.Discrete) else leaf.nvec, dtype=float))
    return first, first + count - 1.0


def flat_values(space: Any, value: Any) -> FloatArray:
    """A value of a space as numbers, shape (space_size(space),)."""
    spaces = require_gymnasium("spaces")
    if isinstance(space, spaces.Dict):
        return np.concatenate([flat_values(inner, value[key]) for key, inner in space.spaces.items()])
    if isinstance(space, spaces.Tuple):
        return np.concatenate([flat_values(inner, v) for inner, v in zip(space.spaces, value, strict=True)])
    return np.ravel(np.asarray(value, dtype=float))


class FlatSpace:
    """Makes values of a space from flat numbers: the nearest value that the space has.

    Args:
        space: a Gymnasium space.

    Raises:
        InputError: if its values have no fixed number of numbers.
    """

    def __init__(self, space: Any) -> None:
        leaves = list(_leaves(space, ""))
        self._space = space
        self._bounds = {id(leaf): _bounds(leaf) for _, leaf in leaves}
        self._simple = len(leaves) == 1 and leaves[0][1] is space
        self._spaces = require_gymnasium("spaces")
        self.size = space_size(space)

    def value(self, flat: FloatArray) -> Any:
        """The value nearest to flat numbers, shape (size,): clipped to the bounds, rounded where only integers are."""
        if self._simple:
            return self._leaf(self._space, flat)
        return self._nested(self._space, iter(flat.tolist()))

    def _nested(self, space: Any, numbers: Iterator[float]) -> Any:
        if isinstance(space, self._spaces.Dict):
            return {key: self._nested(inner, numbers) for key, inner in space.spaces.items()}
        if isinstance(space, self._spaces.Tuple):
            return tuple(self._nested(inner, numbers) for inner in space.spaces)
        size = int(np.prod(space.shape, dtype=int))
        return self._leaf(space, np.array([next(numbers) for _ in range(size)]))

    def _leaf(self, leaf: Any, flat: FloatArray) -> Any:
        lower, upper = self._bounds[id(leaf)]
        value = np.minimum(np.maximum(flat, lower), upper)
        if not np.issubdtype(leaf.dtype, np.floating):
            value = np.rint(value)
        shaped = value.reshape(leaf.shape).astype(leaf.dtype)
        return shaped[()] if leaf.shape == () else shaped
