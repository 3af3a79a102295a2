"""What goes wrong in a run of a scenario with a goal, as the section `fault` of its configuration asks for."""

# No `from __future__ import annotations`: Drake's typed YAML reader needs the fields' types themselves.

import math
from dataclasses import dataclass

import numpy as np

from ichain_drake.scenarios.config import FaultConfig
from ichain_drake.settings import setting

FAULTS: tuple[str, ...] = ("none", "slip", "knock", "stiff", "dropout", "moved")
"""The kinds that `Faults` knows."""


@dataclass
class GoalFaultConfig(FaultConfig):
    """A fault that an evaluation asks for, and what it does.

    Attributes:
        time: earliest and latest time of a slip, knock or drop-out [s].
        knock: by how much a standing thing is displaced [m].
        dropout: duration [s].
        stiffness: factor on the force of what is stiff, or on the way that a hand has to go.
        moved: by how much a standing thing is displaced towards the robot while the hand is away [m].
        away: how far from the thing the hand is then at least [m].
    """

    time: list[float] = setting(lambda: [4.0, 60.0], "s", size=2, lower=0, upper=1e4, rising=True)
    knock: float = setting(0.05, "m", lower=0, upper=1)
    dropout: float = setting(1.0, "s", lower=0, upper=1e4)
    stiffness: float = setting(1.5, above=0, upper=1000)
    moved: float = setting(0.1, "m", lower=0, upper=1)
    away: float = setting(0.2, "m", lower=0, upper=1)


@dataclass(frozen=True)
class Faults:
    """What goes wrong in one run; nothing unless said. A scenario hands it to the objects that it meets.

    Attributes:
        slips: times at which a held thing slips out of the hand [s].
        knocks: times [s] and displacements along x and y [m] of a thing that stands.
        away: how far the hand is from what is knocked, at least [m].
        dropouts: intervals in which a sensor gives nothing [s].
        stiffness: factor on the force of buttons and the like, or on the way that a hand has to go.
    """

    slips: tuple[float, ...] = ()
    knocks: tuple[tuple[float, float, float], ...] = ()
    dropouts: tuple[tuple[float, float], ...] = ()
    stiffness: float = 1.0
    away: float = 0.0


def draw_faults(config: GoalFaultConfig, rng: np.random.Generator) -> Faults:
    """What goes wrong in one run.

    Args:
        config: its kind, of `FAULTS`, and what it does.
        rng: draws when it happens and in which direction.
    """
    time = float(rng.uniform(config.time[0], config.time[1]))
    turn = float(rng.uniform(-math.pi, math.pi))
    kind = config.kind
    if kind == "slip":
        return Faults(slips=(time,))
    if kind == "knock":
        return Faults(knocks=((time, config.knock * math.cos(turn), config.knock * math.sin(turn)),))
    if kind == "moved":  # somewhere in the half-plane before it, so that it stays within reach
        side = math.pi + 0.5 * turn
        return Faults(knocks=((time, config.moved * math.cos(side), config.moved * math.sin(side)),), away=config.away)
    if kind == "dropout":
        return Faults(dropouts=((time, time + config.dropout),))
    return Faults(stiffness=config.stiffness if kind == "stiff" else 1.0)
