"""A second graph, small and in plain numpy: a hand carries a box under a tap; a valve opens the tap and lights a lamp.

The box is seen in a camera's frame. The tap holds water at 3 Hz ticks; the lamp cools by itself.
"""

from __future__ import annotations

import numpy as np
import pandas as pd

from ichain_drake.demonstrations import Demonstration
from ichain_drake.graph import InteractionGraph
from ichain_drake.state import FloatArray, Role, StateSpace, Variable
from ichain_drake.timing import TICK

FLOW, PUSH, COOLING = 0.03, 0.05, 0.1
REACH = 0.03
VALVE, UNDER, SHIFT = np.array([0.5, 0.3, 0.1]), np.array([0.6, -0.2, 0.1]), np.array([0.2, -0.1, 0.3])


def _pose(frame: str) -> tuple[Variable, ...]:
    return tuple(Variable(a, "m", role=Role("position", frame, a)) for a in "xyz")


def _contents(of: str) -> tuple[Variable, ...]:
    return (
        Variable(of, lower=0.0, upper=1.0, role=Role("amount")),
        Variable("heat", lower=0.0, upper=1.0, role=Role("intensive", of=of)),
        Variable("change", role=Role("change", of=of)),
    )


GRAPH = InteractionGraph(
    {
        "hand": StateSpace("hand", (*_pose("robot"), Variable("grip", kind="binary", lower=0, upper=1))),
        "box": StateSpace("box", (*_pose("camera"), *_contents("water"))),
        "valve": StateSpace("valve", (Variable("level", lower=0, upper=6, kind="integer", role=Role("level")),)),
        "tap": StateSpace("tap", _contents("stock")),
        "lamp": StateSpace("lamp", (Variable("glow", lower=0.0, upper=2.0),)),
    },
    ["hand->box", "hand->valve", "valve->tap", "tap->box", "valve->lamp"],
)


class SmallWorld:
    """The truth, one tick at a time."""

    def __init__(self, seed: int, yaw: float = 0.3, noise: float = 1.0) -> None:
        self.rng = np.random.default_rng(seed)
        c, s = np.cos(yaw), np.sin(yaw)
        self.turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
        self.noise = noise
        u = self.rng.uniform
        self.hand, self.grip, self.held = np.array([u(0.2, 0.4), u(-0.1, 0.1), 0.3]), 0.0, False
        self.box, self.water, self.heat = np.array([u(0.2, 0.5), u(0.0, 0.2), 0.0]), u(0, 0.4), u(0, 0.3)
        self.stock, self.tap_heat, self.glow, self.level = u(0.6, 1.0), u(0.6, 1.0), u(0.2, 1.5), 0.0
        self.changes = np.zeros(2)
        self.rows: list[dict[str, float]] = []
        self.record()

    def over_valve(self) -> bool:
        return bool(np.all(np.abs(self.hand - VALVE) < REACH))

    def record(self) -> None:
        n = self.noise * self.rng.standard_normal(12)
        seen = self.turn @ self.box + SHIFT + 1e-3 * n[:3]
        hand = self.hand + 5e-4 * n[3:6]
        values = {
            **{f"hand.{a}": v for a, v in zip("xyz", hand, strict=True)}, "hand.grip": self.grip,
            **{f"box.{a}": v for a, v in zip("xyz", seen, strict=True)},
            "box.water": self.water + 3e-3 * n[6], "box.heat": self.heat + 3e-3 * n[7],
            "box.change": self.changes[0] + 3e-3 * n[8],
            "valve.level": self.level,
            "tap.stock": self.stock + 3e-3 * n[9], "tap.heat": self.tap_heat + 3e-3 * n[10],
            "tap.change": self.changes[1] + 3e-3 * n[11],
            "lamp.glow": self.glow + 3e-3 * self.noise * self.rng.standard_normal(),
        }  # fmt: skip
        under = bool(np.all(np.abs(self.box - UNDER) < REACH))
        flags = {
            "hand->box": self.held, "hand->valve": self.over_valve(), "valve->tap": self.level > 3,
            "tap->box": under, "valve->lamp": self.level > 3,
        }  # fmt: skip
        self.rows.append({"time": TICK * len(self.rows), **values, **{k: float(v) for k, v in flags.items()}})

    def tick(self, hand: FloatArray, grip: float) -> None:
        hand = np.asarray(hand, dtype=float)
        if self.held:
            self.box = self.box + hand - self.hand
        self.hand = hand
        if not grip:
            self.held = False
        elif not self.grip:
            self.held = bool(np.all(np.abs(self.hand - self.box) < REACH))
        self.grip = grip
        depth = np.clip((VALVE[2] + REACH - self.hand[2]) / REACH, 0, 1)
        self.level = float(np.round(6 * depth)) if self.over_valve() else 0.0
        before = self.water, self.stock
        self.glow -= COOLING * self.glow
        if self.level > 3:
            self.glow += PUSH
            out = min(FLOW, self.stock)
            self.stock -= out
            if np.all(np.abs(self.box - UNDER) < REACH):
                self.heat = (self.heat * self.water + self.tap_heat * out) / (self.water + out)
                self.water += out
        self.changes = np.array([self.water - before[0], self.stock - before[1]])
        self.record()

    def go(self, target: FloatArray, grip: float, step: float = 0.04) -> None:
        target = np.asarray(target, dtype=float)
        n = max(1, int(np.ceil(np.linalg.norm(target - self.hand) / step)))
        for point in np.linspace(self.hand, target, n + 1)[1:]:
            self.tick(point, grip)

    def piece(self, name: str) -> Demonstration:
        return Demonstration(pd.DataFrame(self.rows), {}, name)


def _carry(w: SmallWorld, target: FloatArray, sweep: bool) -> None:
    u = w.rng.uniform
    if sweep:
        for k in range(3):  # close beside the box: no grasp
            off = np.zeros(3)
            off[k] = (1 if k == 2 else w.rng.choice([-1, 1])) * REACH * u(1.15, 1.4)
            w.go(w.box + off, 0.0)
            w.tick(w.hand, 1.0)
            w.tick(w.hand, 1.0)
            w.tick(w.hand, 0.0)
    w.go(w.box + u(-0.6, 0.6, 3) * REACH, 0.0)
    w.tick(w.hand, 1.0)
    offset = w.hand - w.box
    w.go(target + [0, 0, 0.2] + offset, 1.0)
    w.go(target + offset, 1.0)
    if sweep:
        for k in range(3):
            for f in (1.6, -1.6, 0.0):
                w.go(target + offset + f * REACH * np.eye(3)[k], 1.0, 0.012)
    w.tick(w.hand, 0.0)
    w.tick(w.hand, 0.0)
    w.go(w.hand + [0, 0, 0.15], 0.0)


def _press(w: SmallWorld, sweep: bool) -> None:
    u = w.rng.uniform
    at = VALVE + np.array([*u(-0.4, 0.4, 2), 0.0]) * REACH
    w.go(at + [0, 0, 0.15], 1.0)
    for level in w.rng.permutation([1, 2, 3, 4, 5, 6]):
        w.go([at[0], at[1], VALVE[2] + REACH * (1 - level / 6)], 1.0)
        for _ in range(6):
            w.tick(w.hand, 1.0)
    if sweep:
        for k in range(2):
            for f in (1.6, -1.6, 0.0):
                w.go([*(VALVE[:2] + f * REACH * np.eye(2)[k]), VALVE[2] + 0.005], 1.0, 0.012)
    w.go(at + [0, 0, 0.15], 1.0)


def pieces(seed: int = 0, yaw: float = 0.3, noise: float = 1.0) -> list[Demonstration]:
    out = []
    for k in range(9):
        w = SmallWorld(1000 * seed + k, yaw, noise)
        if k % 3 == 0:
            _carry(w, UNDER + w.rng.uniform(-0.4, 0.4, 3) * REACH, sweep=True)
        elif k % 3 == 1:
            w.box = UNDER + w.rng.uniform(-0.5, 0.5, 3) * REACH
            w.rows.clear()
            w.record()
            _press(w, sweep=k == 4)
        else:
            _carry(w, np.array([*w.rng.uniform(0.2, 0.5, 2), 0.0]), sweep=True)
            _press(w, sweep=k > 2)
        out.append(w.piece(f"piece_{k}"))
    return out


def states_of(piece: Demonstration) -> dict[str, FloatArray]:
    return {n: piece.states(n, s) for n, s in GRAPH.objects.items()}
