"""Four objects put into demonstrations that act on nothing: what is found must not take them for causes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ichain_drake.demonstrations import Demonstration
from ichain_drake.graph import InteractionGraph
from ichain_drake.learning.discovery.labels import raw_piece
from ichain_drake.learning.discovery.log import RawPiece
from ichain_drake.state import FloatArray, Role, StateSpace, Variable

LAMP, FOLLOWER, MOVER, STONE = "distractor lamp", "distractor follower", "distractor mover", "distractor stone"
_NOISE = 1e-3  # of their readings [m]


def _place(*axes: str) -> tuple[Variable, ...]:
    return tuple(Variable(a, "m", role=Role("position", "distractors", a)) for a in axes)


SPACES = {
    LAMP: StateSpace(LAMP, (Variable("on", kind="binary", lower=0, upper=1),)),
    FOLLOWER: StateSpace(FOLLOWER, _place("x", "y")),
    MOVER: StateSpace(MOVER, _place("x", "y")),
    STONE: StateSpace(STONE, _place("x", "y")),
}
"""A lamp that lights with one of the graph's interactions, what goes after the robot, what moves by itself, and what
nothing acts on."""


def distracted(
    pieces: Sequence[Demonstration], graph: InteractionGraph, seed: int
) -> tuple[list[RawPiece], dict[str, StateSpace]]:
    """States of pieces with the four objects, and the state spaces of all.

    The lamp lights up in the very rows in which the graph's last interaction of no robot is active, so that it can't be
    told from what acts there. The follower goes a third of the way to the robot in each tick.

    Args:
        pieces: with true flags.
        graph: of the pieces.
        seed: of noise and motion.
    """
    edges = [e for e in graph.interactions if e.parent != graph.root] or list(graph.interactions)
    rng = np.random.default_rng(seed)
    out = []
    for piece in pieces:
        raw = raw_piece(piece, graph)
        lit = piece.table[edges[-1].name].to_numpy(dtype=float)[:, None] if edges[-1].name in piece.table else None
        out.append(replace(raw, states={**raw.states, **_states(raw.states.get(graph.root), lit, len(piece), rng)}))
    return out, {n: s.observable for n, s in graph.objects.items()} | SPACES


def _states(
    robot: FloatArray | None, lit: FloatArray | None, rows: int, rng: np.random.Generator
) -> dict[str, FloatArray]:
    """Measured states of those that a piece can hold: nobody follows a robot that it doesn't."""
    start = rng.uniform(-1.0, 1.0, 2)
    places = {
        MOVER: start + 0.1 * np.sin(0.3 * np.arange(rows)[:, None] + rng.uniform(0.0, 6.0, 2)),
        STONE: np.tile(np.array([0.7, -0.2]), (rows, 1)),
    }
    if robot is not None:
        follower = np.repeat(robot[:1, :2], rows, axis=0)
        for t in range(1, rows):
            follower[t] = follower[t - 1] + (robot[t, :2] - follower[t - 1]) / 3.0
        places[FOLLOWER] = follower
    out = {name: place + _NOISE * rng.standard_normal((rows, 2)) for name, place in places.items()}
    return out if lit is None else {**out, LAMP: lit}
