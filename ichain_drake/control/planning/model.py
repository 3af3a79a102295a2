"""What planning needs of a learned interaction graph: the contract between learning and the planner."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.state import FloatArray

BoolArray = NDArray[np.bool_]
Batch = dict[str, FloatArray]
"""States of every object and the robot, shape (n, n_variables) each."""


class SwitchingExamples(Protocol):
    """Rows around (de)activations; `after` is the first row after each, shape (n_events, n_variables) per object."""

    @property
    def after(self) -> Mapping[str, FloatArray]: ...  # noqa: D102


class EdgeSamples(Protocol):
    """Demonstrated states of one interaction: while it is active, and where it was switched."""

    @property
    def active(self) -> Mapping[str, FloatArray]: ...  # noqa: D102

    @property
    def deactivations(self) -> SwitchingExamples: ...  # noqa: D102


class VariableEffect(Protocol):
    """An effect; `variable` is the index of the child's variable that it changes."""

    @property
    def variable(self) -> int: ...  # noqa: D102


class LearnedEdge(Protocol):
    """What was learned about one interaction."""

    @property
    def effects(self) -> Sequence[VariableEffect]: ...  # noqa: D102

    @property
    def examples(self) -> EdgeSamples: ...  # noqa: D102

    @property
    def active_step(self) -> FloatArray: ...  # noqa: D102 - of the parent while active, 0 where it only stood

    @property
    def alignment(self) -> Any: ...  # noqa: D102 - how the child's position goes with the parent's, or None

    @property
    def relative(self) -> bool: ...  # noqa: D102 - whether the status looks at where the two are to each other


class PassiveKind(Protocol):
    """Passive dynamics of a variable; `kind` is `hold`, `constant`, `learned` or `change`."""

    @property
    def kind(self) -> str: ...  # noqa: D102


class ObjectPassive(Protocol):
    """Passive dynamics of an object, one entry a variable."""

    @property
    def variables(self) -> Sequence[PassiveKind]: ...  # noqa: D102


class GraphModel(Protocol):
    """A learned interaction graph, as `learning.InteractionModel` is one.

    Attributes:
        graph: objects and interactions.
        edges: per interaction, its effects and demonstrated samples.
        passive: per object but the root, what its variables do while nothing acts.
        low, high: demonstrated range per object, shape (n_variables,).
        step_limit: largest demonstrated change in a tick per object, shape (n_variables,).
        noise: standard deviation of a reading per object, shape (n_variables,).
    """

    @property
    def graph(self) -> InteractionGraph: ...  # noqa: D102

    @property
    def edges(self) -> Mapping[Interaction, Any]: ...  # noqa: D102 - values are `LearnedEdge`

    @property
    def passive(self) -> Mapping[str, Any]: ...  # noqa: D102 - values are `ObjectPassive`

    @property
    def low(self) -> Mapping[str, FloatArray]: ...  # noqa: D102

    @property
    def high(self) -> Mapping[str, FloatArray]: ...  # noqa: D102

    @property
    def step_limit(self) -> Mapping[str, FloatArray]: ...  # noqa: D102

    @property
    def noise(self) -> Mapping[str, FloatArray]: ...  # noqa: D102

    def decide(self, edge: Interaction, states: Mapping[str, FloatArray]) -> FloatArray:
        """Decision value of an interaction's status, shape (...): >= 0 means active."""
        ...

    def probability(self, edge: Interaction, states: Mapping[str, FloatArray]) -> FloatArray:
        """Calibrated probability that an interaction is active, shape (...)."""
        ...

    def spread(self, child: str, active: Sequence[Interaction]) -> FloatArray:
        """Standard deviation of a one-tick prediction while some interactions are active, shape (n_variables,)."""
        ...

    def active(self, states: Mapping[str, FloatArray]) -> dict[Interaction, BoolArray]:
        """Which interactions are active, shape (...) each."""
        ...

    def effect(self, edge: Interaction, states: Mapping[str, FloatArray], parent_next: ArrayLike) -> FloatArray:
        """What an interaction would add to the child's passive change in a tick, shape (..., n_child)."""
        ...

    def step(
        self,
        states: Mapping[str, FloatArray],
        root_next: ArrayLike,
        active: Mapping[Interaction, ArrayLike] | None = None,
        *,
        strict: bool = True,
    ) -> tuple[dict[str, FloatArray], dict[Interaction, BoolArray]]:
        """States and status one tick later, with the root at `root_next` then.

        A planner is not `strict` about cycles of active interactions: one odd row of hundreds must not end a search.
        """
        ...

    def customary(self, edge: Interaction) -> tuple[str, ...]:
        """What always held while an interaction was active, in words, without being known to matter."""
        ...

    def cautious(self, edges: Collection[Interaction]) -> GraphModel:
        """The same model, in which some interactions are active only under their customary conditions."""
        ...


def keeps(model: GraphModel, obj: str) -> BoolArray:
    """Which variables of an object keep their value or drift while nothing acts on it, shape (n_variables,)."""
    return np.array([v.kind in ("hold", "learned") for v in model.passive[obj].variables], dtype=bool)


def is_change(model: GraphModel, obj: str) -> BoolArray:
    """Which variables of an object are the change of another one in a tick, shape (n_variables,)."""
    return np.array([v.kind == "change" for v in model.passive[obj].variables], dtype=bool)


def conserved(model: GraphModel) -> tuple[tuple[tuple[str, int], ...], ...]:
    """Variables whose role is a conserved amount, as (object, index), grouped by unit."""
    found: dict[str, list[tuple[str, int]]] = {}
    for name in model.passive:
        space = model.graph.objects[name].observable
        for i in space.role_indices("amount"):
            found.setdefault(space.variables[i].unit, []).append((name, int(i)))
    return tuple(tuple(group) for group in found.values())


def span(model: GraphModel, obj: str) -> FloatArray:
    """Width of the demonstrated range, shape (n_variables,), in the variables' units; above 0."""
    return np.maximum(model.high[obj] - model.low[obj], 1e-9)


def stack(states: Sequence[Mapping[str, FloatArray]]) -> Batch:
    """Rows of several states."""
    return {n: np.array([s[n] for s in states], dtype=float) for n in states[0]}


def row(batch: Mapping[str, FloatArray], index: int) -> Batch:
    """One row of a batch, shape (n_variables,) each."""
    return {n: np.array(v[index]) for n, v in batch.items()}


def take(batch: Mapping[str, FloatArray], rows: ArrayLike) -> Batch:
    """Some rows of a batch."""
    return {n: v[np.asarray(rows)] for n, v in batch.items()}
