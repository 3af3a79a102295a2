"""From gated effects to statuses row by row, and which of them nothing shows."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ichain_drake.graph import Interaction
from ichain_drake.learning.blocks import runs
from ichain_drake.learning.discovery.gate import Gate
from ichain_drake.learning.discovery.inputs import caused, gate_inputs
from ichain_drake.learning.discovery.log import Log
from ichain_drake.learning.discovery.settings import DISCOVERY
from ichain_drake.learning.discovery.structure import Explained
from ichain_drake.learning.discovery.term import Term
from ichain_drake.learning.effects.alignment import position_groups
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import BoolArray


@dataclass(frozen=True)
class EdgeFlags:
    """Statuses of one interaction in all rows of a log.

    Attributes:
        on: whether it is active, shape (n_rows,).
        open: rows in which nothing would show whether it is, shape (n_rows,).
    """

    on: BoolArray
    open: BoolArray


def edge_flags(log: Log, explained: Explained) -> dict[Interaction, EdgeFlags]:
    """Statuses of the interactions that act on one object.

    A term's status is that of its parent's interaction; an object that only a gate looks at shares it (paper sec. V: an
    edge for every object that has a say).
    """
    child = explained.residual.child
    acting = {t.parent for t in explained.terms} - {child}
    on: dict[str, BoolArray] = {}
    shown: dict[str, BoolArray] = {}
    for term in explained.terms:
        names = {term.parent} if term.parent != child else set()
        names |= term.objects - acting - {child}
        if not names:
            continue
        status, sure = _row_status(log, _tightened(log, term) if term.parent != child else term)
        for name in names:
            on[name] = on.get(name, False) | status
            shown[name] = shown.get(name, False) | sure
    out = {Interaction(p, child): EdgeFlags(on[p], ~shown[p]) for p in on}
    return {e: _with_known(log, e, f) for e, f in out.items()}


def _with_known(log: Log, edge: Interaction, flags: EdgeFlags) -> EdgeFlags:
    known = log.known.get(edge)
    if known is None:
        return flags
    told = log.rows_of(np.isfinite(known))
    return EdgeFlags(np.where(told, log.rows_of(known == 1.0), flags.on), flags.open & ~told)


def _row_status(log: Log, term: Term) -> tuple[BoolArray, BoolArray]:
    """Status of every row, and whether its effect would show there, shape (n_rows,) each."""
    rows = np.arange(len(log.piece))
    inputs = gate_inputs(log, term.parent, term.child, term.alignment, term.others, (rows, rows))
    on = term.gate.holds(inputs.at(term.inputs))
    shown = log.rows_of(np.abs(term.evidence) > DISCOVERY.shows)
    if term.window > 1:  # its evidence is smeared over a window
        return on, shown
    certain = DISCOVERY.certain
    on[log.t[term.evidence > certain] + 1] = True
    on[log.t[term.evidence < -certain] + 1] = False
    evidence = np.zeros(len(rows))
    evidence[log.t + 1] = term.evidence
    # What holds goes on holding until it opens: between switchings of a binary input the status is one.
    for item, used in zip(term.inputs, term.gate.used, strict=True):
        if not (used and item.binary):
            continue
        value = log.states[item.owner][:, item.variables[0]] > 0.5
        starts = np.flatnonzero(np.r_[True, (value[1:] != value[:-1]) | (log.piece[1:] != log.piece[:-1])])
        for a, b in zip(starts, [*starts[1:], len(value)], strict=True):
            total = float(evidence[a:b].sum())
            on[a:b] = total > 0 if abs(total) > certain else np.mean(on[a:b]) > 0.5
    return on, shown


def _tightened(log: Log, term: Term) -> Term:
    """Closed world: it acts only where it was seen to act, by the coordinates that are narrow there.

    A gate without evidence against it stays open: where nothing shows, nothing spoke for a face.
    """
    views = gate_inputs(log, term.parent, term.child, term.alignment, term.others)
    values = views.at(term.inputs)
    seen = term.on & (term.evidence > DISCOVERY.seen)
    if seen.sum() < LEARNING.several:
        seen = term.on & (term.evidence > DISCOVERY.likely)
    if seen.sum() < 4:
        return term
    if seen.sum() < LEARNING.several:
        seen = term.on
    barred = caused(views, log.spaces[term.child], term.child, term.parent, [e.variable for e in term.effects])
    use = {i.label for i, never in zip(views.items, barred, strict=True) if not never}
    low, high = term.gate.low.copy(), term.gate.high.copy()
    for j, item in enumerate(term.inputs):
        if item.label not in use or not item.place or item.owner not in (term.parent, term.child):
            continue
        (a, b), (least, most) = np.quantile(values[seen, j], [0.05, 0.95]), np.quantile(values[:, j], [0.02, 0.98])
        if most - least < 1e-9 or b - a > LEARNING.reach * (most - least):
            continue
        group = position_groups(log.spaces[item.owner])[0]
        noise = float(np.mean(log.noise[item.owner][list(group.indices)]))
        margin = 0.5 * LEARNING.reach * (b - a) + LEARNING.clear * noise
        a, b = np.quantile(values[seen, j], [0.02, 0.98])
        far = (b - a) + 2 * LEARNING.clear * noise  # a face that evidence put near stays
        low[j] = a - margin if a - low[j] > far else low[j]
        high[j] = b + margin if high[j] - b > far else high[j]
    gate = Gate(low, high)
    on = gate.holds(values)
    return replace(term, gate=gate, on=on) if (on & seen).sum() >= DISCOVERY.acts * seen.sum() else term


def open_stretches(open_rows: BoolArray, most: int) -> list[tuple[int, int]]:
    """The longest stretches (start, end) of rows that stay open; end is one past the last."""
    return sorted(runs(open_rows), key=lambda r: r[0] - r[1])[:most]
