"""A tap: a hand that closes around its lever takes it along a rail, and it stays where it is let go."""

import numpy as np
from pydrake.geometry import Box
from pydrake.math import RigidTransform

import ichain_drake as ic

RAIL = 0.10  # y of the rail [m]
ENDS = (0.40, 0.60)  # x of its ends [m]


class Tap(ic.WorldObject):
    """The lever on its rail along x; y stays. Its one parent is a hand with x, y and grip."""

    state_space = ic.StateSpace(
        "tap",
        (
            ic.Variable("x", "m", *ENDS, role=ic.Role("position", "robot", "x")),
            ic.Variable("y", "m", RAIL - 0.01, RAIL + 0.01, role=ic.Role("position", "robot", "y")),
        ),
    )
    immediate = True  # a held lever is where the hand is

    def decide_active(self, state, parents, active, touch):
        (hand,) = self.parents
        x, y, grip = parents[hand]
        around = abs(x - state[0]) < 0.02 and abs(y - state[1]) < 0.03
        return {hand: bool(grip > 0.5 and (active[hand] or around))}

    def step(self, state, parents, active, noise, dt):
        (hand,) = self.parents
        held = np.asarray(active[hand]) > 0.5
        x = np.where(held, np.clip(parents[hand][..., 0], *ENDS), state[..., 0])
        return np.stack([x, state[..., 1]], axis=-1)

    def measure(self, state, noise):
        return self.state_space.clip(state + 0.0005 * noise)


class TapDrawing:
    """How it looks in a playback: made once, then moved."""

    def setup(self, scene):
        scene.shape("rail", Box(0.24, 0.01, 0.01), (0.5, 0.5, 0.5), RigidTransform([0.5, RAIL, 0.17]))
        scene.shape("lever", Box(0.02, 0.03, 0.07), (0.7, 0.2, 0.1), RigidTransform())

    def update(self, scene, time, state):
        scene.pose("lever", RigidTransform([*state, 0.19]), time)
