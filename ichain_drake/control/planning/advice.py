"""Which demonstration would have helped most where a goal was not reached: what to show, like which piece, where."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ichain_drake.control.planning.experience import Contradiction
from ichain_drake.control.planning.model import span
from ichain_drake.control.planning.plan import NoPlan, States
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.model import InteractionModel
from ichain_drake.learning.settings import LEARNING


@dataclass(frozen=True)
class Advice:
    """A piece that nobody recorded.

    Attributes:
        edge: interaction that it would show.
        piece: that shows it where most was as it was in the run.
        region: what was otherwise in the run, by object and variable, most first; empty where nothing was.
    """

    edge: Interaction
    piece: str
    region: Mapping[tuple[str, str], float]

    def text(self, graph: InteractionGraph) -> str:
        """In one line."""
        units = {
            (n, v.name): "" if v.unit == "1" else f" {v.unit}"
            for n, space in graph.objects.items()
            for v in space.variables
        }
        where = " and ".join(f"{n}.{v} about {x:.3g}{units[n, v]}" for (n, v), x in self.region.items())
        like = f"like {self.piece}, but with {where}" if where else f"such as {self.piece}"
        return f"what would have helped most: another piece that shows {self.edge.name}, {like}"

    def report(self) -> dict[str, object]:
        """As plain data."""
        region = {f"{n}.{v}": value for (n, v), value in self.region.items()}
        return {"interaction": self.edge.name, "like": self.piece, "with": region}


def helpful_demonstration(
    model: InteractionModel, contradictions: Sequence[Contradiction], refused: NoPlan | None, now: States
) -> Advice | None:
    """What to demonstrate, so that it would be known whether what failed can work.

    Of the steps that failed most often it is about the interaction that began farthest, in demonstrated ranges, from
    wherever it was shown to begin; without any, about the one that a plan lacked.

    Args:
        model: the learned graph.
        contradictions: steps that did not do what was predicted.
        refused: why there was no plan in the end, if there was none.
        now: measured states, shape (n_variables,) each, for what was refused.

    Returns:
        None where there is nothing to go by, or no interaction is to blame.
    """
    if refused is not None and refused.edge is None:  # such as of what there is too little: nothing to be shown
        return None
    if contradictions:
        often = Counter(c.step.chain for c in contradictions)
        last = max(contradictions[::-1], key=lambda c: often[c.step.chain])
        chain, states = last.step.chain, last.began
    elif refused is not None and refused.edge is not None:
        chain, states = (refused.edge,), now
    else:
        return None
    moved = {e.parent for e in chain}  # by the step itself
    found = [f for e in chain if (f := _farthest(model, e, states, moved)) is not None]
    return max(found, key=lambda f: f[0])[1] if found else None


def _farthest(
    model: InteractionModel, edge: Interaction, states: States, moved: set[str]
) -> tuple[float, Advice] | None:
    """How far states are from the nearest ones in which an interaction was shown to begin, and what is to be shown."""
    shown = model.edges[edge].examples.activations
    if not len(shown):
        return None
    names, away = list[tuple[str, str]](), list[np.ndarray]()
    for n in model.suspects(edge):
        if n not in moved and n in shown.before:
            space = model.graph.objects[n].observable
            away += list((space.difference(shown.before[n], states[n]) / span(model, n)).T)
            names += [(n, v) for v in space.names]
    if not names:
        return 0.0, Advice(edge, shown.pieces[0], {})
    shares = np.abs(np.array(away))
    row = int(np.argmin(shares.max(axis=0)))
    order = np.argsort(-shares[:, row], kind="stable")
    odd = [names[k] for k in order.tolist() if shares[k, row] > LEARNING.near]
    region = {(n, v): float(states[n][model.graph.objects[n].observable.index(v)]) for n, v in odd}
    return float(shares[:, row].max()), Advice(edge, shown.pieces[row], region)
