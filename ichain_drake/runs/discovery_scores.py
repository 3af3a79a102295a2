"""Figures of what was found out of states: edges, flags and cuts, against true ones."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from ichain_drake.demonstrations import Demonstration
from ichain_drake.demonstrations.columns import TIME
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.discovery.search import FoundEdge
from ichain_drake.learning.status.scores import event_f1, f1
from ichain_drake.state import BoolArray
from ichain_drake.timing import TICK

_KEYS = ("all", "shown", "switchings")
_TASKS = ("reached", "reached_with_flags")

Row = dict[str, Any]


def scores(found: Sequence[FoundEdge], pieces: Sequence[Demonstration], graph: InteractionGraph) -> Row:
    """Figures of what was found.

    Returns:
        `true` (how many there are), `missing`, `extra` and `shd` (structural Hamming distance: both together, a turned
        edge once), and `flags`: per true edge that was found F1 on all rows, on rows in which its effect shows, and of
        its switchings within one row; of those that were not found 0.
    """
    by_edge = {f.edge: f for f in found}
    flags = {e.name: _flag_scores(by_edge.get(e), pieces, e) for e in graph.interactions}
    return edge_scores(by_edge, graph) | {"flags": flags}


def edge_scores(got: Collection[Interaction], graph: InteractionGraph) -> Row:
    """Figures of edges alone; see `scores`, whose `flags` are empty here."""
    true, got = set(graph.interactions), set(got)
    missing, extra = true - got, got - true
    turned = sum(Interaction(e.child, e.parent) in extra for e in missing)
    return {
        "true": len(true),
        "missing": sorted(e.name for e in missing),
        "extra": sorted(e.name for e in extra),
        "shd": len(missing) + len(extra) - turned,
        "flags": {},
    }


def _flag_scores(found: FoundEdge | None, pieces: Sequence[Demonstration], edge: Interaction) -> dict[str, float]:
    if found is None:
        return {"all": 0.0, "shown": 0.0, "switchings": 0.0}
    truths: list[BoolArray] = []
    told: list[BoolArray] = []
    shown: list[BoolArray] = []
    for piece in pieces:
        if edge.name in piece.table and piece.name in found.on:
            truths.append(np.asarray(piece.table[edge.name].to_numpy(dtype=float) > 0.5))  # noqa: PLR2004 - a flag
            told.append(found.on[piece.name])
            shown.append(~found.open[piece.name])
    if not truths:  # flagged in no piece: a permanent coupling
        return {"all": 1.0, "shown": 1.0, "switchings": 1.0}
    truth, on, sure = (np.concatenate(parts) for parts in (truths, told, shown))
    return {
        "all": round(f1(truth, on), 4),
        "shown": round(f1(truth[sure], on[sure]), 4),
        "switchings": round(event_f1(truths, told), 4),
    }


def one_recording_each(pieces: Sequence[Demonstration]) -> tuple[list[Demonstration], list[list[int]]]:
    """Pieces that hold the same columns joined to one recording, and the rows at which its resets are."""
    alike: dict[tuple[str, ...], list[Demonstration]] = {}
    for piece in pieces:
        alike.setdefault(tuple(sorted(map(str, piece.table.columns))), []).append(piece)
    resets = [np.cumsum([len(p) for p in parts])[:-1].tolist() for parts in alike.values()]
    return [joined(parts, f"recording{k}") for k, parts in enumerate(alike.values())], resets


def cut_scores(cuts: Sequence[Sequence[int]], resets: Sequence[Sequence[int]]) -> Row:
    """Figures of cuts of recordings against the rows of their resets; a cut counts within one row.

    Returns:
        As `scores`: `true` (how many resets there are), `missing` and `extra` (`recording/row`), `shd` (both together).
    """
    missing, extra = [], []
    for k, (got, true) in enumerate(zip(cuts, resets, strict=True)):
        left = sorted(got)
        for row in sorted(true):
            near = [c for c in left if abs(c - row) <= 1]
            if near:
                left.remove(min(near, key=lambda c: abs(c - row)))
            else:
                missing.append(f"recording{k}/{row}")
        extra += [f"recording{k}/{row}" for row in left]
    true_ones = sum(map(len, resets))
    return {"true": true_ones, "missing": missing, "extra": extra, "shd": len(missing) + len(extra), "flags": {}}


def joined(pieces: Sequence[Demonstration], name: str) -> Demonstration:
    """One recording without a mark between its pieces: states alone, its clock going on."""
    table = pd.concat([p.table[[c for c in p.table.columns if "->" not in str(c)]] for p in pieces], ignore_index=True)
    return Demonstration(table.assign(**{TIME: TICK * np.arange(len(table))}), pieces[0].units, name)


def summary(method: str, rows: Sequence[Mapping[str, Any]]) -> Row:
    """One line of the table: sums over seeds, and the mean F1 of flags; of tasks, how many reached their goals."""
    done = [r for r in rows if not r["reason"]]
    every = [f for r in done for f in r["flags"].values()]
    edges = sum(r["true"] for r in done)
    missing, extra = (sum(len(r[key]) for r in done) for key in ("missing", "extra"))
    got = edges - missing
    return {
        "method": method,
        "seeds": len(rows),
        "failed": len(rows) - len(done),
        "recall": got / edges if edges else None,
        "precision": got / (got + extra) if got + extra else None,
        "mean_shd": float(np.mean([r["shd"] for r in done])) if done else None,
        "exact": sum(r["shd"] == 0 for r in done),
        **{f"f1_{key}": float(np.mean([f[key] for f in every])) if every else None for key in _KEYS},
        **{key: sum(r[key] for r in done) if done and key in done[0] else None for key in _TASKS},
        "seconds": float(np.mean([r["seconds"] for r in done])) if done else None,
    }
