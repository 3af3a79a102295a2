"""Inputs of an effect: what a child's change under one interaction may depend on, built from kinds and roles alone.

Parent's state at t + 1 and its change in the tick, child's state at t, and for transport of an amount between the two
what was received and how its intensive properties mix by volume. A parent's change (paper sec. VI: it makes the
interaction of cup and tank Markov) is taken as the difference of its amount, whose noise doesn't add up over ticks. A
child's own change is never an input: it predicts itself from tick to tick without the parent.

"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ichain_drake.graph import Interaction
from ichain_drake.learning.data import GraphData
from ichain_drake.learning.effects.alignment import Alignment
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import FloatArray, StateSpace, wrap_angle

Source = Literal["parent", "parent_change", "child", "aligned_change", "received", "mixing"]
View = Literal["plain", "cos", "sin"]


@dataclass(frozen=True, eq=False)
class Column:
    """One input, computed from states of shape (..., n).

    Attributes:
        source: `parent`: the parent's variable at t + 1; `parent_change`: its change from t; `child`: the child's
            variable at t; `aligned_change`: how far the child goes along an axis of its frame if it moves with the
            parent; `received`: what left the parent's amount in the tick; `mixing`: received / (amount + received) x
            (parent's intensive - child's).
        label: for reports.
        index: of the variable (of the parent's amount for received and mixing).
        view: angles are seen as cosine and sine, or as they are.
        wrap: whether the variable is an angle.
        alignment: for `aligned_change`; `index` is then the axis.
        mixes: for `received` and `mixing`: indices of the parent's intensive (of `mixing`), the child's amount, the
            child's intensive (of `mixing`).
        floor: noise of a difference of the amount.
        turns: for `parent_change` of an orientation: indices of the child's orientations.
    """

    source: Source
    label: str
    index: int = -1
    view: View = "plain"
    wrap: bool = False
    alignment: Alignment | None = None
    mixes: tuple[int, int, int] = (-1, -1, -1)
    floor: float = 0.0
    turns: tuple[int, ...] = ()

    def declares(self, variable: int) -> bool:
        """Whether, by its role, a variable of the child may change by just this: moved, turned, received, mixed."""
        if self.source == "aligned_change":
            assert self.alignment is not None
            return self.alignment.child.indices[self.index] == variable
        if self.source == "parent_change":
            return variable in self.turns
        return {"received": self.mixes[1], "mixing": self.mixes[2]}.get(self.source, -1) == variable

    def __call__(  # noqa: PLR0911 - one return a source
        self, parent: FloatArray, parent_next: FloatArray, child: FloatArray
    ) -> FloatArray:
        """Values, shape (...), from the parent's states at t and t + 1 and the child's at t."""
        if self.source == "parent":
            return self._seen(parent_next[..., self.index])
        if self.source == "child":
            return self._seen(child[..., self.index])
        if self.source == "parent_change":
            delta = parent_next[..., self.index] - parent[..., self.index]
            return (delta + np.pi) % (2 * np.pi) - np.pi if self.wrap else delta
        if self.source == "aligned_change":
            assert self.alignment is not None
            return (self.alignment.place(parent_next) - self.alignment.place(parent))[..., self.index]
        left = parent[..., self.index] - parent_next[..., self.index]
        received = np.where(left < -LEARNING.clear * self.floor, 0.0, left)
        if self.source == "received":
            return received
        theirs, amount, own = self.mixes
        total = np.maximum(child[..., amount], 0.0) + np.maximum(received, 0.0)
        # In an all but empty child the share is one noise divided by another; it fades in as there is something to mix.
        share = np.minimum(received * total / (total**2 + (LEARNING.faint * self.floor) ** 2 + 1e-24), 1.0)
        return share * (parent_next[..., theirs] - child[..., own])

    def variance(self, parent: FloatArray, parent_next: FloatArray, child: FloatArray) -> FloatArray:
        """Variance of values, shape (...), by what readings say was received: large where little is mixed with it."""
        if self.source != "mixing":
            return np.zeros(child.shape[:-1])
        theirs, amount, own = self.mixes
        total = np.maximum(child[..., amount], self.floor)
        return np.asarray((self.floor / total * (parent_next[..., theirs] - child[..., own])) ** 2)

    def _seen(self, value: FloatArray) -> FloatArray:
        if self.view == "plain":
            return value
        return np.cos(value) if self.view == "cos" else np.sin(value)


def candidate_columns(
    data: GraphData,
    edge: Interaction,
    alignment: Alignment | None,
    noise: Mapping[str, FloatArray],
) -> list[Column]:
    """All inputs that an effect of an interaction may use, in canonical order; those built from roles first."""
    parent, child = data.spaces[edge.parent], data.spaces[edge.child]
    order_p, order_c = data.variables[edge.parent], data.variables[edge.child]
    out = _transport(parent, child, order_p, order_c, noise[edge.child])
    if alignment is not None:
        out += [
            Column("aligned_change", f"motion with parent along child's {child.names[c]}", k, alignment=alignment)
            for k, c in enumerate(alignment.child.indices)
        ]
    # What the columns above already say about a change of the parent is not offered twice.
    told = {c.index for c in out if c.source == "received"}
    told |= set(alignment.parent.indices) if alignment is not None else set()
    for i in (i for i in order_p if not _is_change(parent, i)):
        name, wrap = parent.names[i], bool(parent.angle_mask[i])
        for view in _views(data, edge.parent, i):
            out.append(Column("parent", _label(f"parent {name}", view), i, view, wrap))
        if i not in told:
            turns = _orientations(child) if i in _orientations(parent) else ()
            out.append(Column("parent_change", f"change of parent {name}", i, wrap=wrap, turns=turns))
    for i in order_c:
        if not _is_change(child, i):
            for view in _views(data, edge.child, i):
                out.append(Column("child", _label(f"child {child.names[i]}", view), i, view))
    return out


def _views(data: GraphData, obj: str, index: int) -> tuple[View, ...]:
    """How a variable is seen: an angle that stays within a half-turn is a number like any other.

    Its cosine would tell as much of what was shown, and take what was never shown, the other way round, for the same.
    """
    if not data.spaces[obj].angle_mask[index]:
        return ("plain",)
    values = data.stacked(obj)[:, index]
    middle = np.arctan2(np.sin(values).mean(), np.cos(values).mean())
    return ("plain", "cos", "sin") if np.ptp(wrap_angle(values - middle)) > np.pi else ("plain",)


def _label(text: str, view: View) -> str:
    return text if view == "plain" else f"{view}({text})"


def _orientations(space: StateSpace) -> tuple[int, ...]:
    return tuple(i for i, v in enumerate(space.variables) if v.role is not None and v.role.kind == "orientation")


def _is_change(space: StateSpace, index: int) -> bool:
    role = space.variables[index].role
    return role is not None and role.kind == "change"


def _transport(
    parent: StateSpace, child: StateSpace, order_p: tuple[int, ...], order_c: tuple[int, ...], noise: FloatArray
) -> list[Column]:
    """Columns for an amount that goes from parent to child: received, and mixing of every pair of intensives."""
    out = []
    amounts = [i for i in order_c if i in child.role_indices("amount")]
    for i in (i for i in order_p if i in parent.role_indices("amount")):
        given = parent.names[i]
        for a in amounts:
            floor = float(noise[a] * np.sqrt(2.0))
            out.append(Column("received", f"received from parent {given}", i, mixes=(-1, a, -1), floor=floor))
            for p in (k for k in order_p if _intensive_of(parent, k) == given):
                for c in (k for k in order_c if _intensive_of(child, k) == child.names[a]):
                    if parent.variables[p].unit == child.variables[c].unit:
                        label = f"mixing of parent {parent.names[p]} with child {child.names[c]}"
                        out.append(Column("mixing", label, i, mixes=(p, a, c), floor=floor))
    return out


def _intensive_of(space: StateSpace, index: int) -> str | None:
    role = space.variables[index].role
    return role.of if role is not None and role.kind == "intensive" else None
