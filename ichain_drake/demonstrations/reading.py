"""Demonstrations from disk: files and folders as people hand them in."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ichain_drake.demonstrations.csv_text import ENDINGS
from ichain_drake.demonstrations.long_logs import read_enough
from ichain_drake.demonstrations.piece_file import Say, converted, piece_files, read_demonstration
from ichain_drake.demonstrations.plausible import check_plausible
from ichain_drake.demonstrations.resampling import is_at, resample
from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.demonstrations.thinning import Bound
from ichain_drake.errors import InputError
from ichain_drake.files import reason_of, shown
from ichain_drake.graph import InteractionGraph
from ichain_drake.timing import TICK


def read_folder(folder: Path, say: Say | None = None) -> list[Demonstration]:
    """Read every piece of a folder, in order of file name, without checking what is in it.

    Args:
        folder: with the pieces, or one file. What is hidden there (as `._a.csv` of other systems) is no piece.
        say: called with a line on each file that is passed over.

    Raises:
        InputError: if the folder does not exist or holds no piece, or a file can't be read.
    """
    return [read_demonstration(file) for file in piece_files(Path(folder), say)]


def check_unused(folder: Path) -> None:
    """Refuse a folder that holds pieces already, before minutes of recording.

    Raises:
        InputError: names some of them.
    """
    try:
        found = [f for f in sorted(folder.iterdir()) if f.name.lower().endswith((".parquet", *ENDINGS))]
    except OSError as error:
        raise InputError(f"{folder}: can't be read ({reason_of(error)})") from None
    if found:
        few = ", ".join(shown(f) for f in found[:3]) + (", ..." if len(found) > 3 else "")
        raise InputError(
            f"{folder}: holds {len(found)} demonstrations already ({few}); give another folder, or --overwrite to "
            "replace those of the same names"
        )


def at_tick(piece: Demonstration, graph: InteractionGraph, say: Say | None = None) -> list[Demonstration]:
    """A piece taken to the library's period where it isn't at it: see `resample`.

    Raises:
        InputError: if it can't be; names the piece and why.
    """
    if is_at(piece, TICK):
        return [piece]
    check_plausible(piece, graph)  # before an angle in degrees is taken for one that turns
    found = resample(piece, graph.objects, TICK)
    for note in found.notes if say is not None else ():
        say(note)  # type: ignore[misc]
    return list(found.pieces)


def prepare(
    pieces: Sequence[Demonstration], graph: InteractionGraph, *, resampled: bool = False, say: Say | None = None
) -> list[Demonstration]:
    """Pieces in a graph's units and, where asked for, at the library's period; not yet checked.

    Args:
        pieces: as read.
        graph: declares units and kinds.
        resampled: whether to take pieces of another period to the library's.
        say: called with a line on each thing that was done.

    Raises:
        InputError: as `converted` and `at_tick`.
    """
    out: list[Demonstration] = []
    for piece in pieces:
        ready, notes = converted(piece, graph)
        for note in notes if say is not None else ():
            say(note)  # type: ignore[misc]
        out += at_tick(ready, graph, say) if resampled else [ready]
    return out


def read_demonstrations(
    folder: Path,
    graph: InteractionGraph,
    *,
    resampled: bool = False,
    say: Say | None = None,
    bound: Bound | None = None,
) -> list[Demonstration]:
    """Read, convert and check every piece of a folder, in order of file name.

    Args:
        folder: with the pieces.
        graph: declares what may be in them.
        resampled: whether to take pieces of another period to the library's; see `resample`.
        say: called with a line on each thing that was done: files passed over, units converted, pieces resampled.
        bound: how much of logs beyond memory is read; see `read_enough`.

    Raises:
        InputError: if the folder does not exist or holds no piece, or a piece is bad.
    """
    pieces = prepare(
        read_enough(folder, graph, bound, resampled=resampled, say=say), graph, resampled=resampled, say=say
    )
    for piece in pieces:
        piece.check(graph)
    return pieces
