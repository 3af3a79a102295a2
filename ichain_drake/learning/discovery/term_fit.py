"""One gated effect by hard EM: effect from ticks, evidence from effect, gate from evidence, ticks from gate."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ichain_drake.graph import Interaction
from ichain_drake.learning.discovery.effect_fit import explained, fit_effects
from ichain_drake.learning.discovery.features import Features, features
from ichain_drake.learning.discovery.gate import Gate, GateSearch
from ichain_drake.learning.discovery.inputs import GateInputs, caused, gate_inputs
from ichain_drake.learning.discovery.residual import Residual
from ichain_drake.learning.discovery.settings import DISCOVERY
from ichain_drake.learning.discovery.starts import starts
from ichain_drake.learning.discovery.term import Term, VariableEffect
from ichain_drake.learning.discovery.turning import tick_alignment
from ichain_drake.learning.effects.alignment import Alignment, position_groups
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import BoolArray, FloatArray


@dataclass(frozen=True, eq=False)
class _Views:
    """What depends on the alignment of parent and child."""

    alignment: Alignment | None
    inputs: GateInputs
    columns: Features
    search: GateSearch


def _views(residual: Residual, parent: str, others: Sequence[str], alignment: Alignment | None) -> _Views:
    log, child = residual.log, residual.child
    inputs = gate_inputs(log, parent, child, alignment, others)
    search = GateSearch(inputs, {parent, child}, DISCOVERY.other_object)
    return _Views(alignment, inputs, features(residual, parent, alignment), search)


def fit_term(
    residual: Residual, parent: str, others: Sequence[str] = (), start: BoolArray | None = None
) -> Term | None:
    """The best gated effect of a parent on what is left of a child's motion, or None where nothing is explained.

    Args:
        residual: what is left.
        parent: an object, or the child itself for what it does alone.
        others: further objects that the gate may look at.
        start: ticks to begin with, shape (n_ticks,), in place of several sets.
    """
    log = residual.log
    every = np.ones(len(log.t), dtype=bool)
    placed = bool(position_groups(log.spaces[parent]) and position_groups(residual.space))
    movable = parent == log.root and placed and parent != residual.child
    alignment = None
    if movable:  # where both move, they may move together
        indices = list(position_groups(residual.space)[0].indices)
        loud = np.abs(residual.values[:, indices]) > LEARNING.surely * residual.spread[:, indices]
        alignment = tick_alignment(log, parent, residual.child, np.asarray(loud.any(axis=1)))
    views = _views(residual, parent, others, alignment)
    best: Term | None = None
    for rows in [start] if start is not None else starts(residual, views.inputs, every):
        term = _climb(residual, parent, others, views, rows, every, DISCOVERY.rounds, movable=movable)
        if term is not None and _has_say(term, views) and (best is None or term.value > best.value):
            best = term
    if best is not None and any(e.columns and not e.declared for e in best.effects):
        # A line in an input may be a step of it: what a gate and a constant say with fewer parameters.
        size = np.abs(best.predicted[:, [e.variable for e in best.effects]]).max(axis=1)
        high = best.on & (size > DISCOVERY.close * np.quantile(size[best.on], 0.9)) if best.on.any() else best.on
        step = _climb(residual, parent, others, views, high, every, DISCOVERY.rounds, movable=movable)
        if step is not None and _has_say(step, views) and step.value > best.value:
            best = step
    return best


def _has_say(term: Term, views: _Views) -> bool:
    """Whether a term looks at its parent at all: when others act and what the child then does is not the parent's."""
    if term.parent == term.child or any(term.inputs[k].owner == term.parent for k in np.flatnonzero(term.gate.used)):
        return True
    return any(bool(views.columns.foreign[c]) for e in term.effects for c in e.columns)


def fit_passive(residual: Residual) -> Term | None:
    """What the child does all the time by itself, as a term without a gate and judged, or None."""
    every = np.ones(len(residual.values), dtype=bool)
    views = _views(residual, residual.child, (), None)

    def fitted(rows: BoolArray) -> tuple[VariableEffect, ...]:
        # Only by the variable itself: where an object is goes along with what is done to it there.
        own = views.columns.own
        return tuple(e for e in fit_effects(residual, rows, views.columns) if e.columns == (own.get(e.variable, -1),))

    effects = fitted(every)
    if not effects:
        return None
    gains = np.zeros(len(residual.values))
    for k in np.unique(residual.log.fold):
        out = residual.log.fold == k
        gains += np.where(out, explained(residual, fitted(~out), views.columns)[0], 0.0)
    evidence, predicted = explained(residual, effects, views.columns)
    none = np.full(len(views.inputs.items), np.inf)
    value = float(evidence.sum()) - sum(e.price() for e in effects)
    return Term(
        residual.child, residual.child, effects, Gate(-none, none), views.inputs.items, views.columns.labels, None, (),
        residual.window, every, predicted, evidence, value, gains,
    )  # fmt: skip


def judged(residual: Residual, term: Term) -> Term:
    """The same with its evidence on ticks that were left out, each by a fit to the other folds."""
    views = _views(residual, term.parent, term.others, term.alignment)
    gains = np.zeros(len(residual.values))
    for k in np.unique(residual.log.fold):
        train = residual.log.fold != k
        rows = term.on & train
        fitted = _climb(
            residual, term.parent, term.others, views, rows, train, DISCOVERY.left_out_rounds, movable=False
        )
        if fitted is not None:
            gains += np.where(~train & fitted.on, fitted.evidence, 0.0)
    return replace(term, left_out=gains)


def _climb(
    residual: Residual,
    parent: str,
    others: Sequence[str],
    views: _Views,
    rows: BoolArray,
    train: BoolArray,
    rounds: int,
    *,
    movable: bool,
) -> Term | None:
    """Alternate between effect and gate until the gate stays."""
    best: Term | None = None
    before = b""
    for k in range(rounds):
        effects = fit_effects(residual, rows & train, views.columns)
        if not effects:
            break
        evidence, predicted = explained(residual, effects, views.columns)
        evidence = _pinned(residual, parent, evidence)
        changed = [e.variable for e in effects]
        usable = ~caused(views.inputs, residual.space, residual.child, parent, changed)
        gate, value = views.search(np.where(train, evidence, 0.0), usable)
        on = gate.holds(views.inputs.values)
        value -= sum(e.price() for e in effects)
        term = Term(
            parent, residual.child, effects, gate, views.inputs.items, views.columns.labels, views.alignment,
            tuple(others), residual.window, on, predicted, evidence, value, np.zeros(len(on)),
        )  # fmt: skip
        if best is None or term.value > best.value:
            best = term
        if on.tobytes() == before:
            break
        before, rows = on.tobytes(), on
        if movable and k < DISCOVERY.rounds - 2:
            alignment = tick_alignment(residual.log, parent, residual.child, on & (evidence > DISCOVERY.shows) & train)
            if alignment is not None:
                views = _views(residual, parent, others, alignment)
    return best


def _pinned(residual: Residual, parent: str, evidence: FloatArray) -> FloatArray:
    """Evidence with what is known of the status counted as sure."""
    known = residual.log.known.get(Interaction(parent, residual.child))
    if known is None:
        return evidence
    clip = DISCOVERY.clip
    return np.where(np.isfinite(known), clip * np.sign(known - 0.5), evidence)
