"""Values of variables at which an interaction becomes possible or stops being possible, by the learned status models.

A drive is worth stopping there: ground enough for the next thing to be done, not to the brim that nobody showed.
Whether an interaction is possible at a value is asked in demonstrated states in which it was active, since what else it
needs may still have to be brought about.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ichain_drake.control.planning.carries import CarryOption
from ichain_drake.control.planning.model import Batch, is_change, span, take
from ichain_drake.control.planning.travel import jumping
from ichain_drake.control.settings import PLANNING
from ichain_drake.graph import Interaction
from ichain_drake.learning.model import InteractionModel
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import BoolArray, FloatArray

_VALUES = 41  # over the demonstrated range, so that a border is found to a fortieth of it


@dataclass(frozen=True)
class Border:
    """A value at which a drive may stop since an interaction is just surely possible there.

    Attributes:
        object: whose variable it is.
        variable: its index.
        value: in the variable's unit.
        edge: the interaction.
    """

    object: str
    variable: int
    value: float
    edge: Interaction


def find_borders(model: InteractionModel, carries: Sequence[CarryOption]) -> tuple[Border, ...]:
    """Borders of all variables but the robot's and those that carrying an object sets.

    Args:
        model: the learned graph.
        carries: objects that the robot can carry.
    """
    placed = {(c.edge.child, int(i)) for c in carries for i in c.follow}
    found: list[Border] = []
    for edge in model.graph.interactions:
        samples = active_samples(model, edge)
        if not len(samples[edge.child]):
            continue
        for obj in (edge.child, *model.graph.parents(edge.child)):
            if obj in model.graph.roots:
                continue
            skip = jumping(model.graph.objects[obj].observable) | is_change(model, obj)
            for i in np.flatnonzero(~skip):
                if (obj, int(i)) not in placed:
                    found += [Border(obj, int(i), value, edge) for value in _values(model, edge, samples, obj, int(i))]
    return tuple(found)


def active_samples(model: InteractionModel, edge: Interaction, most: int = PLANNING.states) -> Batch:
    """Demonstrated states in which an interaction was active, by its classifier too; shape (n, n_variables) each."""
    samples = dict(model.edges[edge].examples.active)
    rows = np.flatnonzero(model.decide(edge, samples) >= 0.0)
    if len(rows) > most:
        rows = rows[np.linspace(0, len(rows) - 1, most).round().astype(int)]
    return take(samples, rows)


def _values(model: InteractionModel, edge: Interaction, samples: Batch, obj: str, variable: int) -> list[float]:
    """Where a drive may stop: just inside each range of values at which the interaction is possible."""
    grid = np.linspace(model.low[obj][variable], model.high[obj][variable], _VALUES)
    batch = {n: np.tile(v, (_VALUES, 1)) for n, v in samples.items()}
    count = len(samples[obj])
    batch[obj][:, variable] = np.repeat(grid, count)
    share = (model.decide(edge, batch).reshape(_VALUES, count) >= 0.0).mean(axis=1)
    margin = max(LEARNING.clear * float(model.noise[obj][variable]), LEARNING.near * float(span(model, obj)[variable]))
    out = []
    for first, last in _runs(share > PLANNING.likely):
        low, high = grid[first], grid[last]
        inner = min(margin, 0.5 * float(high - low))
        out += [float(low) + inner] if first > 0 else []
        out += [float(high) - inner] if last < _VALUES - 1 else []
    return out


def _runs(on: BoolArray) -> list[tuple[int, int]]:
    """First and last index of each run of true values."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], on, [False]]).astype(int)))
    return [(int(a), int(b) - 1) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def crossed(values: FloatArray, border: float) -> tuple[int, float] | None:
    """Where a series first passes a value: index of the later neighbour, and the share of the way between the two.

    Args:
        values: shape (n,).
        border: the value.
    """
    off = values - border
    at = np.flatnonzero((off[:-1] * off[1:] <= 0.0) & (off[:-1] != 0.0))
    if not len(at):
        return None
    k = int(at[0])
    return k + 1, float(off[k] / (off[k] - off[k + 1]))
