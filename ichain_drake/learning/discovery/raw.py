"""Logs of states from a folder, for what is found out of states alone."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from ichain_drake.demonstrations import Demonstration, prepare
from ichain_drake.demonstrations.checks import check_times, known_units
from ichain_drake.demonstrations.long_logs import read_enough
from ichain_drake.demonstrations.thinning import Bound
from ichain_drake.errors import InputError
from ichain_drake.files import is_file
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.discovery.cuts import TABLE, Pieces, cut_pieces
from ichain_drake.learning.discovery.labels import raw_piece
from ichain_drake.learning.discovery.log import RawPiece
from ichain_drake.learning.discovery.marks import Mark, check_marks, marked
from ichain_drake.learning.enough import learned_bound
from ichain_drake.state import StateSpace


def read_raw(
    folder: Path,
    spaces: Mapping[str, StateSpace],
    root: str,
    *,
    resampled: bool = False,
    say: Callable[[str], None] | None = None,
) -> list[RawPiece]:
    """Read, cut and check logs; flags and columns of no object are left aside.

    Args:
        folder: with the logs, or one of them.
        spaces: state space per object.
        root: the robot.
        resampled: whether to take pieces of another period to the library's.
        say: called with a line on each thing that was done.

    Raises:
        InputError: if the folder or a file can't be read, and on values or times that can't be; names the remedy.
    """
    if root not in spaces:
        raise InputError(f"there is no object {root!r} to be the robot; objects are {', '.join(spaces)}")
    graph = InteractionGraph(spaces, [Interaction(root, n) for n in spaces if n != root])
    found = read_logs(folder, graph, resampled=resampled, say=say, bound=learned_bound())
    return [raw_piece(p, graph) for p in found.pieces]


def read_logs(
    folder: Path,
    graph: InteractionGraph,
    *,
    resampled: bool = False,
    say: Callable[[str], None] | None = None,
    marks: Sequence[Mark] = (),
    bound: Bound | None = None,
) -> Pieces:
    """Read, cut and check logs with all that is in them; only what the graph declares is looked at.

    Pieces that were cut before, which a table beside them says, are left as they are.

    Args:
        folder: with the logs, or one of them.
        graph: declares objects and their state spaces.
        resampled: whether to take pieces of another period to the library's.
        say: called with a line on each thing that was done.
        marks: by a person, of statuses and cuts.
        bound: how much of logs beyond memory is read (see `read_enough`); None to read all.

    Raises:
        InputError: as `read_raw` and `check_marks`.
    """
    logs = prepare(read_enough(folder, graph, bound, resampled=resampled, say=say), graph, resampled=resampled, say=say)
    check_marks(marks, logs, graph)
    logs = [marked(log, marks) for log in logs]
    if is_file(folder / TABLE) and not marks:
        found = Pieces(tuple(logs), (), tuple((log.name, 0) for log in logs))
    else:
        found = cut_pieces(logs, graph, say, marks)
    check_logs(found.pieces, graph)
    return found


def check_logs(pieces: Sequence[Demonstration], graph: InteractionGraph) -> None:
    """Check times and what a graph declares; flags and other columns are left aside.

    Raises:
        InputError: as `Demonstration.check`.
    """
    known = set(known_units(graph))
    for piece in pieces:
        bare = replace(piece, table=piece.table[[c for c in piece.table.columns if str(c) in known]])
        check_times(bare)
        bare.check(graph)
