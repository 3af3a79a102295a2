"""A draw-well: a capstan that is geared only while it is held turns a drum with play, and a slack cable lifts a tray.

What `tests` need of a chain by motion, whole and from demonstrations: more than one turn either way, nothing that moves
with the hand still, and a goal at the chain's end with the hand away.
"""

import math
from dataclasses import dataclass, field

import numpy as np

import ichain_drake as ic

AXLE, RADIUS, HEIGHT = (0.55, -0.15), 0.06, 0.2  # of the capstan [m]
PLAY, SLACK, GEAR = 0.25, 1.6, 0.012  # [rad], [rad], [m/rad]


def _wrap(angle):
    return (angle + math.pi) % (2 * math.pi) - math.pi


def _spoke(angle, held=0.0):
    angle = np.asarray(angle, dtype=float)
    x, y = AXLE[0] + RADIUS * np.cos(angle), AXLE[1] + RADIUS * np.sin(angle)
    return np.stack([x, y, _wrap(angle), np.zeros_like(x) + held], axis=-1)


class Capstan(ic.WorldObject):
    """Its spoke goes around with a hand that closes around it."""

    state_space = ic.StateSpace(
        "capstan",
        (
            ic.Variable("u", "m", 0.4, 0.7, role=ic.Role("position", "robot", "x")),
            ic.Variable("v", "m", -0.3, 0.0, role=ic.Role("position", "robot", "y")),
            ic.Variable("phase", "rad", -math.pi, math.pi, "angle", ic.Role("orientation", "robot", "z")),
            ic.Variable("clutch", "1", 0.0, 1.0, "binary"),
        ),
    )
    immediate = True

    def decide_active(self, state, parents, active, touch):
        x, y, z, grip = parents["hand"]
        near = math.hypot(x - state[0], y - state[1]) < 0.02 and abs(z - HEIGHT) < 0.02
        return {"hand": bool(grip > 0.5 and (active["hand"] or near))}

    def step(self, state, parents, active, noise, dt):
        hand, held = parents["hand"], np.asarray(active["hand"])
        angle = np.arctan2(hand[..., 1] - AXLE[1], hand[..., 0] - AXLE[0])
        return _spoke(np.where(held > 0.5, angle, state[..., 2]), held)

    def measure(self, state, noise):
        read = state + np.array([5e-4, 5e-4, 0.006, 0.0]) * noise
        read[..., 2] = _wrap(read[..., 2])
        return read


class Drum(ic.WorldObject):
    """Counts how far the capstan has turned it."""

    state_space = ic.StateSpace(
        "drum",
        (ic.Variable("wound", "rad", 0.0, 25.0), ic.Variable("gap", hidden=True), ic.Variable("was", hidden=True)),
    )

    def decide_active(self, state, parents, active, touch):
        return {"capstan": bool(parents["capstan"][3] > 0.5)}

    def step(self, state, parents, active, noise, dt):
        phase = parents["capstan"][..., 2]
        gap = state[..., 1] + _wrap(phase - state[..., 2]) * np.asarray(active["capstan"])
        push = gap - np.clip(gap, -PLAY / 2, PLAY / 2)
        return np.stack([np.clip(state[..., 0] + push, 0.0, 25.0), gap - push, phase], axis=-1)

    def measure(self, state, noise):
        return np.clip(state[..., :1] + 0.012 * noise, 0.0, 25.0)


class Tray(ic.WorldObject):
    """Hangs at the cable."""

    state_space = ic.StateSpace("tray", (ic.Variable("up", "m", 0.0, 0.4),))

    def decide_active(self, state, parents, active, touch):
        return {"drum": bool(parents["drum"][0] > SLACK)}

    def step(self, state, parents, active, noise, dt):
        return np.clip(GEAR * np.maximum(parents["drum"][..., :1] - SLACK, 0.0), 0.0, 0.4)

    def measure(self, state, noise):
        return self.state_space.clip(state + 0.0008 * noise)


def _robot():
    return ic.RobotSpec(hand=ic.HandSpec(exposed=["x", "y", "z", "grip"], noise_std={"x": 5e-4, "y": 5e-4, "z": 5e-4}))


@dataclass
class WellConfig(ic.GraphConfig):
    """Settings of the well."""

    robot: ic.RobotSpec = field(default_factory=_robot)
    goal: list[str] = field(default_factory=lambda: ["0.075 <= tray.up <= 0.085", "not hand->capstan"])


@dataclass(frozen=True)
class WellStart:
    """Where a run starts."""

    phase: float
    wound: float = 0.0


class Well(ic.GraphScenario[WellStart]):
    """See the module."""

    name = "well"
    config_class = WellConfig

    def make_graph(self):
        objects = {"hand": self.config.robot.hand.space} | {
            c.state_space.type: c.state_space for c in (Capstan, Drum, Tray)
        }
        return ic.InteractionGraph(objects, ["hand->capstan", "capstan->drum", "drum->tray"])

    def draw_start(self, rng):
        return WellStart(rng.uniform(-3.0, 3.0))

    def make_objects(self, start, make):
        return {
            "capstan": make(Capstan, "capstan", initial=_spoke(start.phase)),
            "drum": make(Drum, "drum", initial=np.array([start.wound, 0.0, start.phase])),
            "tray": make(Tray, "tray", initial=np.array([GEAR * max(start.wound - SLACK, 0.0)])),
        }

    def script(self, rng):
        for k in range(5):
            start = WellStart(rng.uniform(-3.0, 3.0), rng.uniform(0.0, 4.0))
            hand, phase = self.hand_commands(), start.phase
            x, y = _spoke(phase)[:2]
            for dx, dy, dz in [(0.03, 0, 0), (-0.03, 0, 0), (0, 0.03, 0), (0, -0.03, 0), (0, 0, 0.035), (0, 0, -0.035)]:
                hand.grip(False).to(z=0.35).to(x + dx, y + dy).to(z=HEIGHT + dz).grip(True)
            for turns in ([4.0, -2.0, 7.0], [-1.0, 5.0, -9.0], [3.0, -6.0]):
                x, y = _spoke(phase)[:2]
                hand.grip(False).to(z=0.35).to(x, y).to(z=HEIGHT).grip(True)
                for turn in turns:
                    count = math.ceil(abs(turn) / 0.5)
                    for _ in range(count):
                        phase += turn / count
                        hand.to(*_spoke(phase)[:2])
                    hand.wait(int(rng.integers(1, 4)))
                hand.grip(False).to(z=0.35)
            yield ic.ScriptedPiece(f"turns_{k}", start, hand.commands)
