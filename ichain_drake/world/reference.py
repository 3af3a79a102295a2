"""The world in plain numpy, for an ideal hand: a reference for tests, and the true model that an oracle plans with."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from ichain_drake.graph import InteractionGraph
from ichain_drake.objects.base import WorldObject
from ichain_drake.state import FloatArray
from ichain_drake.timing import FRAME, FRAMES_PER_TICK

HandFrames = Callable[[FloatArray, FloatArray], FloatArray]
"""(hand state (..., n), command (..., n)) -> hand states at the ends of a tick's frames, (frames, ..., n)."""


class WorldReference:
    """Steps the objects of a world exactly as its Diagram does, all interactions active, in batches.

    Args:
        graph: the interaction graph.
        objects: the world's objects; only their `step` is used.
        hand_frames: how the hand moves within a tick.
    """

    def __init__(self, graph: InteractionGraph, objects: Mapping[str, WorldObject], hand_frames: HandFrames) -> None:
        self.graph = graph
        self.objects = dict(objects)
        self._hand_frames = hand_frames
        self._immediate = [n for n, o in self.objects.items() if o.immediate]
        self._delayed = [n for n, o in self.objects.items() if not o.immediate]

    def tick(
        self,
        states: Mapping[str, FloatArray],
        command: FloatArray,
        noise: Callable[[str, int], FloatArray] | None = None,
        frames: list[dict[str, FloatArray]] | None = None,
    ) -> dict[str, FloatArray]:
        """Advance by one tick of ten frames.

        Args:
            states: state of the robot and of every object, shape (..., n_variables) each.
            command: hand command, shape (..., n_hand).
            noise: (object, frame within the tick) -> standard normal, shape (..., process_noise_size); None for none.
            frames: if given, the states after each frame are appended.

        Returns:
            The states at the end of the tick.
        """
        root = self.graph.root
        hand = self._hand_frames(np.asarray(states[root]), np.asarray(command))
        current = {n: np.asarray(s, dtype=float) for n, s in states.items()}
        for k in range(FRAMES_PER_TICK):
            for group in (self._immediate, self._delayed):
                current |= {n: self._step(n, current, noise, k) for n in group}
            current[root] = hand[k]
            if frames is not None:
                frames.append(dict(current))
        return current

    def _step(
        self,
        name: str,
        current: Mapping[str, FloatArray],
        noise: Callable[[str, int], FloatArray] | None,
        frame: int,
    ) -> FloatArray:
        system = self.objects[name]
        state = current[name]
        values = np.zeros((*state.shape[:-1], system.process_noise_size)) if noise is None else noise(name, frame)
        parents = {p: current[p] for p in system.parents}
        return system.step(state, parents, dict.fromkeys(parents, np.ones(state.shape[:-1])), values, FRAME)
