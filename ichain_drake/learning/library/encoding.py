"""Learned dataclasses as a tree of plain JSON values and named arrays, and back by their type hints.

Nothing says by itself what it is made into: only classes that the hints of the wanted class lead to are built.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from types import NoneType, UnionType
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

import numpy as np

from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction
from ichain_drake.learning.frozen import FrozenModel
from ichain_drake.learning.frozen.model import Array
from ichain_drake.learning.library.form import is_form, refusal
from ichain_drake.learning.library.weights import build

_KIND = "is"  # the field that names a dataclass or the kind of a frozen model


def encode(value: Any, path: str, arrays: dict[str, Array]) -> Any:  # noqa: PLR0911 - one return a form
    """A value as JSON; its arrays, named after their place, are put into `arrays`.

    Args:
        value: dataclasses, frozen models, interactions, mappings, sequences, arrays and plain values, nested.
        path: of the value in its document.
        arrays: is filled.

    Raises:
        InputError: on anything else, or a number that is not finite; names the place.
    """
    if isinstance(value, Interaction):
        return value.name
    if isinstance(value, FrozenModel):
        arrays.update({f"{path}.{name}": array for name, array in value.arrays().items()})
        return {_KIND: value.kind}
    if isinstance(value, np.ndarray):
        arrays[path] = value
        return path
    if dataclasses.is_dataclass(value):
        fields = {f.name: encode(getattr(value, f.name), f"{path}.{f.name}", arrays) for f in dataclasses.fields(value)}
        return {_KIND: type(value).__name__} | fields
    if isinstance(value, Mapping):
        return [
            [encode(key, f"{path}[{i}]", arrays), encode(item, f"{path}[{i}]", arrays)]
            for i, (key, item) in enumerate(value.items())
        ]
    if isinstance(value, list | tuple):
        return [encode(item, f"{path}[{i}]", arrays) for i, item in enumerate(value)]
    plain = value.item() if isinstance(value, np.generic) else value
    if not isinstance(plain, bool | int | float | str | None) or (
        isinstance(plain, float) and not math.isfinite(plain)
    ):
        raise InputError(f"{path}: {plain!r:.60} can't be saved; it is no plain value or no finite number")
    return plain


class Decoder:
    """Builds what `encode` took apart.

    Args:
        arrays: by name.
        interactions: those that may be named.
        where: what to call the file in errors.
    """

    def __init__(self, arrays: Mapping[str, Array], interactions: tuple[Interaction, ...], where: str) -> None:
        self._arrays = arrays
        self._interactions = {e.name: e for e in interactions}
        self._where = where
        self._used: set[str] = set()

    def decode(self, hint: Any, data: Any, path: str) -> Any:  # noqa: PLR0911 - one return a form
        """The value of a type.

        Args:
            hint: the type, as in annotations.
            data: from `encode`.
            path: the same as there.

        Raises:
            InputError: if the data are of another form; names the field.
        """
        origin, args = get_origin(hint), get_args(hint)
        if hasattr(origin, "__value__"):  # an alias with parameters, as numpy's NDArray is from 2.5 on
            hint = origin.__value__[args]
            origin, args = get_origin(hint), get_args(hint)
        if origin in (Union, UnionType):
            return self._one_of(args, data, path)
        if origin is Literal:
            return self._checked(data, data in args, path)
        if origin is np.ndarray:
            return self._array(args, data, path)
        if origin is tuple:
            return self._tuple(args, data, path)
        if origin is not None and issubclass(origin, Mapping):
            return self._mapping(args, data, path)
        if hint is Interaction:
            known = isinstance(data, str) and data in self._interactions
            return self._interactions[self._checked(data, known, path)]
        if hint is FrozenModel:
            return self._frozen(data, path)
        if isinstance(hint, type) and dataclasses.is_dataclass(hint):
            return self._fields(hint, data, path)
        if hint is bool:
            return self._checked(data, isinstance(data, bool), path)
        if hint in (int, float, str):
            return hint(self._checked(data, is_form(data, hint), path))
        raise TypeError(f"{path}: {hint} is no type that is saved")

    def finish(self) -> None:
        """Refuse arrays that belong to nothing.

        Raises:
            InputError: names the first of them.
        """
        foreign = sorted(set(self._arrays) - self._used)
        if foreign:
            raise self._refusal(foreign[0], "an array that is no part of the model")

    def _one_of(self, args: tuple[Any, ...], data: Any, path: str) -> Any:
        if data is None:
            return self._checked(data, NoneType in args, path)
        kinds = [a for a in args if a is not NoneType]
        named = data.get(_KIND) if isinstance(data, dict) else None
        for kind in kinds:
            if len(kinds) == 1 or kind.__name__ == named:
                return self.decode(kind, data, path)
        raise self._refusal(f"{path}.{_KIND}", f"{named!r:.60} can't stand here")

    def _array(self, args: tuple[Any, ...], data: Any, path: str) -> Array:
        if data != path or path not in self._arrays:
            raise self._refusal(path, "its array is missing")
        self._used.add(path)
        array, wanted = self._arrays[path], np.dtype(get_args(args[1])[0])
        if array.dtype != wanted:
            raise self._refusal(path, f"an array of {array.dtype}, {wanted} is needed")
        if wanted.kind == "f" and not np.isfinite(array).all():
            raise self._refusal(path, "a number in its array is not finite")
        return array

    def _tuple(self, args: tuple[Any, ...], data: Any, path: str) -> tuple[Any, ...]:
        kinds = (args[0],) * len(data) if isinstance(data, list) and args[1:] == (...,) else args
        if not isinstance(data, list) or len(data) != len(kinds):
            raise self._refusal(path, f"a list is needed, found {data!r:.60}")
        return tuple(
            self.decode(kind, item, f"{path}[{i}]") for i, (kind, item) in enumerate(zip(kinds, data, strict=True))
        )

    def _mapping(self, args: tuple[Any, ...], data: Any, path: str) -> dict[Any, Any]:
        out = {}
        for i, pair in enumerate(self._tuple_of_pairs(data, path)):
            key = self.decode(args[0], pair[0], f"{path}[{i}]")
            if key in out:
                raise self._refusal(f"{path}[{i}]", f"{pair[0]!r:.60} is there twice")
            out[key] = self.decode(args[1], pair[1], f"{path}[{i}]")
        return out

    def _tuple_of_pairs(self, data: Any, path: str) -> list[Any]:
        if not isinstance(data, list) or not all(isinstance(p, list) and len(p) == 2 for p in data):  # noqa: PLR2004
            raise self._refusal(path, f"a list of pairs is needed, found {data!r:.60}")
        return data

    def _frozen(self, data: Any, path: str) -> FrozenModel:
        if not isinstance(data, dict) or set(data) != {_KIND} or not isinstance(data[_KIND], str):
            raise self._refusal(path, f"the kind of a frozen model is needed, found {data!r:.60}")
        own = {name: a for name, a in self._arrays.items() if name.startswith(f"{path}.")}
        self._used |= set(own)
        model = {name.removeprefix(f"{path}."): array for name, array in own.items()}
        return build(data[_KIND], model, f"{self._where}: {path}")

    def _fields(self, kind: type[Any], data: Any, path: str) -> Any:
        names = [f.name for f in dataclasses.fields(kind)]
        if not isinstance(data, dict):
            raise self._refusal(path, f"named fields are needed, found {data!r:.60}")
        for name in (*names, *data):
            if name not in data or name not in (*names, _KIND):
                raise self._refusal(f"{path}.{name:.60}", "missing" if name in names else "unknown field")
        self._checked(data.get(_KIND), data.get(_KIND) == kind.__name__, f"{path}.{_KIND}")
        hints = get_type_hints(kind)
        return kind(**{name: self.decode(hints[name], data[name], f"{path}.{name}") for name in names})

    def _checked(self, data: Any, good: bool, path: str) -> Any:
        if not good:
            raise self._refusal(path, f"{data!r:.60} can't stand here")
        return data

    def _refusal(self, path: str, what: str) -> InputError:
        return refusal(self._where, path, what)
