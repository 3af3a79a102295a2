"""HDF5 of others: arrays of a row a step in groups, read without following what leads out of the file."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ichain_drake.demonstrations.importing.extra import require
from ichain_drake.demonstrations.importing.pieces import MOST_CELLS, few, pick
from ichain_drake.demonstrations.importing.sources import Source
from ichain_drake.errors import InputError
from ichain_drake.files import is_file, printable
from ichain_drake.state import FloatArray

_MOST_GROUPS = 10**5
_OWN_FILTERS = frozenset({1, 2, 3, 4, 5, 6, 32000})
"""Of the HDF5 library and h5py: for others a file could ask for a program on this machine to be loaded."""


@contextmanager
def opened_hdf5(file: Path) -> Iterator[Any]:
    """A file of HDF5, open for reading; errors within are one line that names it.

    Raises:
        InputError: if it is none, or damage is met; as what is done with it raises.
    """
    h5py = require("h5py", "reading HDF5")
    if not is_file(file):
        raise InputError(f"{file}: there is no such file of HDF5")
    try:
        with h5py.File(file, "r") as stored:
            yield stored
    except InputError:
        raise
    except Exception as error:  # whatever h5py makes of damage
        line = printable((str(error).splitlines() or [""])[0][:200])
        raise InputError(f"{file}: can't read it as HDF5: {line or type(error).__name__}") from None


def groups_of(group: Any, where: str) -> Iterator[tuple[str, Any]]:
    """The groups in a group with their names, in order of the numbers in these.

    Args:
        group: holds a group a demonstration.
        where: what to call it in errors.

    Raises:
        InputError: if there are too many, or one is a link to somewhere else.
    """
    if len(group) > _MOST_GROUPS:
        raise InputError(f"{where}: {len(group)} demonstrations are too many; split it")
    for name in sorted(group, key=_number):
        found = group_in(group, name, f"{where}: {printable(name)}")
        if found is not None:
            yield name, found


def group_in(group: Any, name: str, where: str) -> Any:
    """The group under a name; None if there is none. Arguments and errors as of `member`."""
    found = member(group, name, where)
    return found if isinstance(found, require("h5py", "reading HDF5").Group) else None


def _number(name: str) -> tuple[int, str]:
    found = re.search(r"\d{1,18}", name)
    return (int(found[0]) if found else -1), name


def member(group: Any, name: str, where: str) -> Any:
    """What is under a name, `a/b` for a member of a member; None if nothing is.

    Args:
        group: to look into.
        name: of what is wanted.
        where: what to call the group in errors.

    Raises:
        InputError: if it is a link to somewhere else.
    """
    h5py = require("h5py", "reading HDF5")
    found = group
    for part in name.split("/"):
        if not isinstance(found, h5py.Group) or not part or part == ".." or part not in found:
            return None
        if not isinstance(found.get(part, getlink=True), h5py.HardLink):
            raise InputError(f"{where}: {printable(name)} is a link to somewhere else, and is not followed; copy it")
        found = found[part]
    return found


def numbers(group: Any, source: Source, where: str) -> FloatArray:
    """The numbers of a source, shape (n_rows,).

    Args:
        group: of a demonstration.
        source: a data set in it, such as `obs/object[0]`.
        where: what to call the group in errors.

    Raises:
        InputError: if there is none, it holds no rows of numbers, claims too many, or is kept elsewhere.
    """
    stored = member(group, source.name, where)
    if not isinstance(stored, require("h5py", "reading HDF5").Dataset):
        raise InputError(f"{where}: it has no data set {printable(source.name)}; it has {few(list(group))}")
    if stored.ndim == 0 or stored.dtype.kind not in "fiub":
        raise InputError(f"{where}: {printable(source.name)} holds no rows of numbers; map another source")
    if stored.size > MOST_CELLS:
        raise InputError(f"{where}: {printable(source.name)} claims {stored.size} numbers; too many are not read")
    plan = stored.id.get_create_plist()
    filters = {plan.get_filter(i)[0] for i in range(plan.get_nfilters())}
    if stored.external or stored.is_virtual or not filters <= _OWN_FILTERS:
        raise InputError(f"{where}: {printable(source.name)} is kept in other files, or packed by a program of its own")
    return pick(stored[()], source, (), where)
