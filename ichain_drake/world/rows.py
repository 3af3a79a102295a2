"""Many worlds of one system in `ideal` physics, a row each, in plain numpy: what their Diagrams do, to the last bit."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from pydrake.systems.framework import Context, System

from ichain_drake.noise import NoiseRows
from ichain_drake.objects.rows import NotTogetherError, ObjectRows, unlike
from ichain_drake.robot.ideal import IdealHand
from ichain_drake.state import BoolArray, FloatArray
from ichain_drake.timing import FRAMES_PER_TICK
from ichain_drake.world.world import World


class WorldRows:
    """Worlds that differ in their seeds and where they start.

    Args:
        worlds: none of them part of another diagram; their default contexts are where they start.

    Attributes:
        states: of robots and of every object, shape (n, n_variables) each, by name.
        active: 0 or 1 for each incoming interaction of every object, shape (n, n_parents) each, by name.

    Raises:
        NotTogetherError: if they are not alike, or no ideal ones.
    """

    def __init__(self, worlds: Sequence[World]) -> None:
        first = worlds[0]
        self.graph, self._frame = first.graph, 0
        if any(type(w) is not World or w.graph.roots != self.graph.roots for w in worlds):
            raise NotTogetherError("worlds with the same robots are calculated together")
        self._hands = {name: _HandRows([w.robots[name] for w in worlds]) for name in self.graph.roots}
        if any(
            (w.graph.objects, w.graph.interactions) != (self.graph.objects, self.graph.interactions) for w in worlds
        ):
            raise NotTogetherError("worlds of one graph are calculated together")
        self._objects = {name: ObjectRows([w.objects[name] for w in worlds]) for name in first.objects}
        contexts = [w.CreateDefaultContext() for w in worlds]
        for hand in self._hands.values():
            hand.begin(contexts)
        self.states = {
            n: np.array([w.GetOutputPort(f"{n}.state").Eval(c) for w, c in zip(worlds, contexts, strict=True)])
            for n in self.graph.objects
        }
        self.active = {n: np.zeros((len(worlds), len(o.parents))) for n, o in first.objects.items()}
        self._decide(step=False)

    def __len__(self) -> int:
        return len(self.states[self.graph.root])

    def _decide(self, *, step: bool) -> None:
        """What is active, from states at t; then what mirrors its parents, and what is where these have it.

        Args:
            step: whether the former do so now.
        """
        before, self.active = (
            self.active,
            {n: rows.decide(self.states[n], self.states, self.active[n]) for n, rows in self._objects.items()},
        )
        # Another branch is another piece of numpy, of which each is compared where it begins.
        begins = self._frame < FRAMES_PER_TICK
        self._checked = {n: begins | np.any(active != before[n], axis=1) for n, active in self.active.items()}
        states = dict(self.states)
        for n, rows in self._objects.items():
            active, checked = self.active[n], self._checked[n]
            if rows.immediate and step:
                states[n] = rows.step(states[n], self.states, active, self._frame, checked)
            if rows.settles:
                states[n] = rows.settle(states[n], self.states, active, checked)
        self.states = states

    def measured(self, name: str) -> FloatArray:
        """What the sensors of the robot or of an object read now, shape (n, n_observable)."""
        if name in self._hands:
            return self._hands[name].measure(self.states[name], self._frame)
        return self._objects[name].measure(self.states[name], self._frame)

    def frames(self, command: FloatArray) -> Iterator[dict[str, FloatArray]]:
        """Advance by one tick, frame by frame.

        Args:
            command: hand commands, shape (n, n_hand).

        Yields:
            The states at the end of each frame.

        Raises:
            NotTogetherError: if a row can't be calculated as it is alone.
            InputError: on a command that is not finite.
        """
        widths = np.cumsum([len(self.graph.objects[name]) for name in self._hands])
        parts = np.split(command, widths[:-1], axis=1)
        ways = [hand.lay(part) for hand, part in zip(self._hands.values(), parts, strict=True)]
        for places in zip(*ways, strict=True):
            yield self._advance(dict(zip(self._hands, places, strict=True)))

    def _advance(self, set_points: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
        """One frame: what holds at t itself; then everything else."""
        self._decide(step=True)
        self.states = self.states | {
            name: rows.step(self.states[name], self.states, self.active[name], self._frame, self._checked[name])
            for name, rows in self._objects.items()
            if not rows.immediate
        }
        for name, hand in self._hands.items():
            self.states[name] = hand.move(set_points[name])
        self._frame += 1
        return self.states

    def keep(self, rows: BoolArray) -> None:
        """Go on with some of the worlds; shape (n,)."""
        self.states = {n: s[rows] for n, s in self.states.items()}
        self.active = {n: a[rows] for n, a in self.active.items()}
        for hand in self._hands.values():
            hand.keep(rows)
        for each in self._objects.values():
            each.keep(rows)


class _HandRows:
    """The same hand of several worlds.

    Args:
        hands: one a world.

    Raises:
        NotTogetherError: if they differ, or have an arm.
    """

    def __init__(self, hands: Sequence[System]) -> None:
        self._each = [h for h in hands if type(h) is IdealHand]
        if len(self._each) < len(hands) or any(
            unlike(vars(self._each[0].motion), vars(h.motion)) for h in self._each[1:]
        ):
            raise NotTogetherError("worlds with the same hand and no arm are calculated together")
        self._motion, self._sensor = self._each[0].motion, self._each[0].measurement
        self._noise = NoiseRows([h.measurement.noise for h in self._each])
        self._set_points = np.zeros((len(hands), 0))

    def begin(self, contexts: Sequence[Context]) -> None:
        """Be where the worlds' contexts have it."""
        each = zip(self._each, contexts, strict=True)
        self._set_points = np.array([h.GetOutputPort("setpoint").Eval(h.GetMyContextFromRoot(c)) for h, c in each])

    def measure(self, state: FloatArray, frame: int) -> FloatArray:
        """What the sensors read, shape (n, n_observable)."""
        return self._sensor.read(state, self._noise.at(frame))

    def lay(self, command: FloatArray) -> FloatArray:
        """Set-points of a tick's frames, shape (10, n, 7); commands have shape (n, n_exposed)."""
        return self._motion.lay(self._set_points, command)

    def move(self, set_points: FloatArray) -> FloatArray:
        """States at set-points, shape (n, 7) -> (n, n_exposed)."""
        self._set_points = set_points
        return self._motion.spec.reduce(set_points)

    def keep(self, rows: BoolArray) -> None:
        """Go on with some of the worlds; shape (n,)."""
        self._each = [h for h, kept in zip(self._each, rows, strict=True) if kept]
        self._set_points = self._set_points[rows]
        self._noise.keep(rows)
