"""Transition and inverse transition models of one interaction (paper sec. III: Tr and Tr^-1)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ichain_drake.graph import Origin
from ichain_drake.learning.features import ChangeCode, FeatureKind, StateFeatures
from ichain_drake.learning.frozen import FrozenModel
from ichain_drake.state import FloatArray, StateSpace

ActionKind = Literal["next", "current", "both"]
"""Which state of the parent is the action: at t + 1 (the paper's finding, sec. III), at t (the other convention), or
both: where the parent came from matters when it takes part of the tick to arrive."""


class _LinkModel:
    """What the two models of an interaction make of their spaces, features and origin."""

    child_space: StateSpace
    parent_space: StateSpace
    features: FeatureKind
    origin: Origin | None

    @cached_property
    def _offset(self) -> FloatArray | None:
        return None if self.origin is None else self.origin.offset(self.parent_space)

    @cached_property
    def _child_features(self) -> StateFeatures:
        return StateFeatures(self.child_space, self.features)

    @cached_property
    def code(self) -> ChangeCode:
        """How a change of the child is coded."""
        return ChangeCode(self.child_space, self.features)


class Prediction(NamedTuple):
    """A prediction as it is noted for its derivatives: states, the coded change, and the regression's own note."""

    child: FloatArray
    parent: FloatArray
    parent_next: FloatArray
    code: FloatArray
    frozen: Any


@dataclass(frozen=True)
class ForwardModel(_LinkModel):
    """Tr: the child's next state from its state and its parent's (paper sec. III).

    Attributes:
        child_space, parent_space: observable state spaces.
        features: what the regression sees of the child.
        action: which state of the parent it sees.
        frozen: the fitted regression, from features and action to the coded change.
        origin: what the parent's positions are relative to in the regression (and nowhere else): the child's declared
            origin; None where none is declared.
    """

    child_space: StateSpace
    parent_space: StateSpace
    features: FeatureKind
    action: ActionKind
    frozen: FrozenModel
    origin: Origin | None = None

    @cached_property
    def _parent_features(self) -> StateFeatures:
        return StateFeatures(self.parent_space, "raw")

    def inputs(self, child: NDArray, parent: NDArray, parent_next: NDArray) -> NDArray:
        """Regression inputs, shape (..., n_in), from states of shape (..., n)."""
        parts = self._child_features.parts(child)
        if self._offset is not None:
            parent, parent_next = parent - self._offset, parent_next - self._offset
        if self.action in ("current", "both"):
            parts += self._parent_features.parts(parent)
        if self.action in ("next", "both"):
            parts += self._parent_features.parts(parent_next)
        return np.concatenate(parts, axis=-1)

    def predict_row(self, child: FloatArray, parent: FloatArray, parent_next: FloatArray) -> FloatArray:
        """Next state of the child, shape (n_child,); this one-row evaluation is what a learned object calls."""
        code = self.frozen.value(self.inputs(child, parent, parent_next))
        return self.code.wrap(self.code.decode(child, code))

    def predict(self, child: FloatArray, parent: FloatArray, parent_next: FloatArray) -> FloatArray:
        """Next states of the child, shape (n, n_child), for a batch; equal to `predict_row` within 1e-12."""
        code = self.frozen.batch(self.inputs(child, parent, parent_next))
        return self.code.wrap(self.code.decode(child, code))

    def spread(self, child: FloatArray, parent: FloatArray, parent_next: FloatArray) -> FloatArray:
        """Standard deviation of the coded change, shape (n, n_child), in the child's units."""
        return self.frozen.batch_spread(self.inputs(child, parent, parent_next))

    def sample(
        self, child: FloatArray, parent: FloatArray, parent_next: FloatArray, normal: FloatArray, scale: FloatArray
    ) -> FloatArray:
        """Next states with noise: `scale` (n_child,) is the noise of the coded change, `normal` is (n, n_child)."""
        code = self.frozen.batch(self.inputs(child, parent, parent_next)) + scale * normal
        return self.code.wrap(self.code.decode(child, code))

    def linearize(
        self, child: FloatArray, parent: FloatArray, parent_next: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Prediction with its derivatives.

        Args:
            child: shape (n, n_child).
            parent, parent_next: shape (n, n_parent).

        Returns:
            The next state (n, n_child), not wrapped, and its derivatives by child (n, n_child, n_child), parent
            and parent_next (n, n_child, n_parent).
        """
        after, note = self.predict_noted(child, parent, parent_next)
        by_child, by_parent, by_next = self.derivatives([note])
        return after, by_child[0], by_parent[0], by_next[0]

    def predict_noted(
        self, child: FloatArray, parent: FloatArray, parent_next: FloatArray
    ) -> tuple[FloatArray, Prediction]:
        """The next state, not wrapped, and a note for `derivatives`; arguments as for `linearize`."""
        code, note = self.frozen.batch_noted(self.inputs(child, parent, parent_next))
        return self.code.decode(child, code), Prediction(child, parent, parent_next, code, note)

    def derivatives(self, notes: Sequence[Prediction]) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Derivatives of k predictions at once, each to the same bits as alone.

        Args:
            notes: from `predict_noted`.

        Returns:
            By child (k, n, n_child, n_child), parent and parent_next (k, n, n_child, n_parent).
        """
        by_input = self.frozen.jacobians([note.frozen for note in notes])
        child, parent, parent_next, code = (np.array(of) for of in zip(*(note[:4] for note in notes), strict=True))
        by_state, by_code = self.code.jacobians(child, code)
        n_child, n_parent = len(self._child_features), len(self._parent_features)
        by_child = by_state + self._child_features.by_state(by_code @ by_input[..., :n_child], child)
        by_parent = by_next = np.zeros((*child.shape[:-1], child.shape[-1], parent.shape[-1]))
        start = n_child
        if self.action in ("current", "both"):
            block = by_input[..., start : start + n_parent]
            by_parent = self._parent_features.by_state(by_code @ block, parent)
            start += n_parent
        if self.action in ("next", "both"):
            block = by_input[..., start : start + n_parent]
            by_next = self._parent_features.by_state(by_code @ block, parent_next)
        return by_child, by_parent, by_next


@dataclass(frozen=True)
class InverseModel(_LinkModel):
    """Tr^-1: the parent state that makes a wanted change of the child (paper sec. III).

    Attributes:
        child_space, parent_space: observable state spaces.
        targets: indices of the child's variables that the wanted state names.
        features: what the regression sees of the child, and how the wanted change is coded.
        aim: how many ticks ahead the wanted state lies.
        frozen: the fitted regression, from features and wanted change to the parent's state.
        lower, upper: range of the parent's states in the demonstrations, shape (n_parent,); answers stay in it.
        origin: what the positions in the regression's answers are relative to; see `ForwardModel`.
    """

    child_space: StateSpace
    parent_space: StateSpace
    targets: tuple[int, ...]
    features: FeatureKind
    aim: int
    frozen: FrozenModel
    lower: FloatArray
    upper: FloatArray
    origin: Origin | None = None

    def inputs(self, child: FloatArray, wanted: FloatArray) -> FloatArray:
        """Regression inputs, shape (n, n_in).

        Args:
            child: child's state now, shape (n, n_child).
            wanted: wanted values of the target variables `aim` ticks ahead, shape (n, n_targets).
        """
        goal = child.copy()
        goal[..., list(self.targets)] = wanted
        change = self.code.encode(child, goal)[..., list(self.targets)]
        return np.concatenate([self._child_features(child), change], axis=-1)

    def __call__(self, child: FloatArray, wanted: FloatArray) -> FloatArray:
        """Parent states that bring about the wanted states, shape (n, n_parent)."""
        inputs = self.inputs(child, wanted)
        answer = self.frozen.value(inputs[0])[None] if len(inputs) == 1 else self.frozen.batch(inputs)
        if self._offset is not None:
            answer = answer + self._offset
        return np.clip(answer, self.lower, self.upper)
