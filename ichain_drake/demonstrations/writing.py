"""Demonstrations to disk, each whole or not at all, none over another."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ichain_drake.demonstrations.parquet import parquet_bytes
from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.files import reason_of, write_whole


def write_demonstration(demo: Demonstration, file: Path, *, new: bool = False) -> None:
    """Write a piece as `.parquet`, or as `.csv` with units in the header (`car.x [px]`); whole or not at all.

    Args:
        demo: the piece.
        file: where to.
        new: refuse to replace a file.

    Raises:
        InputError: on another ending, if the file can't be written, or is there already and must be new.
    """
    file = Path(file)
    if file.suffix == ".csv":
        header = {c: f"{c} [{demo.units[c]}]" for c in demo.table.columns if c in demo.units}
        content = demo.table.rename(columns=header).to_csv(index=False).encode(errors="surrogateescape")
    elif file.suffix == ".parquet":
        content = parquet_bytes(demo.table, demo.units)
    else:
        raise InputError(f"{file}: a demonstration ends in .parquet or .csv")
    try:
        write_whole(file, content, new=new)
    except InputError as error:
        raise InputError(f"can't write the demonstration: {error}") from None


def write_demonstrations(pieces: Sequence[Demonstration], folder: Path, *, overwrite: bool = False) -> list[Path]:
    """Write pieces into a folder as `<name>.parquet`, making the folder if needed.

    Args:
        pieces: with names of their own.
        folder: where to.
        overwrite: whether files that are there may be replaced.

    Returns:
        The files.

    Raises:
        InputError: if the folder can't be made or written, two pieces would get the same file, or a file is there
            already and may not be replaced; then nothing is written.
    """
    folder = Path(folder)
    files = [folder / f"{Path(p.name).stem}.parquet" for p in pieces]
    for file in files:
        if files.count(file) > 1:
            raise InputError(f"{file}: two pieces have this name; give each its own")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        taken = [] if overwrite else [file for file in files if file.exists()]
    except (OSError, ValueError) as error:
        raise InputError(f"{folder}: can't make the folder: {reason_of(error)}") from None
    if taken:
        raise InputError(
            f"{taken[0]}: is there already, and demonstrations are not overwritten; give another folder, or overwrite"
        )
    for piece, file in zip(pieces, files, strict=True):
        write_demonstration(piece, file, new=not overwrite)
    return files
