"""Many worlds of one system in `ideal` physics, a row each, in plain numpy: what their Diagrams do, to the last bit."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ichain_drake.noise import NoiseRows
from ichain_drake.objects.rows import NotTogetherError, ObjectRows, unlike
from ichain_drake.robot.ideal import IdealHand
from ichain_drake.state import BoolArray, FloatArray
from ichain_drake.world.world import World


class WorldRows:
    """Worlds that differ in their seeds and where they start.

    Args:
        worlds: none of them part of another diagram; their default contexts are where they start.

    Attributes:
        states: of the robot and of every object, shape (n, n_variables) each, by name.

    Raises:
        NotTogetherError: if they are not alike, or no ideal ones.
    """

    def __init__(self, worlds: Sequence[World]) -> None:
        first = worlds[0]
        if any(len(w.graph.roots) > 1 for w in worlds):
            raise NotTogetherError("worlds with one hand are calculated together")
        self.graph, self._frame = first.graph, 0
        hands = [w.robot for w in worlds if type(w) is World and type(w.robot) is IdealHand]
        if len(hands) < len(worlds) or any(unlike(vars(hands[0].motion), vars(h.motion)) for h in hands):
            raise NotTogetherError("worlds with the same hand and no arm are calculated together")
        if any(
            (w.graph.objects, w.graph.interactions) != (self.graph.objects, self.graph.interactions) for w in worlds
        ):
            raise NotTogetherError("worlds of one graph are calculated together")
        self._motion, self._sensor = hands[0].motion, hands[0].measurement
        self._hand_noise = NoiseRows([h.measurement.noise for h in hands])
        self._objects = {name: ObjectRows([w.objects[name] for w in worlds]) for name in first.objects}
        contexts = [w.CreateDefaultContext() for w in worlds]
        self._set_points = np.array(
            [h.GetOutputPort("setpoint").Eval(h.GetMyContextFromRoot(c)) for h, c in zip(hands, contexts, strict=True)]
        )
        self.states = {
            n: np.array([w.GetOutputPort(f"{n}.state").Eval(c) for w, c in zip(worlds, contexts, strict=True)])
            for n in self.graph.objects
        }
        self._active = {n: np.zeros((len(worlds), len(o.parents))) for n, o in first.objects.items()}
        for name in self._objects:
            self._decide(name)

    def __len__(self) -> int:
        return len(self._set_points)

    def _decide(self, name: str) -> None:
        self._active[name] = self._objects[name].decide(self.states[name], self.states, self._active[name])

    def measured(self, name: str) -> FloatArray:
        """What the sensors of the robot or of an object read now, shape (n, n_observable)."""
        if name == self.graph.root:
            return self._sensor.read(self.states[name], self._hand_noise.at(self._frame))
        return self._objects[name].measure(self.states[name], self._frame)

    def tick(self, command: FloatArray) -> list[dict[str, FloatArray]]:
        """Advance by one tick.

        Args:
            command: hand commands, shape (n, n_hand).

        Returns:
            The states at the ends of its frames.

        Raises:
            NotTogetherError: if a row can't be calculated as it is alone.
            InputError: on a command that is not finite.
        """
        way = self._motion.lay(self._set_points, command)
        return [self._advance(place) for place in way]

    def _advance(self, set_points: FloatArray) -> dict[str, FloatArray]:
        """One frame: decisions and what mirrors its parents, from states at t; then everything else."""
        for name in self._objects:
            self._decide(name)
        for immediate in (True, False):
            self.states = self.states | {
                name: rows.step(self.states[name], self.states, self._active[name], self._frame)
                for name, rows in self._objects.items()
                if rows.immediate == immediate
            }
        self._set_points = set_points
        self.states[self.graph.root] = self._motion.spec.reduce(set_points)
        self._frame += 1
        return self.states

    def keep(self, rows: BoolArray) -> None:
        """Go on with some of the worlds; shape (n,)."""
        self._set_points = self._set_points[rows]
        self.states = {n: s[rows] for n, s in self.states.items()}
        self._active = {n: a[rows] for n, a in self._active.items()}
        self._hand_noise.keep(rows)
        for each in self._objects.values():
            each.keep(rows)
