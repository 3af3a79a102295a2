"""What is odd about demonstrations, seen with what was learned from them: wrong flags, inverted edges, frozen feeds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ichain_drake.demonstrations import Demonstration
from ichain_drake.demonstrations.quality import beyond_chance
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.blocks import runs
from ichain_drake.learning.data import GraphData, collect
from ichain_drake.learning.model import InteractionModel
from ichain_drake.learning.selection import by_part, clearly
from ichain_drake.learning.status.candidates import status_candidates
from ichain_drake.learning.status.choice import InputChoice
from ichain_drake.learning.status.status import left_out_folds
from ichain_drake.timing import TICK


@dataclass(frozen=True)
class Finding:
    """Something about demonstrations that a person should look at.

    Attributes:
        piece: name of the piece; empty where it is about all.
        rows: first row of the piece's table and the one after the last; (0, 0) where it is about all rows.
        edge: name of the interaction, or of the object or variable, that it is about.
        text: in one line, with what to do.
        fatal: whether nothing right can be learned with it.
    """

    piece: str
    rows: tuple[int, int]
    edge: str
    text: str
    fatal: bool = False


def label_findings(
    pieces: Sequence[Demonstration], graph: InteractionGraph, model: InteractionModel
) -> tuple[Finding, ...]:
    """Flags, readings and pieces that don't go with the rest.

    Args:
        pieces: demonstrations with flags.
        graph: the interaction graph.
        model: learned from them.

    Raises:
        InputError: as `learn_interactions`, on pieces that can't be read.
    """
    return findings_in(collect(pieces, graph, graph.interactions), model)


def findings_in(data: GraphData, model: InteractionModel) -> tuple[Finding, ...]:
    """The same for pieces that are read already."""
    found = [*_copies(data), *_still(data), *_frozen(data, model)]
    for edge in data.edges:
        if any(edge in p.open for p in data.pieces):  # inferred: nobody flagged anything wrong
            continue
        inverted = _inverted(data, edge, model)
        found += inverted or _wrong_flags(data, edge, model)
    return tuple(found)


def _copies(data: GraphData) -> list[Finding]:
    """Pieces that were left out because they say the same as another."""
    return [
        Finding(
            copy,
            (0, 0),
            "",
            f"piece {copy}: every reading is that of piece {first}; it was left out, for it would be judged by itself",
        )
        for copy, first in data.copies.items()
    ]


def _still(data: GraphData) -> list[Finding]:
    found = []
    for obj, space in data.spaces.items():
        if obj in data.graph.roots:  # what it doesn't use it holds
            continue
        values = data.stacked(obj)
        for i, name in enumerate(space.names):
            if np.ptp(values[:, i]) == 0.0:
                text = f"{obj}.{name}: is {values[0, i]:g} in every row of all pieces; show it moving, or leave it out"
                found.append(Finding("", (0, 0), f"{obj}.{name}", text))
    return found


def _frozen(data: GraphData, model: InteractionModel) -> list[Finding]:
    """Stretches in which noisy readings repeat to the last digit, less probable than one in all rows."""
    found = []
    for obj, space in data.spaces.items():
        values = data.stacked(obj)
        noisy = np.array([v.kind in ("real", "angle") for v in space.variables])
        noisy &= model.noise[obj] > 1e-6 * np.maximum(np.ptp(values, axis=0), 1e-12)
        if not noisy.any():
            continue
        same = [_repeats(p.states[obj], noisy, space.lower, space.upper) for p in data.pieces]
        total, repeated = sum(len(s) for s in same), sum(int(s.sum()) for s in same)
        for piece, repeats in zip(data.pieces, same, strict=True):
            for a, b in runs(repeats):
                if beyond_chance(b - a, repeated, total):
                    text = (
                        f"piece {piece.name} rows {a} to {b}: readings of {obj} don't change in the last digit for "
                        f"{(b - a) * TICK:.1f} s: a frozen feed? Cut the rows, or record the piece anew"
                    )
                    found.append(Finding(piece.name, (a, b + 1), obj, text))
    return found


def _repeats(
    states: NDArray[np.float64], noisy: NDArray[np.bool_], lower: NDArray[np.float64], upper: NDArray[np.float64]
) -> NDArray[np.bool_]:
    """Rows whose noisy readings, but those at a bound, are all those of the row after, shape (n_rows - 1,)."""
    free = noisy & (states[:-1] > lower) & (states[:-1] < upper)
    equal = states[1:] == states[:-1]
    return np.asarray(free.any(axis=1) & (equal | ~free).all(axis=1))


def _inverted(data: GraphData, edge: Interaction, model: InteractionModel) -> list[Finding]:
    """Whether the flags of an edge say the opposite: what tells about them tells the contrary clearly better."""
    truth, piece = data.flag(edge), data.piece_index()
    if truth.all() or np.mean(truth) <= np.mean(~truth):
        return []
    candidates = status_candidates(data, edge, {e: k.alignment for e, k in model.edges.items()}, model.noise)
    likelihood = []
    for flags in (truth, ~truth):
        choice = InputChoice(flags, piece, left_out_folds(flags, piece), np.ones(len(flags), dtype=bool))
        likelihood.append(choice.left_out(choice.choose(candidates)))
    given, opposite = likelihood
    rate = np.where(truth, truth.mean(), 1.0 - truth.mean())
    if not clearly(by_part(opposite - given, piece), len(truth)):
        return []
    text = f"{edge.name}: its flags tell when it is inactive, not when it is active: they look inverted; swap 0 and 1"
    return [Finding("", (0, 0), edge.name, text, fatal=bool(given.sum() <= np.log(rate).sum()))]


def _wrong_flags(data: GraphData, edge: Interaction, model: InteractionModel) -> list[Finding]:
    """Stretches of flags against which all that was learned speaks, more than a chance among all rows would."""
    status = model.edges[edge].status
    found = []
    total = sum(len(p) for p in data.pieces)
    for piece in data.pieces:
        states = {n: piece.states[n] for n in (edge.child, *data.graph.parents(edge.child))}
        truth = piece.flags[edge]
        before = np.concatenate([truth[:1], truth[:-1]])
        on = status.probability(states, before)
        against = np.log(np.where(truth, 1.0 - on, on) / np.where(truth, on, 1.0 - on))
        for a, b in runs(against > 0.0):
            if b - a > 1 and against[a:b].sum() > 2.0 * np.log(total):
                said, told = ("active", "inactive") if truth[a] else ("inactive", "active")
                text = (
                    f"piece {piece.name} rows {a} to {b - 1}: {edge.name} is flagged {said}, but all other pieces say "
                    f"{told} there; correct the flags, or show what is different"
                )
                found.append(Finding(piece.name, (a, b), edge.name, text))
    return found
