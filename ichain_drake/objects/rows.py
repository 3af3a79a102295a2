"""Many runs of one object side by side, a row each: one `step` in numpy for all of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from functools import cache
from typing import Any, Protocol, cast

import numpy as np

from ichain_drake.errors import IchainError
from ichain_drake.noise import NoiseRows
from ichain_drake.objects.base import ParentStates, WorldObject
from ichain_drake.state import BoolArray, FloatArray
from ichain_drake.timing import FRAME

_LARGEST = 1e100  # as for one run


class NotTogetherError(IchainError):
    """These runs can't be calculated together to the bits that each has alone; the message says why."""


class _Numbers(np.ndarray):
    """An array whose powers are those of its numbers: numpy has another routine for arrays, off by the last bit."""

    def __pow__(self, exponent: Any, modulo: Any = None) -> Any:
        return _powers(self, exponent)

    def __rpow__(self, base: Any, modulo: Any = None) -> Any:
        return _powers(base, self)

    def __ipow__(self, exponent: Any) -> Any:  # type: ignore[misc, override] # without a modulo
        self[...] = _powers(self, exponent)
        return self


def _powers(base: Any, exponent: Any) -> _Numbers:
    """Powers, number by number, of what numpy would broadcast."""
    bases, exponents = np.broadcast_arrays(np.asarray(base, dtype=float), np.asarray(exponent, dtype=float))
    powers = [b**e for b, e in zip(bases.ravel(), exponents.ravel(), strict=True)]
    return np.array(powers, dtype=float).reshape(bases.shape).view(_Numbers)


class DecidesRows(Protocol):
    """An object that knows how to decide for many runs at once; any other decides row by row."""

    def decide_rows(
        self, state: FloatArray, parents: ParentStates, active: Mapping[str, BoolArray]
    ) -> Mapping[str, BoolArray]:
        """`WorldObject.decide_active` of many runs without bodies.

        Args:
            state: shape (n, n_variables).
            parents: state of each parent, shape (n, n_parent_variables).
            active: the previous decisions, shape (n,) each.

        Returns:
            The decisions per parent, shape (n,) each.
        """


def decide_rows(
    system: WorldObject, state: FloatArray, parents: ParentStates, active: Mapping[str, BoolArray]
) -> Mapping[str, BoolArray]:
    """See `DecidesRows`; for any object."""
    if _decides_rows(type(system)):  # type: ignore[arg-type] # Drake tells the types of hashes otherwise
        return cast("DecidesRows", system).decide_rows(state, parents, active)
    rows = [
        system.decide_active(s, _row(parents, i), {p: bool(v[i]) for p, v in active.items()}, None)
        for i, s in enumerate(state)
    ]
    return {p: np.array([row[p] for row in rows], dtype=bool) for p in parents}


@cache
def _decides_rows(kind: type[WorldObject]) -> bool:
    """Whether there is a `decide_rows`, which tells of `decide_active` and not of one that a subclass has replaced."""
    names = ("decide_rows", "decide_active")
    return next((name for c in kind.__mro__ for name in names if name in vars(c)), "") == names[0]


def unlike(one: Any, other: Any) -> bool:
    """Whether two values are, or hold, different numbers, texts or arrays; what else they hold is not looked at."""
    if isinstance(one, np.ndarray | bool | int | float | str):
        return not (type(one) is type(other) and np.array_equal(one, other))
    if is_dataclass(one):
        return type(one) is not type(other) or any(
            unlike(getattr(one, f.name), getattr(other, f.name)) for f in fields(one)
        )
    if isinstance(one, Mapping):
        return not isinstance(other, Mapping) or list(one) != list(other) or any(unlike(one[k], other[k]) for k in one)
    if isinstance(one, list | tuple):
        alike = type(one) is type(other) and len(one) == len(other)
        return not alike or any(unlike(a, b) for a, b in zip(one, other, strict=True))
    return (one is None) != (other is None)


def _made_of(one: WorldObject, other: WorldObject) -> dict[str, Any]:
    """Attributes of an object, but for its seed and copies of it, which another one has in the same place."""
    seeds, others = (one.settings.seed, other.settings.seed), vars(other)
    own = {
        name: value for name, value in vars(one).items() if type(value) is not int or (value, others.get(name)) != seeds
    }
    return own | {"settings": replace(one.settings, seed=0)}


class ObjectRows:
    """The same object of several worlds, which differ in seeds and starts alone.

    Args:
        objects: one a world.

    Raises:
        NotTogetherError: if they differ otherwise, or need a plant or a sensor's past.
    """

    def __init__(self, objects: Sequence[WorldObject]) -> None:
        first = objects[0]
        settings = first.settings
        for other in objects:
            if type(other) is not type(first) or unlike(_made_of(first, other), _made_of(other, first)):
                raise NotTogetherError(f"{first.get_name()} differs from run to run")
        if settings.body_size or settings.dropouts:
            raise NotTogetherError(f"{first.get_name()} has a body or drop-outs")
        self._object, self._each = first, list(objects)
        self._process = NoiseRows([o._process_noise for o in objects])
        self._sensor = NoiseRows([o._sensor_noise for o in objects])
        self._view: type[np.ndarray] = _Numbers

    @property
    def immediate(self) -> bool:
        """Whether it mirrors its parents at once."""
        return self._object.immediate

    @property
    def settles(self) -> bool:
        """Whether it has to settle once modes are decided."""
        return type(self._object).settle is not WorldObject.settle

    def decide(self, state: FloatArray, parents: ParentStates, active: FloatArray) -> FloatArray:
        """Which incoming interactions are active, shape (n, n_parents), from before."""
        if type(self._object).decide_active is WorldObject.decide_active:
            return np.ones(active.shape)
        before = {p: active[:, k] > 0.5 for k, p in enumerate(self._object.parents)}
        told = {p: parents[p] for p in self._object.parents}
        after = decide_rows(self._object, state, told, before)
        return np.stack([after[p] for p in self._object.parents], axis=1).astype(float)

    def step(
        self, state: FloatArray, parents: ParentStates, active: FloatArray, frame: int, checked: BoolArray
    ) -> FloatArray:
        """States 1/30 s later, shape (n, n_variables).

        Args:
            state: shape (n, n_variables).
            parents: state of each parent, shape (n, n_parent_variables).
            active: shape (n, n_parents).
            frame: its number, from 0.
            checked: which rows are stepped by their own objects too, shape (n,).

        Raises:
            NotTogetherError: if that gives other bits, or any value is no state.
        """
        noise = self._process.at(frame) * self._object.settings.noise_scale
        told = {p: parents[p] for p in self._object.parents}
        on = dict(zip(told, active.T, strict=True))

        def alone(own: WorldObject, i: int) -> FloatArray:
            return own.step(state[i], _row(told, i), _row(on, i), noise[i], FRAME)

        def together(view: type[np.ndarray]) -> Any:
            modes = {p: v.view(view) for p, v in on.items()}
            return self._object.step(state.view(view), _viewed(told, view), modes, noise.view(view), FRAME)

        return self._same("step", state, together, alone, checked)

    def settle(self, state: FloatArray, parents: ParentStates, active: FloatArray, checked: BoolArray) -> FloatArray:
        """States at the instant itself, shape (n, n_variables), once it is decided what is active.

        Args:
            state, parents, active: as for `step`.
            checked: which rows are settled by their own objects too, shape (n,).

        Raises:
            NotTogetherError: as for `step`.
        """
        told = {p: parents[p] for p in self._object.parents}
        on = {p: v > 0.5 for p, v in zip(told, active.T, strict=True)}  # noqa: PLR2004 - 0 or 1

        def alone(own: WorldObject, i: int) -> FloatArray:
            return own.settle(state[i], _row(told, i), {p: bool(v[i]) for p, v in on.items()})

        def together(view: type[np.ndarray]) -> Any:
            return self._object.settle(state.view(view), _viewed(told, view), on)  # type: ignore[arg-type] # rows

        return self._same("settle", state, together, alone, checked)

    def _same(
        self,
        what: str,
        state: FloatArray,
        together: Callable[[type[np.ndarray]], Any],
        alone: Callable[[WorldObject, int], FloatArray],
        checked: BoolArray,
    ) -> FloatArray:
        """What is calculated for all rows; of some, which are checked, alone too."""
        after = self._calculated(what, state, together)
        if np.count_nonzero(checked):
            rows = [alone(self._each[i], i) for i in np.flatnonzero(checked).tolist()]
            if not np.array_equal(rows, after[checked]):  # an object may take its state apart into arrays, not numbers
                self._view = np.ndarray
                after = self._calculated(what, state, together)
            if not np.array_equal(rows, after[checked]):
                raise NotTogetherError(f"{self._object.get_name()}: {what} gives other bits for many rows than for one")
        return after

    def _calculated(self, what: str, state: FloatArray, together: Callable[[type[np.ndarray]], Any]) -> FloatArray:
        try:
            after = np.array(together(self._view), dtype=float)
        except Exception as error:  # an object that takes one row at a time; what else is wrong shows where it does
            raise NotTogetherError(f"{self._object.get_name()}: {what} takes no rows: {error}") from error
        if after.shape != state.shape or not np.abs(after).max(initial=0.0) <= _LARGEST:
            raise NotTogetherError(f"{self._object.get_name()}: {what} gives what are no states of many rows")
        return after

    def measure(self, state: FloatArray, frame: int) -> FloatArray:
        """What the sensors read, shape (n, n_observable)."""
        return self._object.measure(state, self._sensor.at(frame) * self._object.settings.noise_scale)

    def keep(self, rows: BoolArray) -> None:
        """Go on with some of the runs; shape (n,)."""
        self._each = [o for o, kept in zip(self._each, rows, strict=True) if kept]
        self._process.keep(rows)
        self._sensor.keep(rows)


def _row(values: Mapping[str, FloatArray], i: int) -> dict[str, FloatArray]:
    return {name: value[i] for name, value in values.items()}


def _viewed(values: Mapping[str, FloatArray], view: type[np.ndarray]) -> dict[str, FloatArray]:
    return {name: value.view(view) for name, value in values.items()}
