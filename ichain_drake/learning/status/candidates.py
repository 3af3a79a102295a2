"""Everything that a status may depend on, as columns with the noise of their readings."""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np

from ichain_drake.graph import Interaction
from ichain_drake.learning.data import GraphData
from ichain_drake.learning.effects.alignment import Alignment
from ichain_drake.learning.status.choice import Candidate
from ichain_drake.learning.status.inputs import (
    DifferenceInput,
    PlaceInput,
    RelativeInput,
    StatusInput,
    ValueInput,
    candidate_inputs,
    objects_of,
)
from ichain_drake.learning.status.relative import rested
from ichain_drake.state import FloatArray


def status_candidates(
    data: GraphData,
    edge: Interaction,
    alignments: Mapping[Interaction, Alignment | None],
    noise: Mapping[str, FloatArray],
    affected: Collection[int] = (),
) -> list[Candidate]:
    """Everything that the status of an interaction may depend on, the likelier by its role first.

    Args:
        data, edge, alignments, noise, affected: as for `learn_status`.
    """
    states, truth, piece = states_around(data, edge), data.flag(edge), data.piece_index()
    ends, others = candidate_inputs(data, edge, alignments)
    # Before an activation the child is as it was one row earlier: what follows from a status doesn't tell it.
    first = np.concatenate([[True], piece[1:] != piece[:-1]])
    earlier = np.where(first | np.concatenate([[False], truth[:-1]]), np.arange(len(truth)), np.arange(len(truth)) - 1)
    lagged = states | {edge.child: states[edge.child][earlier]}
    out = []
    for item in (*ends, *others):
        caused = _is_caused(item, edge, affected)
        seen, floor = lagged if caused else states, input_noise(item, noise)
        if isinstance(item, RelativeInput) and not item.alignment.rows:
            # The one stands while the other passes: its noise would count against what is relative to it.
            seen = {n: rested(states[n], piece, noise[n]) for n in objects_of(item)}
        out.append(Candidate(item, item(seen), floor, caused))
    return out


def _is_caused(item: StatusInput, edge: Interaction, affected: Collection[int]) -> bool:
    """Whether an interaction changes what an input looks at; where child is relative to parent goes along."""
    if isinstance(item, ValueInput):
        return item.obj == edge.child and item.index in affected
    return isinstance(item, PlaceInput) and item.obj == edge.child and not set(item.group.indices).isdisjoint(affected)


def input_noise(item: StatusInput, noise: Mapping[str, FloatArray]) -> FloatArray:
    """Noise of an input's columns, shape (n_columns,)."""
    if isinstance(item, ValueInput):
        return noise[item.obj][[item.index]]
    if isinstance(item, DifferenceInput):
        return np.hypot(noise[item.parent][[item.index[0]]], noise[item.child][[item.index[1]]])
    # Along turned axes: the mean over the position's components.
    if isinstance(item, RelativeInput):
        two = item.alignment
        parent = float(np.mean(noise[item.edge.parent][list(two.parent.indices)]))
        child = float(np.mean(noise[item.edge.child][list(two.child.indices)]))
        return np.full(len(two.parent.indices), np.hypot(parent, child))
    return np.full(len(item.group.indices), float(np.mean(noise[item.obj][list(item.group.indices)])))


def states_around(data: GraphData, edge: Interaction) -> dict[str, FloatArray]:
    """States of an interaction's child and all that acts on it, shape (n, n_variables) each."""
    return {n: data.stacked(n) for n in (edge.child, *data.graph.parents(edge.child))}
