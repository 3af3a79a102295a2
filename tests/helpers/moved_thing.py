"""A robot that moves a thing along x: the smallest graph in which something goes along with the robot."""

from __future__ import annotations

import numpy as np
from toy_models import GRIP, ToyModel, moved

from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.state import Role, StateSpace, Variable

NOISE = 1e-3
EDGE = Interaction("robot", "thing")
ALONG_X = Role("position", "robot", "x")


def model(role: Role | None = ALONG_X) -> ToyModel:
    """A robot that moves a thing along x; a thing without roles has no pose."""
    spaces = {
        "robot": StateSpace("robot", (Variable("x", "m", role=role), GRIP)),
        "thing": StateSpace("thing", (Variable("x", "m", role=role), Variable("water", lower=0, upper=1))),
    }
    rows = [{"robot": [x, 1.0], "thing": [x, 0.5]} for x in (0.0, 1.0)]
    toy = ToyModel(
        InteractionGraph(spaces, [EDGE.name]),
        {EDGE.name: lambda s: np.zeros(len(s["thing"]))},
        {EDGE.name: moved},
        {"thing": ["hold", "hold"]},
        {EDGE.name: rows},
        {},
    )
    toy.noise = {n: np.full(2, NOISE) for n in spaces}
    return toy
