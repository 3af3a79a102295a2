"""Frozen models as `.npz` bytes: plain arrays only, nothing is ever unpickled."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ichain_drake.array_claims import check_claims
from ichain_drake.errors import InputError
from ichain_drake.learning.frozen import FrozenModel, from_arrays

_PLAIN = "biufU"  # truth values, whole numbers, numbers, text


def pack(model: FrozenModel) -> bytes:
    """A frozen model's arrays as the bytes of an `.npz` file; the same model gives the same bytes."""
    return pack_arrays(model.arrays())


def pack_arrays(arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """Plain arrays as the bytes of an `.npz` file; the same arrays give the same bytes."""
    stream = io.BytesIO()
    assert all(a.dtype != object for a in arrays.values())  # these would be pickled; NumPy 2.1 has no way to forbid it
    np.savez(stream, **arrays)  # type: ignore[arg-type]
    return stream.getvalue()


def unpack(data: bytes, kind: str, where: str) -> FrozenModel:
    """The frozen model that `pack` wrote.

    Args:
        data: contents of the file.
        kind: `FrozenModel.kind`.
        where: what to call the file in errors.

    Raises:
        InputError: on anything that is not an uncompressed `.npz` file of plain arrays of that kind of model.
    """
    return build(kind, unpack_arrays(data, where), where)


def build(kind: str, arrays: Mapping[str, NDArray[Any]], where: str) -> FrozenModel:
    """A frozen model of its arrays.

    Args:
        kind: `FrozenModel.kind`.
        arrays: as `FrozenModel.arrays` gave them.
        where: what to call their file in errors.

    Raises:
        InputError: if they don't make a model of that kind, or one that gives no finite numbers.
    """
    try:
        with np.errstate(all="ignore"):  # what overflows is refused below
            model = from_arrays(kind, arrays)
            value = model.value(model.inputs.mean)
    except InputError as error:
        raise InputError(f"{where}: {error}") from None
    except (ArithmeticError, AttributeError, LookupError, MemoryError, TypeError, ValueError) as error:
        raise InputError(f"{where}: its arrays don't make a {kind} model ({_line(error)})") from None
    foreign = sorted(set(arrays) ^ set(model.arrays()))
    if foreign:
        raise InputError(f"{where}: array {foreign[0]} is no part of a {kind} model")
    if value.shape != (model.n_out,) or not np.isfinite(value).all():
        raise InputError(f"{where}: the {kind} model gives no finite numbers in the middle of its own data")
    return model


def unpack_arrays(data: bytes, where: str) -> dict[str, NDArray[Any]]:
    """The arrays that `pack_arrays` wrote, by name.

    Raises:
        InputError: on anything that is not an uncompressed `.npz` file of plain arrays; `where` names it.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            # numpy writes them stored; a compressed one could unfold to more than memory holds.
            packed = [m.filename for m in archive.infolist() if m.compress_type != zipfile.ZIP_STORED]
            names = archive.namelist()
        if packed or len(set(names)) != len(names):
            raise InputError(f"{where}: is no .npz file of this library: it is compressed or names an array twice")
        check_claims(io.BytesIO(data), where)
        arrays = {}
        with np.load(io.BytesIO(data), allow_pickle=False) as opened:
            for name in opened.files:
                arrays[name] = opened[name]
                if not isinstance(arrays[name], np.ndarray) or arrays[name].dtype.kind not in _PLAIN:
                    raise InputError(f"{where}: {name} is no array of plain numbers or text; nothing else is opened")
    except InputError:
        raise
    except Exception as error:  # numpy and zipfile make errors of many kinds of damage, that of a tokenizer among them
        raise InputError(f"{where}: is no .npz file of plain arrays ({_line(error)}); nothing in it was run") from None
    return arrays


def _line(error: Exception) -> str:
    return " ".join(str(error).split()) or type(error).__name__
