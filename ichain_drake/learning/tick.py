"""One tick of one object of a learned graph: which interactions act on it, and what comes of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ichain_drake.graph import Interaction
from ichain_drake.learning.effects.alignment import Alignment
from ichain_drake.learning.effects.effects import Effect
from ichain_drake.learning.passive import PassiveDynamics
from ichain_drake.learning.status.customary import CautiousStatus, Customary
from ichain_drake.learning.status.events import EdgeExamples
from ichain_drake.learning.status.inputs import RelativeInput
from ichain_drake.learning.status.status import StatusModel
from ichain_drake.state import BoolArray, FloatArray


@dataclass(frozen=True)
class LearnedInteraction:
    """Everything learned about one edge.

    Attributes:
        status: when it is active.
        customary: what else always held when it was; see `Customary`.
        effects: what it does to the child's variables while it is.
        alignment: how the child's position goes with the parent's, where it does.
        examples: its (de)activations in the demonstrations.
        active_low, active_high: range of the parent's states while active, shape (n_parent,).
        active_step: largest change of the parent in a tick while active, shape (n_parent,); 0 where there was none but
            noise.
    """

    status: StatusModel
    customary: Customary
    effects: tuple[Effect, ...]
    alignment: Alignment | None
    examples: EdgeExamples
    active_low: FloatArray
    active_high: FloatArray
    active_step: FloatArray

    @property
    def relative(self) -> bool:
        """Whether its status looks at where its two ends are relative to each other."""
        return any(isinstance(i, RelativeInput) for i in self.status.inputs)

    def cautious(self) -> LearnedInteraction:
        """The same, but active only under the customary conditions too."""
        return replace(self, status=CautiousStatus.of(self.status, self.customary))


def advance(
    edges: Mapping[Interaction, LearnedInteraction],
    incoming: Sequence[Interaction],
    passive: PassiveDynamics,
    rows: Mapping[str, FloatArray],
    after: Mapping[str, FloatArray],
    forced: Mapping[Interaction, BoolArray],
    before: Mapping[Interaction, BoolArray],
    on: dict[Interaction, BoolArray],
) -> FloatArray:
    """The next state of one object, shape (n, n_variables).

    Args:
        edges: all learned interactions.
        incoming: those that act on the object, in the order in which their effects are added.
        passive: its passive dynamics.
        rows: states of all objects at t, shape (n, ...).
        after: states at t + 1 as far as they are known; a parent that is missing is taken at t.
        forced: status to take as given, shape (n,).
        before: status at t where it is known.
        on: is given the status at t + 1 of the incoming interactions.
    """
    child = incoming[0].child
    state = rows[child]
    parents = {e.parent: after.get(e.parent, rows[e.parent]) for e in incoming}
    now = {**parents, child: state}
    changes, was = {}, {}
    for e in incoming:
        learned = edges[e]
        if e in forced:
            on[e] = forced[e]
        else:
            was[e] = before[e] if e in before else learned.status.active(rows)
            on[e] = learned.status.active(now) | was[e]
        if on[e].any():
            changes[e] = effects_of(learned, rows[e.parent], parents[e.parent], state)
    ahead = _combined(passive, state, incoming, on, changes)
    # What was active goes on only if it still is in the state that it leads to.
    dropped = False
    for e, known in was.items():
        if known.any():
            lost = known & ~edges[e].status.active({**parents, child: ahead}, known)
            on[e], dropped = on[e] & ~lost, dropped or bool(lost.any())
    return _combined(passive, state, incoming, on, changes) if dropped else ahead


def effects_of(
    learned: LearnedInteraction, parent: FloatArray, parent_next: FloatArray, child: FloatArray
) -> FloatArray:
    """What an interaction adds to the child's passive change, shape (n, n_child)."""
    out = np.zeros_like(child)
    for effect in learned.effects:
        out[:, effect.variable] = effect(parent, parent_next, child)
    return out


def _combined(
    passive: PassiveDynamics,
    state: FloatArray,
    incoming: Sequence[Interaction],
    on: Mapping[Interaction, BoolArray],
    changes: Mapping[Interaction, FloatArray],
) -> FloatArray:
    after = passive(state)
    for e in incoming:
        if e in changes:
            after += np.where(on[e][:, None], changes[e], 0.0)
    return passive.settle(state, after)
