"""What a status classifier may look at, built from kinds and roles: values, places, places relative to each other."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ichain_drake.graph import Interaction
from ichain_drake.learning.data import GraphData
from ichain_drake.learning.effects.alignment import (
    Alignment,
    PositionGroup,
    apart,
    frame_turns,
    heading_of,
    position_groups,
)
from ichain_drake.state import FloatArray, StateSpace, wrap_angle

States = Mapping[str, FloatArray]


@dataclass(frozen=True, eq=False)
class ValueInput:
    """One variable; an angle is seen as its deviation from `middle`."""

    obj: str
    index: int
    label: str
    angle: bool = False
    middle: float = 0.0

    def __call__(self, states: States) -> FloatArray:
        """Values, shape (n, 1), from states of shape (n, n_variables)."""
        value = states[self.obj][:, [self.index]]
        return wrap_angle(value - self.middle) if self.angle else value


@dataclass(frozen=True, eq=False)
class PlaceInput:
    """A position, along the root's axes where the turn of the frames is known: a camera's turn then is no matter."""

    obj: str
    group: PositionGroup
    turn: FloatArray
    label: str

    def __call__(self, states: States) -> FloatArray:
        """Coordinates, shape (n, n_axes)."""
        return states[self.obj][:, list(self.group.indices)] @ self.turn


@dataclass(frozen=True, eq=False)
class RelativeInput:
    """Where the child is relative to where it would be if it moved with the parent."""

    edge: Interaction
    alignment: Alignment
    label: str

    def __call__(self, states: States) -> FloatArray:
        """Coordinates along the parent's axes, shape (n, n_parent_axes)."""
        return self.alignment.relative(states[self.edge.parent], states[self.edge.child])


@dataclass(frozen=True, eq=False)
class BodyInput(RelativeInput):
    """The same along the axes of the end that can be turned about the vertical.

    Attributes:
        heading: index of that orientation.
        of_child: whether it is the child's; else the parent's.
    """

    heading: int = 0
    of_child: bool = False

    def __call__(self, states: States) -> FloatArray:
        """Coordinates along the axes of the turned one, shape (n, n_axes)."""
        out = super().__call__(states)
        if self.of_child:
            out = out @ self.alignment.turn.T
        angle = states[self.edge.child if self.of_child else self.edge.parent][:, self.heading]
        x, y = (self.alignment.parent.axes.index(axis) for axis in "xy")
        c, s = np.cos(angle), np.sin(angle)
        out[:, x], out[:, y] = c * out[:, x] + s * out[:, y], c * out[:, y] - s * out[:, x]
        return out


@dataclass(frozen=True, eq=False)
class DifferenceInput:
    """Difference of two like quantities: same role and unit, one of the parent and one of the child."""

    parent: str
    child: str
    index: tuple[int, int]
    angle: bool
    label: str

    def __call__(self, states: States) -> FloatArray:
        """Values, shape (n, 1)."""
        delta = states[self.child][:, [self.index[1]]] - states[self.parent][:, [self.index[0]]]
        return wrap_angle(delta) if self.angle else delta


StatusInput = ValueInput | PlaceInput | RelativeInput | BodyInput | DifferenceInput


def objects_of(item: StatusInput) -> tuple[str, ...]:
    """Objects that an input looks at."""
    if isinstance(item, RelativeInput):
        return item.edge.parent, item.edge.child
    return (item.parent, item.child) if isinstance(item, DifferenceInput) else (item.obj,)


def candidate_inputs(
    data: GraphData, edge: Interaction, alignments: Mapping[Interaction, Alignment | None]
) -> tuple[list[StatusInput], list[StatusInput]]:
    """Inputs from the two ends of an interaction, and those from the child's other parents; canonical order.

    A change is no input: it follows from the status, so that it would only tell it a tick late.
    """
    turns = frame_turns(data.spaces, data.graph.root, {e: alignments[e] for e in data.edges})
    parent, child = data.spaces[edge.parent], data.spaces[edge.child]
    ends: list[StatusInput] = []
    alignment = alignments[edge] or apart(parent, child, turns)
    if alignment is not None:
        ends.append(_relative(edge, alignment, parent, child))
    for obj in (edge.parent, edge.child):
        ends += _of_object(data, obj, turns)
    ends += _differences(data, edge)
    others: list[StatusInput] = []
    for e in data.incoming(edge.child):
        if e != edge:  # where the robot is matters to what it acts on alone: else it tells again where that is
            theirs = _of_object(data, e.parent, turns)
            others += [i for i in theirs if not data.graph.by_robot(e) or not isinstance(i, PlaceInput)]
    return ends, others


def _relative(edge: Interaction, alignment: Alignment, parent: StateSpace, child: StateSpace) -> RelativeInput:
    label = f"position of {edge.child} relative to {edge.parent}"
    # What goes along with the parent is held however it is turned.
    if not alignment.rows and {"x", "y"} <= set(alignment.child.axes) and alignment.parent.axes == alignment.child.axes:
        for space, group, of_child in ((child, alignment.child, True), (parent, alignment.parent, False)):
            heading = heading_of(space, group.frame)
            if heading is not None:
                # From where the parent is, not from where the child usually was beside it: that turns with them.
                return BodyInput(edge, replace(alignment, shift=0.0 * alignment.shift), label, heading, of_child)
    return RelativeInput(edge, alignment, label)


def _of_object(data: GraphData, obj: str, turns: Mapping[str, FloatArray]) -> list[StatusInput]:
    space = data.spaces[obj]
    out: list[StatusInput] = []
    placed: set[int] = set()
    for group in position_groups(space):
        placed |= set(group.indices)
        turn = turns.get(group.frame)
        if turn is None or len(turn) != len(group.indices):
            turn = np.eye(len(group.indices))
        out.append(PlaceInput(obj, group, turn, f"position of {obj}"))
    for i in data.variables[obj]:
        role = space.variables[i].role
        if i in placed or (role is not None and role.kind == "change"):
            continue
        angle = bool(space.angle_mask[i])
        middle = 0.0
        if angle:
            values = data.stacked(obj)[:, i]
            middle = float(np.arctan2(np.sin(values).mean(), np.cos(values).mean()))
        out.append(ValueInput(obj, i, f"{obj}.{space.names[i]}", angle, middle))
    return out


def _differences(data: GraphData, edge: Interaction) -> list[StatusInput]:
    parent, child = data.spaces[edge.parent], data.spaces[edge.child]
    out: list[StatusInput] = []
    for i in data.variables[edge.parent]:
        for j in data.variables[edge.child]:
            a, b = parent.variables[i], child.variables[j]
            if a.role is None or b.role is None or a.role.kind in ("position", "change"):
                continue
            if (a.role.kind, a.role.axis, a.unit, a.kind) == (b.role.kind, b.role.axis, b.unit, b.kind):
                label = f"{edge.child}.{b.name} - {edge.parent}.{a.name}"
                out.append(DifferenceInput(edge.parent, edge.child, (i, j), a.kind == "angle", label))
    return out
