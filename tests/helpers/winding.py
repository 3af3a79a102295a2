"""Small exact models of what is driven by motion alone: a knob that winds a shade, and a pedal that pumps."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from toy_models import GRIP, ToyModel

from ichain_drake.control.planning.skills import Skills
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.status.events import SwitchingWindow
from ichain_drake.state import FloatArray, StateSpace, Variable

GEAR = 0.1  # of the shade's way, a radian
TURN = Interaction("robot", "knob")


def _held(states: Mapping[str, FloatArray]) -> FloatArray:
    return states["robot"][:, -1] - 0.5


def _geared(gear: float):
    """A child whose only variable changes with that of its parent."""
    return lambda p, q, c: gear * (q[..., :1] - p[..., :1]) * np.ones_like(c)


def shade() -> ToyModel:
    """A wrist that turns by one radian to either side, a knob without an end, and a shade that it winds up and down."""
    spaces = {
        "robot": StateSpace("robot", (Variable("turn", "rad", -1.0, 1.0), GRIP)),
        "knob": StateSpace("knob", (Variable("angle", "rad"),)),
        "shade": StateSpace("shade", (Variable("height", lower=0.0, upper=1.0),)),
    }
    graph = InteractionGraph(spaces, ["robot->knob", "knob->shade"])

    def at(turn: float, angle: float, grip: float = 1.0) -> dict[str, list[float]]:
        return {"robot": [turn, grip], "knob": [angle], "shade": [0.5 + GEAR * angle]}

    strokes = [at(t, middle + t) for middle in (-3.0, -1.0, 1.0, 3.0) for t in np.linspace(-1.0, 1.0, 41)]
    free = [at(t, middle + t, 0.0) for middle in (-3.0, 1.0) for t in (-1.0, 1.0)]
    return ToyModel(
        graph,
        {"robot->knob": _held, "knob->shade": lambda s: np.ones(len(s["shade"]))},
        {"robot->knob": lambda p, q, c: q[..., :1] - p[..., :1], "knob->shade": _geared(GEAR)},
        {"knob": ["hold"], "shade": ["hold"]},
        {"robot->knob": strokes, "knob->shade": strokes},
        {"robot->knob": free, "knob->shade": []},
    )


SHADE_START = {"robot": np.array([0.2, 0.0]), "knob": np.array([-2.0]), "shade": np.array([0.3])}


def shade_skills() -> Skills:
    """The hand closes and opens wherever the wrist is."""
    turns = np.linspace(-1.0, 1.0, 9)
    close = tuple(SwitchingWindow(np.array([[t, 0.0], [t, 1.0]]), np.zeros(1), 1) for t in turns)
    open_ = tuple(SwitchingWindow(np.array([[t, 1.0], [t, 0.0]]), np.zeros(1), 1) for t in turns)
    return Skills({TURN: close}, {TURN: open_})


def pump() -> ToyModel:
    """A pedal that follows a foot down and comes up with it; a tank fills on the way down only."""
    spaces = {
        "foot": StateSpace("foot", (Variable("y", "m", 0.0, 1.0), GRIP)),
        "pedal": StateSpace("pedal", (Variable("y", "m"),)),
        "tank": StateSpace("tank", (Variable("level", lower=0.0, upper=2.0),)),
    }
    graph = InteractionGraph(spaces, ["foot->pedal", "pedal->tank"])

    def at(y: float, level: float, grip: float = 1.0) -> dict[str, list[float]]:
        return {"foot": [y, grip], "pedal": [y], "tank": [level]}

    def press(p: FloatArray, q: FloatArray, c: FloatArray) -> FloatArray:
        return 0.2 * np.maximum(p[..., :1] - q[..., :1], 0.0) * np.ones_like(c)

    strokes = [at(y, level) for level in (0.4, 1.0, 1.6) for y in np.linspace(0.0, 0.3, 13)]
    return ToyModel(
        graph,
        {
            "foot->pedal": lambda s: np.minimum(
                s["foot"][:, -1] - 0.5, 0.05 - np.abs(s["foot"][:, 0] - s["pedal"][:, 0])
            ),
            "pedal->tank": lambda s: np.ones(len(s["tank"])),
        },
        {"foot->pedal": lambda p, q, c: q[..., :1] - p[..., :1], "pedal->tank": press},
        {"pedal": ["hold"], "tank": ["hold"]},
        {"foot->pedal": strokes, "pedal->tank": strokes},
        {"foot->pedal": [at(0.3, 0.4, 0.0)], "pedal->tank": []},
    )


PUMP_START = {"foot": np.array([0.5, 0.0]), "pedal": np.array([0.3]), "tank": np.array([0.4])}
