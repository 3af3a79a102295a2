"""Checks of demonstration pieces with active flags, before anything is learned from them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from ichain_drake.demonstrations import Demonstration
from ichain_drake.demonstrations.checks import TIME_TOLERANCE
from ichain_drake.demonstrations.columns import TIME
from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.state import FloatArray
from ichain_drake.timing import TICK

_DIGITS = 9  # states that agree to so many decimals are the same state


def check_pieces(pieces: Sequence[Demonstration], graph: InteractionGraph, *, unlabelled: bool = False) -> None:
    """Check every piece on its own, and that their periods agree.

    Args:
        pieces: the pieces.
        graph: the interaction graph.
        unlabelled: whether flags may be missing, empty, or of other edges: they are then not looked at.

    Raises:
        InputError: if there is no piece, on doubled names, periods that differ, flags that are missing or belong to
            no edge of the graph, and whatever `Demonstration.check` refuses.
    """
    if not pieces:
        raise InputError("no demonstration piece given; record some with active flags")
    seen: set[str] = set()
    known = {e.name for e in graph.interactions}
    if unlabelled:
        bare = [p.table[[c for c in p.table.columns if "->" not in str(c)]] for p in pieces]
        pieces = [replace(p, table=table) for p, table in zip(pieces, bare, strict=True)]
    for piece in pieces:
        if piece.name in seen:
            raise InputError(f"piece {piece.name}: two pieces have this name; give each its own")
        seen.add(piece.name)
        flags = [str(c) for c in piece.table.columns if "->" in str(c)]
        lost = [e.name for e in graph.interactions if e.name not in flags]
        extra = [f for f in flags if f not in known]
        if extra:
            raise InputError(
                f"piece {piece.name}: flags for {extra[0]}, an edge that the graph lacks; remove the column, or add "
                f"the edge to the graph (it has {', '.join(sorted(known))})"
            )
        if lost and not unlabelled:
            what = "has no active flags" if len(lost) == len(known) else "lacks some active flags"
            raise InputError(
                f"piece {piece.name}: {what}; add a column {lost[0]} of 0 and 1 that says when {lost[0]} is active, or "
                "let --unlabelled infer it"
            )
    _check_periods(pieces, graph)
    for piece in pieces:
        piece.check(graph, list(graph.objects))


def _check_periods(pieces: Sequence[Demonstration], graph: InteractionGraph) -> None:
    timed = [(p, period) for p in pieces if np.isfinite(period := _period(p))]
    for piece, period in timed[1:]:
        first, usual = timed[0]
        if abs(period - usual) <= TIME_TOLERANCE * abs(usual):
            continue
        # The one that is further from what is needed is to blame, whichever comes first.
        (odd, its), (other, theirs) = (piece, period), (first, usual)
        if abs(usual - TICK) > abs(period - TICK):
            (odd, its), (other, theirs) = (other, theirs), (odd, its)
        shown = [e.name for e in graph.interactions if e.name in odd.table and (odd.table[e.name] == 1).any()]
        edge = shown[0] if shown else graph.interactions[0].name
        raise InputError(
            f"piece {odd.name}: its period is {its:.4g} s, but that of {other.name} is {theirs:.4g} s; {edge} can't be "
            "learned from both: record every piece at 3 Hz, or take them to it with --resample"
        )


def _period(piece: Demonstration) -> float:
    """Median time between rows [s]; NaN where the times can't be read, which is told later."""
    if TIME not in piece.table or len(piece) < 2:  # noqa: PLR2004
        return np.nan
    times = pd.to_numeric(piece.table[TIME], errors="coerce").to_numpy(dtype=float, na_value=np.nan)
    return float(np.median(np.diff(times)))


def check_flags(names: Sequence[str], flags: Mapping[Interaction, Sequence[NDArray[np.bool_]]]) -> None:
    """Check that every edge is seen active; one that is in every row is a permanent coupling, such as a gear.

    Args:
        names: of the pieces.
        flags: per edge and piece, shape (n_rows,).

    Raises:
        InputError: for an edge that is never active; names it and the pieces.
    """
    listed = ", ".join(names[:6]) + (", ..." if len(names) > 6 else "")
    for edge, parts in flags.items():
        if not any(p.any() for p in parts):
            raise InputError(
                f"{edge.name}: never active in any of the {len(names)} pieces ({listed}); record a piece in which "
                f"{edge.parent} acts on {edge.child}, or remove the edge"
            )


def check_contradictions(
    names: Sequence[str],
    flags: Mapping[Interaction, Sequence[NDArray[np.bool_]]],
    states: Mapping[str, Sequence[FloatArray]],
    graph: InteractionGraph,
) -> None:
    """Check that no state of a child and all its parents is flagged both ways.

    Args:
        names: of the pieces.
        flags: per edge and piece, shape (n_rows,).
        states: per object and piece, shape (n_rows, n_variables).
        graph: the interaction graph.

    Raises:
        InputError: names the edge, both pieces and both lines.
    """
    where = [(i, row) for i, part in enumerate(states[graph.root]) for row in range(len(part))]
    for child in graph.objects:
        incoming = graph.incoming(child)
        if not incoming:
            continue
        joined = np.hstack([np.vstack(states[n]) for n in (child, *graph.parents(child))])
        _, label = np.unique(np.round(joined, _DIGITS), axis=0, return_inverse=True)
        label = label.ravel()
        for edge in incoming:
            on = np.concatenate(flags[edge])
            total, positive = np.bincount(label), np.bincount(label, weights=on)
            mixed = np.flatnonzero((positive > 0) & (positive < total))
            if len(mixed):
                rows = np.flatnonzero(label == mixed[0])
                a, b = rows[on[rows]][0], rows[~on[rows]][0]
                (i, row_a), (j, row_b) = where[a], where[b]
                raise InputError(
                    f"{edge.name}: contradictory flags: piece {names[i]} line {row_a + 2} says active, piece "
                    f"{names[j]} line {row_b + 2} inactive, in the same state; correct one of them or remove the piece"
                )
