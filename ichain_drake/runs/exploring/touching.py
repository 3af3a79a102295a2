"""A hand that tries out objects by itself: it goes to one, closes, moves, and sees whether that goes along."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import Context, State
from scipy.stats import qmc

from ichain_drake.control.ticks import TickSystem
from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.learning.discovery.experiments import Experiment
from ichain_drake.robot.hand import FRAME, HAND
from ichain_drake.runs.exploring.settings import ExploringSettings
from ichain_drake.scenarios.hand_commands import HandCommands
from ichain_drake.state import FloatArray, StateSpace

_GRIP = "grip"
Box = Mapping[str, tuple[float, float]]
"""Lowest and highest place along each axis [m]."""


class Reach:
    """What a hand can get at, from what is declared alone: state spaces and their bounds.

    Args:
        graph: declares the objects; its interactions are not looked at.

    Raises:
        InputError: if the graph has several robots, or its robot is no hand.
    """

    def __init__(self, graph: InteractionGraph) -> None:
        self.root = graph.only_root("exploring")
        self.spaces: dict[str, StateSpace] = {n: s.observable for n, s in graph.objects.items()}
        self.hand = self.spaces[self.root]
        strange = [n for n in self.hand.names if n not in HAND.names]
        if strange or graph.command.names != self.hand.names:
            raise InputError(f"explore: {self.root} is no hand, whose variables are among {', '.join(HAND.names)}")
        self.axes = _axes(self.hand)
        self.turns = [v.name for v in self.hand.variables if v.role and v.role.kind == "orientation"]
        self.grips = _GRIP in self.hand.names
        names = [n for n in self.spaces if n != self.root]
        self.touchable = tuple(n for n in names if self.grips and _axes(self.spaces[n]).keys() & self.axes.keys())

    def place(self, name: str, state: FloatArray) -> dict[str, float]:
        """Where an object is along the hand's axes [m]; what its state doesn't say is left out."""
        return {a: float(state[i]) for a, i in _axes(self.spaces[name]).items() if a in self.axes}

    def declared(self, name: str, axis: str) -> tuple[float, float]:
        """Between what an object is declared to stay along an axis [m]; infinite where nothing is."""
        index = _axes(self.spaces[name]).get(axis)
        if index is None:
            return -np.inf, np.inf
        return float(self.spaces[name].lower[index]), float(self.spaces[name].upper[index])

    def box(self, seen: Mapping[str, FloatArray], margin: float) -> Box:
        """Between what the hand stays along each of its axes [m]: where it is, where objects are or may be, a margin.

        Args:
            seen: state per object, shape (n_variables,) each.
            margin: [m].
        """
        out = {}
        for axis, k in self.axes.items():
            values = [float(seen[self.root][k])]
            for name in self.touchable:
                place = self.place(name, seen[name])
                if axis in place:
                    values += [place[axis], *(b for b in self.declared(name, axis) if np.isfinite(b))]
            low, high = min(values) - margin, max(values) + margin
            out[axis] = (max(low, float(self.hand.lower[k])), min(high, float(self.hand.upper[k])))
        return out


def _axes(space: StateSpace) -> dict[str, int]:
    places = [(i, v.role) for i, v in enumerate(space.variables)]
    return {r.axis: i for i, r in places if r and r.kind == "position" and r.frame == FRAME}


@dataclass(frozen=True)
class _Memory:
    """What a toucher remembers, never changed.

    Attributes:
        rows: commands to be sent.
        first: what was measured at the start of the piece.
        touches: that are over.
        touched: the object that the hand has closed at and not let go; empty for none.
        at: where that was [m], by axis.
        hand: where the hand was, by the same axes.
    """

    rows: tuple[FloatArray, ...] = ()
    first: Mapping[str, FloatArray] = field(default_factory=dict)
    touches: int = 0
    touched: str = ""
    at: Mapping[str, float] = field(default_factory=dict)
    hand: Mapping[str, float] = field(default_factory=dict)

    def __deepcopy__(self, memo: dict[int, object]) -> _Memory:
        return self  # Drake copies abstract state 30 times a second


class Toucher(TickSystem):
    """Carries out an experiment over and over. Its memory is in the context.

    Ports: per object an input of its name, for `measured`; output `hand_command`.

    Args:
        reach: what the hand can get at.
        experiment: what is touched.
        initial_command: before the first decision, shape (n_hand,).
        seed: of what is tried.
        settings: see `ExploringSettings`.
    """

    def __init__(
        self,
        reach: Reach,
        experiment: Experiment,
        initial_command: FloatArray,
        seed: Sequence[int],
        settings: ExploringSettings,
    ) -> None:
        super().__init__("toucher")
        self._reach, self._experiment, self._settings = reach, experiment, settings
        # One row a touch: offset and turn when it closes, then place, turn and wait of each way.
        self._columns = len(reach.axes) + len(reach.turns) + 1
        self._draws = qmc.Halton((settings.drags + 2) * self._columns, rng=np.random.default_rng(seed)).random(
            settings.piece
        )
        self._upright = dict(zip(reach.hand.names, np.asarray(initial_command, dtype=float).tolist(), strict=True))
        self._measured = {n: self.DeclareVectorInputPort(n, len(s)) for n, s in reach.spaces.items()}
        self._command = self.DeclareDiscreteState(np.asarray(initial_command, dtype=float))
        self.DeclareStateOutputPort("hand_command", self._command)
        self._memory = self.DeclareAbstractState(Value(_Memory()))

    def decide(self, context: Context, state: State, tick: int) -> None:
        """Send the next command; lay out what comes after the last."""
        slot = state.get_mutable_abstract_state(int(self._memory))
        memory: _Memory = slot.get_value()
        if not memory.rows:
            seen = {n: np.array(port.Eval(context)) for n, port in self._measured.items()}
            memory = self._laid_out(memory, seen, context.get_discrete_state(self._command).value().copy())
        state.get_mutable_discrete_state().set_value(self._command, memory.rows[0])
        slot.set_value(replace(memory, rows=memory.rows[1:]))

    def _laid_out(self, memory: _Memory, seen: Mapping[str, FloatArray], now: FloatArray) -> _Memory:
        reach, hand = self._reach, HandCommands(self._reach.hand.names, now)
        first = memory.first or seen
        box = reach.box(first, self._settings.margin)
        draw = self._draws[memory.touches % len(self._draws)].reshape(-1, self._columns)
        over = _Memory((), first, memory.touches + 1)
        if not memory.first:  # at first it only looks: what goes on by itself is no effect
            return _Memory((now,) * self._settings.rest, seen)
        if not self._experiment.touched:
            for row in draw[1:]:
                self._way(hand, box, row)
        elif memory.touched:
            several = self._experiment.touched
            if len(several) == 1 and self._goes_along(memory, seen, now):
                for row in draw[2:-1]:
                    self._way(hand, self._range(memory.touched, seen, box), row, turning=True)
                if memory.touches % self._settings.left != self._settings.left // 2:
                    self._bring(hand, memory, reach.place(memory.touched, first[memory.touched]))
            self._way(hand.grip(False), box, draw[-1])
        else:
            several = self._experiment.touched
            name, turn = several[memory.touches % len(several)], memory.touches // len(several)
            self._close(hand, name, seen, box, draw[0], near=len(several) > 1 or turn % 2 == 0)
            at = reach.place(name, seen[name])
            closed = {axis: float(hand.now[reach.axes[axis]]) for axis in at}
            over, ends = _Memory((), first, memory.touches, name, at, closed), self._range(name, seen, box)
            if len(several) == 1:
                self._way(hand, ends, draw[1])
            else:  # far from where it was, and back in the next turn: in both cases the others are touched
                was = reach.place(name, first[name])
                far = {a: low if x - low > high - x else high for a, x in was.items() for low, high in [ends[a]]}
                self._bring(hand, over, was if turn % 2 else far)
        return replace(over, rows=tuple(hand.commands))

    def _bring(self, hand: HandCommands, memory: _Memory, place: Mapping[str, float]) -> None:
        """Bring what goes along to a place [m], by axis; the hand stays where it is relative to it."""
        hand.to(**{axis: x + memory.hand[axis] - memory.at[axis] for axis, x in place.items()}, **self._level())

    def _close(
        self,
        hand: HandCommands,
        name: str,
        seen: Mapping[str, FloatArray],
        box: Box,
        draw: FloatArray,
        *,
        near: bool,
    ) -> None:
        """Go to an object, or a little beside it, and close."""
        place, goal = self._reach.place(name, seen[name]), {}
        for k, (axis, (low, high)) in enumerate(box.items()):
            off = self._settings.beside * (self._settings.near if near else 1.0) * (2.0 * draw[k] - 1.0)
            goal[axis] = float(np.clip(place[axis] + off, low, high)) if axis in place else low + (high - low) * draw[k]
        rest = (
            self._settings.rest if len(self._experiment.touched) > 1 else 1 + int(draw[-1] * self._settings.rest) // 2
        )
        hand.to(**goal, **self._level()).grip(True).wait(rest)

    def _goes_along(self, memory: _Memory, seen: Mapping[str, FloatArray], now: FloatArray) -> bool:
        place = self._reach.place(memory.touched, seen[memory.touched])
        moved = np.linalg.norm([place[axis] - was for axis, was in memory.at.items()])
        went = np.linalg.norm([now[self._reach.axes[axis]] - was for axis, was in memory.hand.items()])
        return bool(moved > self._settings.along * went)

    def _range(self, name: str, seen: Mapping[str, FloatArray], box: Box) -> dict[str, tuple[float, float]]:
        """Where an object is moved: as far as it is declared to go, else a little to either side."""
        out, place = {}, self._reach.place(name, seen[name])
        for axis, (least, most) in box.items():
            low, high = self._reach.declared(name, axis)
            middle = place.get(axis, least)
            low = low if np.isfinite(low) else middle - 2.0 * self._settings.beside
            high = high if np.isfinite(high) else middle + 2.0 * self._settings.beside
            out[axis] = (max(low, least), min(high, most))
        return out

    def _way(self, hand: HandCommands, box: Box, draw: FloatArray, *, turning: bool = False) -> None:
        """To a place, turned or upright, and wait there."""
        goal = {axis: low + (high - low) * draw[k] for k, (axis, (low, high)) in enumerate(box.items())}
        turns = self._level()
        if turning:
            for k, name in enumerate(turns, start=len(box)):
                turns[name] += self._settings.turn * (2.0 * draw[k] - 1.0)
        hand.to(**goal, **turns).wait(int(draw[-1] * (self._settings.rest + 1)))

    def _level(self) -> dict[str, float]:
        """How the hand was turned at the start."""
        return {name: self._upright[name] for name in self._reach.turns}
