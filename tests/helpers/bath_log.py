"""A small graph in plain numpy for what is found out of states: a hand moves a lever, which fills a tank.

A rock never moves, and a fly moves by itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from ichain_drake.demonstrations import Demonstration, write_demonstration
from ichain_drake.graph import InteractionGraph
from ichain_drake.runs.discovery_scores import joined
from ichain_drake.state import Role, StateSpace, Variable
from ichain_drake.timing import TICK

SHUT, FLOW, REACH = 0.3, 0.1, 0.03


def _place(*axes: str) -> tuple[Variable, ...]:
    return tuple(Variable(a, "m", role=Role("position", "robot", a)) for a in axes)


HAND = StateSpace("hand", (*_place("x", "y"), Variable("grip", kind="binary", lower=0, upper=1)))
LEVER = StateSpace("lever", _place("x", "y"))
TANK = StateSpace("tank", (Variable("level", lower=0.0, upper=1.0),))
GRAPH = InteractionGraph({"hand": HAND, "lever": LEVER, "tank": TANK}, ["hand->lever", "lever->tank"])
FLY, ROCK = StateSpace("fly", _place("x", "y")), StateSpace("rock", _place("x", "y"))


def piece(seed: int, name: str = "") -> Demonstration:
    """A piece with all objects and true flags."""
    rng = np.random.default_rng(seed)
    hand, lever, level, grip, held = np.array([0.1, 0.0]), np.array([rng.uniform(0.1, 0.5), 0.2]), 0.2, 0.0, False
    fly, phase = np.zeros(2), rng.uniform(0, 6)
    rows: list[dict[str, float]] = []

    def tick(target: np.ndarray, closed: float) -> None:
        nonlocal hand, lever, level, grip, held, fly
        if held:
            lever = np.array([target[0] - hand[0], 0.0]) + lever
        hand = target
        held = bool(closed and (held or (not grip and np.abs(hand - lever).max() < REACH)))
        grip = closed
        flows = lever[0] > SHUT
        level = min(level + FLOW * (lever[0] - SHUT) * flows, 1.0)
        fly = 0.1 * np.array([np.sin(0.4 * len(rows) + phase), np.cos(0.3 * len(rows) + phase)])
        n = rng.standard_normal(8)
        rows.append(
            {
                "time": TICK * len(rows),
                "hand.x": hand[0] + 5e-4 * n[0], "hand.y": hand[1] + 5e-4 * n[1], "hand.grip": grip,
                "lever.x": lever[0] + 5e-4 * n[2], "lever.y": lever[1] + 5e-4 * n[3],
                "tank.level": level + 1e-3 * n[4],
                "fly.x": fly[0] + 5e-4 * n[5], "fly.y": fly[1] + 5e-4 * n[6], "rock.x": 0.7, "rock.y": 0.1,
                "hand->lever": float(held), "lever->tank": float(flows),
            }
        )  # fmt: skip

    def go(target: np.ndarray, closed: float) -> None:
        for point in np.linspace(hand, target, max(2, int(np.abs(target - hand).max() / 0.04)))[1:]:
            tick(point, closed)

    tick(hand, 0.0)
    for miss in ([0.06, 0.0], [0.0, 0.06], [0.0, 0.0]):  # twice beside it: nothing happens
        go(lever + miss, 0.0)
        for x in rng.uniform(0.1, 0.5, 3) if miss == [0.0, 0.0] else lever[:1] + [0.05]:
            tick(hand, 1.0)
            go(np.array([x, hand[1]]), 1.0)
            for _ in range(4):
                tick(hand, 1.0)
        tick(hand, 0.0)
    go(np.array([0.1, 0.0]), 0.0)
    return Demonstration(pd.DataFrame(rows), {}, name or f"piece_{seed}")


def pieces(count: int = 5, first: int = 0, objects: tuple[str, ...] = ("hand", "lever", "tank")) -> list[Demonstration]:
    """Pieces with some of the objects and the flags of `GRAPH`."""
    out = []
    for seed in range(first, first + count):
        whole = piece(seed)
        kept = [c for c in whole.table.columns if "->" in c or c == "time" or c.split(".")[0] in objects]
        out.append(Demonstration(whole.table[kept], {}, whole.name))
    return out


def write_log(parts: Sequence[Demonstration], folder: Path) -> Path:
    """Pieces as one recording without a mark, with units: `log.csv` in a folder."""
    units = {f"{o}.{v.name}": v.unit for o, s in GRAPH.objects.items() for v in s.variables}
    write_demonstration(replace(joined(parts, "log"), units=units), folder / "log.csv")
    return folder / "log.csv"
