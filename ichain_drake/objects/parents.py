"""What objects ask of their parents when they are made: one hand, a position, a level."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from ichain_drake.errors import InputError
from ichain_drake.state import StateSpace


def only_hand(parents: Mapping[str, StateSpace], where: str, what: str) -> tuple[str, StateSpace]:
    """The one parent of an object that nothing but a hand moves: its name and state space.

    Args:
        parents: state spaces by name.
        where: the object that asks, for errors.
        what: the object's kind with its article, for errors.

    Raises:
        InputError: if there is not exactly one parent.
    """
    if len(parents) != 1:
        raise InputError(f"{where}: {what} has one parent, the hand; {len(parents)} given")
    ((hand, space),) = parents.items()
    return hand, space


def hand_among(parents: Collection[str], others: Collection[str], where: str, what: str) -> str:
    """Name of the one parent that is none of the others, a hand.

    Args:
        parents: names of all parents.
        others: names of those that are known to be something else.
        where, what: as for `only_hand`.

    Raises:
        InputError: if there is not exactly one such parent.
    """
    hands = [p for p in parents if p not in others]
    if len(hands) != 1:
        raise InputError(f"{where}: {what} has one hand among its parents; {len(hands)} given")
    return hands[0]


def position_indices(space: StateSpace, axes: Collection[str], where: str, parent: str = "") -> list[int]:
    """Where a parent's position along each axis is in its state vector, by its roles.

    Args:
        space: state space of the parent.
        axes: such as `x`.
        where: the object that asks, for errors.
        parent: the parent's name, for errors; its type if empty.

    Raises:
        InputError: if one is missing; names the axis.
    """
    found = {v.role.axis: i for i, v in enumerate(space.variables) if v.role and v.role.kind == "position"}
    for axis in axes:
        if axis not in found:
            raise InputError(f"{where}: its parent {parent or space.type} has no position along {axis}")
    return [found[a] for a in axes]


def level_index(parents: Mapping[str, StateSpace], parent: str, where: str, what: str) -> int:
    """Where the level of a parent, such as a button, is in its state vector.

    Args:
        parents: state spaces by name.
        parent: name of the one that is to have a level.
        where: the object that asks, for errors.
        what: what the parent is to be, with its article, for errors.

    Raises:
        InputError: if it is no parent, or has no level.
    """
    if parent not in parents or not len(parents[parent].role_indices("level")):
        raise InputError(f"{where}: {parent!r} is to be {what}, but is no parent with a level")
    return int(parents[parent].role_indices("level")[0])
