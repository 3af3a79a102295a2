"""What a gate may look at: values of parent, child and other objects, and places relative to each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ichain_drake.learning.discovery.log import Log
from ichain_drake.learning.discovery.settings import DISCOVERY
from ichain_drake.learning.effects.alignment import Alignment, PositionGroup, position_groups
from ichain_drake.state import BoolArray, FloatArray, IntArray, StateSpace


@dataclass(frozen=True)
class GateInput:
    """One input of a gate.

    Attributes:
        owner: the object that it belongs to; the parent for a relative place.
        label: for reports.
        place: whether it is a coordinate.
        relative: whether it is one of the child relative to the parent.
        variables: indices of the owner's variables that it is computed from; empty for a relative place.
        binary: whether it is a binary variable.
        price: of a face on it [nat].
    """

    owner: str
    label: str
    place: bool
    relative: bool
    variables: tuple[int, ...]
    binary: bool
    price: float


@dataclass(frozen=True, eq=False)
class GateInputs:
    """Inputs and their values, shape (n, n_inputs)."""

    items: tuple[GateInput, ...]
    values: FloatArray

    def at(self, items: Sequence[GateInput]) -> FloatArray:
        """Values of some of them, shape (n, len(items)); an input is known by its label."""
        labels = [i.label for i in self.items]
        return self.values[:, [labels.index(i.label) for i in items]]


def is_change(space: StateSpace, index: int) -> bool:
    """Whether a variable is the change of an amount, which follows and is neither cause nor effect."""
    role = space.variables[index].role
    return role is not None and role.kind == "change"


def gate_inputs(
    log: Log,
    parent: str,
    child: str,
    alignment: Alignment | None,
    others: Sequence[str] = (),
    rows: tuple[IntArray, IntArray] | None = None,
) -> GateInputs:
    """Inputs of the gate of an interaction.

    Args:
        log: the ticks.
        parent: whose state at the end of a tick matters; the child itself for what it does alone.
        child: whose state matters one reading before the tick starts: a reading that starts the change is no input.
        alignment: of the two, where known.
        others: further objects that the gate may look at.
        rows: rows of the parent's and of the child's states, in place of those of the ticks.
    """
    later, earlier = (log.t + 1, log.back) if rows is None else rows
    items: list[GateInput] = []
    columns: list[FloatArray] = []
    if parent != child:
        _add_object(log, parent, later, items, columns)
        for label, values in _relative(log, parent, child, alignment, earlier):
            price = DISCOVERY.face
            items.append(GateInput(parent, label, True, True, (), False, price))
            columns.append(values)
    _add_object(log, child, earlier, items, columns)
    for other in others:
        if other not in (parent, child):
            _add_object(log, other, later, items, columns)
    return GateInputs(tuple(items), np.array(columns).reshape(len(items), len(later)).T)


def caused(inputs: GateInputs, space: StateSpace, child: str, parent: str, changed: Sequence[int]) -> BoolArray:
    """Which inputs a gate must not use: what its own effect changes, and a place where a relative one says it better.

    Args:
        inputs: of the gate.
        space: of the child.
        child: its name.
        parent: name of the parent.
        changed: indices of the child's variables that the effect changes.

    Returns:
        shape (n_inputs,).
    """
    if parent == child:
        return np.zeros(len(inputs.items), dtype=bool)
    moved = set(changed)
    for group in position_groups(space):
        if moved & set(group.indices):
            moved |= set(group.indices)
    for i, variable in enumerate(space.variables):  # what is dissolved goes with the amount
        role = variable.role
        if role is not None and role.kind == "intensive" and (space.index(role.of) in moved or i in moved):
            moved |= {space.index(role.of), i}
    related = any(i.relative for i in inputs.items)
    return np.array(
        [
            not i.relative
            and (
                (related and i.place and i.owner in (parent, child))
                or (i.owner == child and bool(moved & set(i.variables)))
            )
            for i in inputs.items
        ]
    )


def _place(log: Log, obj: str, rows: IntArray) -> list[tuple[PositionGroup, FloatArray]]:
    """Positions of an object along the root's axes, or its own where its frame's turn is not known."""
    out = []
    for group in position_groups(log.spaces[obj]):
        turn = log.turns.get(group.frame)
        if turn is None or len(turn) != len(group.indices):
            turn = np.eye(len(group.indices))
        out.append((group, log.states[obj][rows][:, list(group.indices)] @ turn))
    return out


def _relative(
    log: Log, parent: str, child: str, alignment: Alignment | None, rows: IntArray
) -> list[tuple[str, FloatArray]]:
    if alignment is not None:
        place = alignment.relative(log.states[parent][rows], log.states[child][rows])
        return [(f"{child} relative to {parent}, {k}", place[:, k]) for k in range(place.shape[1])]
    out = []
    for theirs, p in _place(log, parent, rows):
        for own, q in _place(log, child, rows):
            joined = theirs.frame == own.frame or (theirs.frame in log.turns and own.frame in log.turns)
            if theirs.axes == own.axes and joined:
                out += [(f"{child} relative to {parent}, {a}", (q - p)[:, k]) for k, a in enumerate(own.axes)]
    return out


def _add_object(log: Log, obj: str, rows: IntArray, items: list[GateInput], columns: list[FloatArray]) -> None:
    space = log.spaces[obj]
    placed: set[int] = set()
    for group, place in _place(log, obj, rows):
        placed |= set(group.indices)
        for k, axis in enumerate(group.axes):
            items.append(
                GateInput(obj, f"{obj} at {group.frame} {axis}", True, False, group.indices, False, DISCOVERY.face)
            )
            columns.append(place[:, k])
    for i in log.data.variables[obj]:
        if i in placed or is_change(space, i):
            continue
        variable = space.variables[i]
        unlikely = variable.role is not None and variable.role.kind in ("amount", "intensive", "orientation")
        price = DISCOVERY.unlikely_face if unlikely else DISCOVERY.face
        items.append(GateInput(obj, f"{obj}.{variable.name}", False, False, (i,), variable.kind == "binary", price))
        columns.append(log.states[obj][rows][:, i])
