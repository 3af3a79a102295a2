"""Pieces to learn a graph from, read from a folder and checked; long recordings without flags are cut first."""

from __future__ import annotations

from collections.abc import Callable, Collection
from pathlib import Path

from ichain_drake.demonstrations import Demonstration, prepare
from ichain_drake.demonstrations.long_logs import read_enough
from ichain_drake.files import is_file
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.checks import check_flags, check_pieces
from ichain_drake.learning.discovery.cuts import TABLE, cut_pieces
from ichain_drake.learning.enough import learned_bound


def read_pieces(
    folder: Path,
    graph: InteractionGraph,
    known: Collection[Interaction] = (),
    *,
    resampled: bool = False,
    unlabelled: bool = False,
    say: Callable[[str], None] | None = None,
) -> list[Demonstration]:
    """Read every piece of a folder and check them for learning a graph, before anything else is done with them.

    Of logs beyond memory only what will be learned from is read (see `read_enough`).

    Args:
        folder: with the pieces.
        graph: the interaction graph.
        known: interactions that they need not show.
        resampled: whether to take pieces of another period to the library's.
        unlabelled: whether flags may be missing or empty; they are left as they are. Long recordings are cut
            where no table beside them says that they were.
        say: called with a line on each thing that was done: files passed over, units converted, pieces resampled, cut.

    Raises:
        InputError: if the folder or a file can't be read, and as `check_pieces` and `check_flags`.
    """
    found = read_enough(folder, graph, learned_bound(), resampled=resampled, say=say)
    pieces = prepare(found, graph, resampled=resampled, say=say)
    if unlabelled:
        if not is_file(folder / TABLE):
            pieces = list(cut_pieces(pieces, graph, say).pieces)
        check_pieces(pieces, graph, unlabelled=True)
        return pieces
    check_pieces(pieces, graph)
    shown = [e for e in graph.interactions if e not in known]
    flags = {e: [p.table[e.name].to_numpy(dtype=float) > 0.5 for p in pieces] for e in shown}
    check_flags([p.name for p in pieces], flags)
    return pieces
