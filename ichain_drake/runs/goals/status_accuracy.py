"""How well status classifiers tell held-out pieces and near misses: figures per interaction, for an evaluation.

Only an evaluator may look at what is used here: other seeds' pieces, and the true regions in which interactions act.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ichain_drake.demonstrations import Demonstration
from ichain_drake.graph import Interaction
from ichain_drake.learning import InteractionModel, event_f1, f1
from ichain_drake.learning.status.scores import switches
from ichain_drake.scenarios.probes import Probes, States
from ichain_drake.state import BoolArray

LEAST_EVENTS = 40
"""Switching events of each interaction that held-out pieces should show."""


def count_events(pieces: Sequence[Demonstration], edge: Interaction) -> int:
    """Activations and deactivations of an interaction in pieces."""
    return sum(len(rows) for p in pieces for rows in switches(_flag(p, edge)))


def held_out_scores(model: InteractionModel, pieces: Sequence[Demonstration]) -> dict[Interaction, dict[str, Any]]:
    """Figures on pieces that nothing was learned from.

    Returns:
        Per interaction `rows`, `status_f1` (each row by itself), `events` and `event_f1`: activations and
        deactivations within one row, row by row with the classifier's own hysteresis.
    """
    graph = model.graph
    truths: dict[Interaction, list[BoolArray]] = {e: [] for e in graph.interactions}
    told: dict[Interaction, list[BoolArray]] = {e: [] for e in graph.interactions}
    followed: dict[Interaction, list[BoolArray]] = {e: [] for e in graph.interactions}
    for piece in pieces:
        states = {n: piece.states(n, s) for n, s in graph.objects.items()}
        trace = _follow(model, states, len(piece))
        for e in graph.interactions:
            truths[e].append(_flag(piece, e))
            told[e].append(np.asarray(model.decide(e, states) >= 0.0))
            followed[e].append(trace[e])
    return {
        e: {
            "rows": sum(len(t) for t in truths[e]),
            "status_f1": f1(np.concatenate(truths[e]), np.concatenate(told[e])),
            "events": count_events(pieces, e),
            "event_f1": event_f1(truths[e], followed[e]),
        }
        for e in graph.interactions
    }


def probe_scores(model: InteractionModel, edge: Interaction, probes: Probes | None) -> dict[str, Any]:
    """Figures on near misses beside as many states inside.

    Returns:
        `near_misses`, `near_miss_f1` on true states, `near_miss_read_f1` on readings, and `gate_read_f1`: how well
        the true region itself tells those readings. None where there are no probes. `borders`: the same for each
        border by itself, by the object that was moved; empty where there are not several.
    """
    if probes is None:
        return {**dict.fromkeys(("near_misses", "near_miss_f1", "near_miss_read_f1", "gate_read_f1")), "borders": {}}
    told, read = (np.asarray(model.decide(edge, s) >= 0.0) for s in (probes.true, probes.read))
    all_of_them = np.ones(len(probes.active), dtype=bool)
    names, border = list(dict.fromkeys(probes.border)), np.array(probes.border)
    several = {n: _figures(probes, told, read, border == n) for n in names} if len(names) > 1 else {}
    return {**_figures(probes, told, read, all_of_them), "borders": several}


def _figures(probes: Probes, told: BoolArray, read: BoolArray, chosen: BoolArray) -> dict[str, Any]:
    active = probes.active[chosen]
    return {
        "near_misses": int(np.sum(~active)),
        "near_miss_f1": f1(active, told[chosen]),
        "near_miss_read_f1": f1(active, read[chosen]),
        "gate_read_f1": f1(active, probes.gate[chosen]),
    }


def _flag(piece: Demonstration, edge: Interaction) -> BoolArray:
    return np.asarray(piece.table[edge.name].to_numpy(dtype=float) > 0.5)  # noqa: PLR2004 - a flag


def _follow(model: InteractionModel, states: States, rows: int) -> dict[Interaction, BoolArray]:
    """Status from row to row, shape (n_rows,) per interaction."""
    found: dict[Interaction, list[bool]] = {e: [] for e in model.graph.interactions}
    before: dict[Interaction, BoolArray] | None = None
    for k in range(rows):
        before = model.active({n: s[k] for n, s in states.items()}, before)
        for e, on in before.items():
            found[e].append(bool(on))
    return {e: np.array(on, dtype=bool) for e, on in found.items()}
