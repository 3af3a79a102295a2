"""What a person can take in hand in the browser: a seat turns axes from -1 to 1 into hand commands."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from pydrake.systems.framework import Diagram

from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.state import FloatArray, StateSpace
from ichain_drake.timing import FRAME
from ichain_drake.visualization import Axis, Camera, PageButton
from ichain_drake.world.world import World

_SPEED = {"m": 0.15, "rad": 0.8}  # of a hand that is moved by axes


@dataclass(frozen=True)
class Seat(ABC):
    """Something that a person can drive.

    Attributes:
        name: of it; pieces are named after it.
        world: builds a world and puts it in its start state, by the number of the run, which keys its noise.
        drawings: how the world's objects look.
        plant: the arm to draw, or None.
        objects: whose measurements go into the pieces.
        axes: to steer.
        toggles: buttons that the command depends on.
        camera: view to start with; None for the usual one.
    """

    name: str
    world: Callable[[int], World]
    drawings: Callable[[], Mapping[str, Any]]
    plant: Callable[[], Diagram | None]
    objects: tuple[str, ...]
    axes: tuple[Axis, ...] = ()
    toggles: tuple[PageButton, ...] = ()
    camera: Camera | None = None

    @abstractmethod
    def command(self, axes: FloatArray, last: FloatArray, hand: FloatArray) -> FloatArray:
        """The hand command for the frame that begins.

        Args:
            axes: where they are, each in [-1, 1], shape (n_axes,).
            last: what this returned one frame before; at the start `hand`; shape (n_hand,).
            hand: the hand's true state (exposed variables), shape (n_hand,).
        """

    def toggle(self, name: str, command: FloatArray) -> FloatArray:
        """The command after a toggle was pressed; the same unless overridden."""
        return command


@dataclass(frozen=True)
class PlaceSeat(Seat):
    """Axes are places: let go, and the hand goes back to the middle.

    Attributes:
        place: the hand command for axes, shape (n_axes,) -> (n_hand,).
    """

    place: Callable[[FloatArray], FloatArray] = field(kw_only=True)

    def command(self, axes: FloatArray, last: FloatArray, hand: FloatArray) -> FloatArray:
        """Where the axes are."""
        return np.asarray(self.place(axes), dtype=float)


@dataclass(frozen=True)
class HandSeat(Seat):
    """Axes are speeds of the hand's variables, binary ones are toggled: let go, and the hand stays.

    Attributes:
        space: of the command: of the robot object, or of all robots.
        moved: index in it of the variable that each axis moves.
    """

    space: StateSpace = field(kw_only=True)
    moved: tuple[int, ...] = field(kw_only=True)

    def command(self, axes: FloatArray, last: FloatArray, hand: FloatArray) -> FloatArray:
        """A little further, within bounds, and never far ahead of a hand that can't follow."""
        command = last.copy()
        for value, index in zip(axes, self.moved, strict=True):
            speed = _SPEED[self.space.variables[index].unit]
            ahead = speed * 0.5
            gap = np.clip(command[index] + value * speed * FRAME - hand[index], -ahead, ahead)
            command[index] = hand[index] + gap if value else command[index]
        return self.space.clip(command)

    def toggle(self, name: str, command: FloatArray) -> FloatArray:
        """Flip a binary variable."""
        changed = command.copy()
        index = self.space.index(name)
        changed[index] = 1.0 - round(float(changed[index]))
        return changed


class Drivable(Protocol):
    """What a seat asks of a scenario, which every `Scenario` offers."""

    graph: InteractionGraph

    @property
    def name(self) -> str: ...  # noqa: D102
    def drawings(self) -> Mapping[str, Any]: ...  # noqa: D102
    def drawn_plant(self) -> Diagram | None: ...  # noqa: D102
    def seats(self) -> Mapping[str, Seat]: ...  # noqa: D102


# Keys for moves along x, y, z of the robot's frame (x away from the robot, y to its left), and for turns about them.
_MOVES: dict[str, tuple[tuple[str, str], tuple[str, str], int | None, float]] = {
    "x": (("ArrowDown", "ArrowUp"), ("back", "forward"), 1, -1.0),
    "y": (("ArrowRight", "ArrowLeft"), ("right", "left"), 0, -1.0),
    "z": (("KeyS", "KeyW"), ("down", "up"), 3, -1.0),
}
_TURNS: dict[str, tuple[tuple[str, str], tuple[str, str], int | None, float]] = {
    "x": (("KeyA", "KeyD"), ("one way", "the other"), 2, 1.0),
    "y": (("KeyQ", "KeyE"), ("down", "forward"), None, 1.0),
    "z": (("KeyZ", "KeyC"), ("one way", "the other"), None, 1.0),
}


def _axis(name: str, space: StateSpace, index: int) -> Axis:
    role = space.variables[index].role
    known = {} if role is None else {"position": _MOVES, "orientation": _TURNS}.get(role.kind, {})
    if role is None or role.axis not in known:
        return Axis(name, ("", ""), ("less", "more"))  # by its slider alone
    return Axis(name, *known[role.axis])


def hand_seat(scenario: Drivable, world: Callable[[int], World], robot: str = "") -> HandSeat:
    """The hand itself, variable by variable, in the scenario's physics; other hands stay where they are.

    Args:
        scenario: its robot is driven.
        world: see `Seat`.
        robot: which of several; default the first.
    """
    graph = scenario.graph
    root = robot or graph.root
    space = graph.objects[root].observable
    first = sum(len(graph.objects[r].observable) for r in graph.roots[: graph.roots.index(root)])
    moved = tuple(i for i, v in enumerate(space.variables) if v.kind != "binary" and v.unit in _SPEED)
    axes = tuple(_axis(f"{root} {space.names[i]}", space, i) for i in moved)
    keys = ["KeyG", "KeyH", "KeyJ"]
    binary = [graph.command.names[first + i] for i, v in enumerate(space.variables) if v.kind == "binary"]
    toggles = tuple(
        PageButton(name, keys[i] if i < len(keys) else "", f"{name}: on, off", 5 + i) for i, name in enumerate(binary)
    )
    places = tuple(first + i for i in moved)
    return HandSeat(
        root, world, scenario.drawings, scenario.drawn_plant, tuple(graph.objects), axes, toggles,
        space=graph.command, moved=places,
    )  # fmt: skip


def place_seat(
    scenario: Drivable,
    world: Callable[[int], World],
    lower: FloatArray,
    upper: FloatArray,
    command_at: Callable[[FloatArray], FloatArray] = np.asarray,
) -> PlaceSeat:
    """The hand within a range of commands, which lies on what it holds.

    Args:
        scenario: its robot is driven.
        world: see `Seat`.
        lower, upper: coordinates of hand commands at -1 and 1, shape (k,).
        command_at: the hand command (n_hand,) at coordinates (k,); without it they are the same.
    """
    root = scenario.graph.root
    space = scenario.graph.objects[root]
    lower, upper = np.asarray(lower, dtype=float), np.asarray(upper, dtype=float)
    if len(lower) == len(space):
        axes = tuple(_axis(f"{root} {name}", space, i) for i, name in enumerate(space.names))
    else:
        keys = [*_MOVES.values(), *_TURNS.values()]
        axes = tuple(Axis(f"{root} {i + 1}", *keys[i]) for i in range(len(lower)))
    middle, half = (lower + upper) / 2, (upper - lower) / 2
    objects = tuple(scenario.graph.objects)
    return PlaceSeat(
        root,
        world,
        scenario.drawings,
        scenario.drawn_plant,
        objects,
        axes,
        place=lambda values: command_at(middle + half * values),
    )


def choose_seat(scenario: Drivable, name: str = "") -> Seat:
    """The seat of a name, or a scenario's first.

    Raises:
        InputError: if there is none of that name.
    """
    seats = scenario.seats()
    if not seats or (name and name not in seats):
        what = repr(name) if name else "anything"
        raise InputError(f"{scenario.name}: nobody can drive {what}; there is {', '.join(seats) or 'nothing'}")
    return seats[name] if name else next(iter(seats.values()))
