"""Labels: active flags of demonstrations that have none, or some, out of their states (paper sec. V, its end)."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ichain_drake.demonstrations import Demonstration
from ichain_drake.demonstrations.columns import as_numbers
from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.blocks import runs
from ichain_drake.learning.discovery.log import RawPiece
from ichain_drake.learning.discovery.search import FoundEdge, search
from ichain_drake.state import FloatArray
from ichain_drake.timing import TICK

_ASKED = 5  # intervals that a person is asked for


@dataclass(frozen=True)
class Labelled:
    """Demonstrations with flags in every row, and how they came by them.

    Attributes:
        pieces: the demonstrations; in rows that `Demonstration.open` marks nothing shows, and an
            interaction is taken as active where the states are like those in which it was seen to act.
        graph: the graph without interactions that nothing shows.
        found: interactions whose flags were inferred.
        rows: of all pieces.
        unseen: interactions that nothing shows, and that are left out.
    """

    pieces: tuple[Demonstration, ...]
    graph: InteractionGraph
    found: tuple[FoundEdge, ...]
    rows: int
    unseen: tuple[Interaction, ...] = ()

    def open_rows(self, edge: Interaction) -> int:
        """Number of rows in which nothing would show whether an interaction is active."""
        return int(sum(p.open[edge.name].sum() for p in self.pieces if edge.name in p.open))

    def helpful(self) -> list[str]:
        """The longest stretches that stay open, in words: what a person's labels would tell most about."""
        stretches = [
            (b - a, f"{piece.name} rows {a} to {b - 1} ({(b - a) * TICK:.0f} s): is {name} active?")
            for piece in self.pieces
            for name, rows in piece.open.items()
            for a, b in runs(np.asarray(rows))
        ]
        return [text for _, text in sorted(stretches, key=lambda s: (-s[0], s[1]))[:_ASKED]]

    def lines(self) -> list[str]:
        """What was inferred, a line an interaction, and where a person's labels would help most."""
        out = [
            f"{f.edge.name}: inferred, sure by {f.confidence:.3f}; shows in {f.ticks} of {self.rows} rows, "
            f"{self.open_rows(f.edge)} stay open"
            + "".join(f"; or it is {r.parent} ({r.probability:.2f})" for r in f.rivals)
            for f in self.found
        ]
        out += [f"{e.name}: nothing shows that it acts; it is left out" for e in self.unseen]
        return out + [f"a label would help: {text}" for text in self.helpful()]

    def report(self) -> dict[str, Any]:
        """Plain numbers and texts, ready for JSON."""
        return {
            "rows": self.rows,
            "edges": {
                f.edge.name: edge_report(f, self.rows) | {"open_rows": self.open_rows(f.edge)} for f in self.found
            },
            "not_shown": [e.name for e in self.unseen],
            "labels_that_would_help": self.helpful(),
        }


def edge_report(found: FoundEdge, rows: int) -> dict[str, Any]:
    """What is said of a found interaction, as plain numbers and texts."""
    return {
        "confidence": round(found.confidence, 4),
        "gain_per_row": round(found.gain / max(rows, 1), 5),
        "shows_in_rows": found.ticks,
        "has_a_say_only": found.gates,
        "does": list(found.text),
        "rivals": {r.parent: round(r.probability, 4) for r in found.rivals},
    }


def raw_piece(piece: Demonstration, graph: InteractionGraph, flags: Collection[Interaction] = ()) -> RawPiece:
    """States of a demonstration, and what it says of some statuses (1, 0, or NaN where nothing)."""
    known = {e: values for e in flags if (values := known_flags(piece, e)) is not None}
    states = {n: np.ascontiguousarray(piece.states(n, s)) for n, s in graph.objects.items() if piece.has(n, s)}
    return RawPiece(piece.name, states, known)


def known_flags(piece: Demonstration, edge: Interaction) -> FloatArray | None:
    """Flags of an interaction, shape (n_rows,), NaN where nothing is known; None where that is everywhere.

    Raises:
        InputError: on a flag that is neither 0 nor 1 nor empty.
    """
    if edge.name not in piece.table:
        return None
    values = as_numbers(piece.table[edge.name])
    odd = np.isfinite(values) & ~np.isin(values, (0.0, 1.0))
    if odd.any():
        row = int(np.argmax(odd))
        raise InputError(
            f"{piece.name}: line {piece.first_line + row}, column {edge.name}: {values[row]:g} given; an active flag "
            "is 0 or 1, or empty where it is not known"
        )
    return values if np.isfinite(values).any() else None


def label_pieces(
    pieces: Sequence[Demonstration],
    graph: InteractionGraph,
    say: Callable[[str], None] | None = None,
) -> Labelled:
    """Flags of all interactions in all rows: those that are known, and else the likeliest.

    An unknown status is a hidden variable: what would be predicted if the interaction acted is weighed against what
    would be if it didn't, and both are learned from the rows that are taken so (hard EM).

    Args:
        pieces: with all objects; flag columns may be missing or hold NaN.
        graph: the interaction graph.
        say: called with a line at each step.

    Raises:
        InputError: on flags that are none, if nothing shows that anything acts on an object, or, where flags are
            missing, on a graph with several robots.
    """
    rows = sum(len(p) for p in pieces)
    raw = [raw_piece(p, graph, graph.interactions) for p in pieces]
    whole = [e for e in graph.interactions if all(np.isfinite(r.known.get(e, np.nan)).all() for r in raw)]
    if len(whole) == len(graph.interactions):
        return Labelled(tuple(pieces), graph, (), rows)
    spaces = {n: s.observable for n, s in graph.objects.items()}
    root = graph.only_root("inferring flags")
    found = search(raw, spaces, root, graph.interactions, (), say)
    inferred = {f.edge: f for f in found if f.edge not in whole}
    shown = {e for r in raw for e, values in r.known.items() if (values == 1.0).any()}
    unseen = tuple(e for e in graph.interactions if e not in inferred and e not in shown)
    left = [e for e in graph.interactions if e not in unseen]
    for obj in graph.objects:
        if obj != root and not any(e.child == obj for e in left):
            acting = ", ".join(e.name for e in unseen if e.child == obj)
            raise InputError(
                f"{acting}: the pieces don't show that anything acts on {obj}; record pieces in which it does, or "
                "label some of it (a column of 0 and 1, empty where it is not known)"
            )
    labelled = tuple(_complete(p, r, left, inferred) for p, r in zip(pieces, raw, strict=True))
    reduced = InteractionGraph(graph.objects, left, graph.origins) if unseen else graph
    return Labelled(labelled, reduced, tuple(inferred.values()), rows, unseen)


def flagged(pieces: Sequence[Demonstration], graph: InteractionGraph, found: Sequence[FoundEdge]) -> Labelled:
    """Flags of a discovered graph's interactions.

    Args:
        pieces: without flags.
        graph: with the interactions that were found.
        found: what was found about them.
    """
    inferred = {f.edge: f for f in found}
    raw = [raw_piece(p, graph) for p in pieces]
    labelled = tuple(_complete(p, r, graph.interactions, inferred) for p, r in zip(pieces, raw, strict=True))
    return Labelled(labelled, graph, tuple(found), sum(len(p) for p in pieces))


def _complete(
    piece: Demonstration, raw: RawPiece, edges: Sequence[Interaction], inferred: dict[Interaction, FoundEdge]
) -> Demonstration:
    table = piece.table.drop(columns=[c for c in piece.table.columns if "->" in str(c)])
    flags, still_open = {}, {}
    for e in edges:
        known = raw.known.get(e, np.full(len(piece), np.nan))
        told = inferred[e].on.get(piece.name) if e in inferred else None
        likely = np.zeros(len(piece), dtype=bool) if told is None else told
        flags[e.name] = np.where(np.isfinite(known), known, likely).astype(float)
        if e in inferred:
            nothing = inferred[e].open.get(piece.name, np.ones(len(piece), dtype=bool))
            still_open[e.name] = nothing & ~np.isfinite(known)
    return replace(piece, table=table.assign(**flags), open=still_open)
