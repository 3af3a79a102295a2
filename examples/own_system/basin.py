"""A basin: it fills while a tap is open, faster the further, and leaks a little all the time."""

import numpy as np
from pydrake.geometry import Box
from pydrake.math import RigidTransform

import ichain_drake as ic

SHUT = 0.45  # lever up to which nothing flows [m]
INFLOW, LEAK = 0.30, 0.002  # 1/(m s), 1/s


class Basin(ic.WorldObject):
    """Water up to a level of 1. Its one parent is a tap with a lever."""

    state_space = ic.StateSpace("basin", (ic.Variable("level", "1", 0.0, 1.0),))
    process_noise_size = 1

    def decide_active(self, state, parents, active, touch):
        (tap,) = self.parents
        return {tap: bool(parents[tap][0] > SHUT + (0.0 if active[tap] else 0.002))}

    def step(self, state, parents, active, noise, dt):
        (tap,) = self.parents
        flow = np.asarray(active[tap])[..., None] * INFLOW * (parents[tap][..., :1] - SHUT)
        return np.clip(state + dt * (flow - LEAK * state) + 0.0005 * np.sqrt(dt) * noise, 0.0, 1.0)

    def measure(self, state, noise):
        return np.clip(state + 0.002 * noise, 0.0, 1.0)


class BasinDrawing:
    """Water that rises in front of a wall."""

    def setup(self, scene):
        scene.shape("wall", Box(0.01, 0.24, 0.16), (0.8, 0.8, 0.8), RigidTransform([0.77, 0.0, 0.08]))
        scene.shape("water/column", Box(0.10, 0.20, 0.14), (0.1, 0.3, 0.8), RigidTransform([0.70, 0.0, 0.07]))

    def update(self, scene, time, state):
        scene.scale("water", (1.0, 1.0, state[0]), time)
