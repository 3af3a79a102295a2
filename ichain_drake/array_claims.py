"""What `.npz` files claim to hold, looked at before any memory is asked for."""

from __future__ import annotations

import math
import zipfile
from typing import IO

import numpy as np

from ichain_drake.errors import InputError

_MOST_BYTES = 2**28
"""All arrays of one file together [bytes]: an hour of a large graph at 30 Hz is a tenth of it."""
_MOST_TEXTS = 10**6
"""Texts in one array: each takes some fifty bytes more once it is one of Python's."""
_MOST_ITEM = 2**24
"""One item of an array [bytes]: numbers take 16 at most, and the largest are texts such as a table of contents."""


def check_claims(file: IO[bytes], where: str) -> None:
    """Refuse arrays that are larger than what is there for them: numpy would first ask for the memory, then read.

    Args:
        file: the `.npz`, at its start; left there.
        where: what to call it in errors.

    Raises:
        InputError: names the array and what it claims.
        Exception: of whatever kind numpy and zipfile make, if it is no `.npz` file of arrays.
    """
    with zipfile.ZipFile(file) as archive:
        for member in archive.infolist():
            if not member.filename.endswith(".npy"):
                continue
            with archive.open(member) as stream:
                major, _ = np.lib.format.read_magic(stream)
                read = np.lib.format.read_array_header_1_0 if major == 1 else np.lib.format.read_array_header_2_0
                shape, _, kind = read(stream)
            size = math.prod(shape) * kind.itemsize if all(n >= 0 for n in shape) else math.inf
            if kind.itemsize > _MOST_ITEM:
                name = member.filename.removesuffix(".npy")
                raise InputError(
                    f"{where}: one item of {name} claims to be {kind.itemsize / 1e6:.0f} MB, and "
                    f"{_MOST_ITEM / 1e6:.0f} are read at most; nothing of it is read"
                )
            if kind.kind == "U" and math.prod(shape) > _MOST_TEXTS:
                raise InputError(
                    f"{where}: {member.filename.removesuffix('.npy')} claims {math.prod(shape):.3g} texts, and "
                    f"{_MOST_TEXTS} are read at most; nothing of it is read"
                )
            if size > member.file_size or len(shape) > 32:
                raise InputError(
                    f"{where}: {member.filename.removesuffix('.npy')} claims to be {size:.3g} bytes, and "
                    f"{member.file_size} are there; nothing of it is read"
                )
        total = sum(member.file_size for member in archive.infolist())
        if total > _MOST_BYTES:
            raise InputError(
                f"{where}: it unpacks to {total / 1e6:.0f} MB, and {_MOST_BYTES / 1e6:.0f} are read at most; nothing "
                "of it is read"
            )
    file.seek(0)
