"""Small learned models for the tests: made-up objects, some hundred transitions, the library's own fit."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np

from ichain_drake.demonstrations import Transitions
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.chain.link import EstimatorSpec, ForwardSpec, fit_forward
from ichain_drake.learning.chain.models import ActionKind, ForwardModel
from ichain_drake.learning.features import ChangeCode, FeatureKind
from ichain_drake.state import FloatArray, Role, StateSpace, Variable

HAND = StateSpace("hand", (Variable("x", "m", -1.0, 1.0), Variable("y", "m", -1.0, 1.0)))
STICK = StateSpace("stick", (Variable("a", "rad", -1.0, 1.0), Variable("b", "rad", -1.0, 1.0)))
CART = StateSpace(
    "cart",
    (
        Variable("px", "m", role=Role("position", "floor", "x")),
        Variable("py", "m", role=Role("position", "floor", "y")),
        Variable("heading", "rad", kind="angle", role=Role("orientation", "floor", "z")),
        Variable("speed", "m/s", 0.0, 2.0),
        Variable("wear", hidden=True),
    ),
)
LEVEL = StateSpace("tank", (Variable("level", "m", 0.0, 2.0), Variable("phase", "rad", kind="angle")))

Step = Callable[[FloatArray, FloatArray, FloatArray], FloatArray]
"""(child, parent, parent_next) -> child_next, rows."""


def stick_step(child: FloatArray, parent: FloatArray, after: FloatArray) -> FloatArray:
    """Mirrors its parent, with a little of where that came from."""
    return 0.8 * after + 0.1 * parent + 0.2 * after**2


def cart_step(child: FloatArray, parent: FloatArray, after: FloatArray) -> FloatArray:
    """Drives as the stick says: `a` turns, `b` is the wanted speed."""
    heading, speed = child[:, 2], child[:, 3]
    turn = heading + 0.4 * after[:, 0]
    moved = np.stack([0.3 * speed * np.cos(turn), 0.3 * speed * np.sin(turn)], axis=1)
    speed = speed + 0.5 * (after[:, 1] - 0.5 * speed)
    return np.column_stack([child[:, :2] + moved, turn, speed])


def pull_step(child: FloatArray, parent: FloatArray, after: FloatArray) -> FloatArray:
    """The first variable drifts to the parent's, the second turns with it."""
    first = child[:, 0] + 0.2 * (after[:, 0] - child[:, 0]) + 0.05 * after[:, 0] * child[:, 0]
    return np.column_stack([first, child[:, 1] + 0.3 * after[:, 0] - 0.1 * parent[:, 1]])


def learn(  # noqa: PLR0917
    child: StateSpace,
    parent: StateSpace,
    step: Step,
    features: FeatureKind = "raw",
    action: ActionKind = "next",
    degree: int = 2,
    seed: int = 0,
) -> ForwardModel:
    """Fit a forward model to 150 random transitions with a little noise."""
    rng = np.random.default_rng(seed)
    child, parent = child.observable, parent.observable
    state, now, after = (rng.uniform(-1.0, 1.0, (150, len(s))) for s in (child, parent, parent))
    state[:, child.angle_mask] *= np.pi
    result = step(state, now, after) + 1e-3 * rng.standard_normal(state.shape)
    result = ChangeCode(child, features).wrap(result)
    piece = np.arange(150)  # each row a piece of its own
    data = Transitions(child, parent, state, result, now, after, piece=piece, row=np.zeros_like(piece))
    spec = ForwardSpec(EstimatorSpec("polynomial", {"degree": degree}), features, action)
    return fit_forward(data, spec, Interaction(parent.type, child.type)).model


@cache
def chain() -> tuple[InteractionGraph, dict[Interaction, ForwardModel]]:
    """hand -> stick -> cart: a static child that reads both states of its parent, and a child with a pose."""
    graph = InteractionGraph({"hand": HAND, "stick": STICK, "cart": CART}, ["hand->stick", "stick->cart"])
    models = (
        learn(STICK, HAND, stick_step, "none", "both"),
        learn(CART, STICK, cart_step, "body", "next", degree=3),
    )
    return graph, dict(zip(graph.interactions, models, strict=True))


@cache
def cycle() -> tuple[InteractionGraph, dict[Interaction, ForwardModel]]:
    """hand -> a <-> b -> c, and hand -> b: two objects in a cycle, two parents each, and one behind it."""
    objects = {"c": LEVEL, "a": LEVEL, "hand": HAND, "b": LEVEL}
    graph = InteractionGraph(objects, ["b->a", "hand->a", "a->b", "b->c", "hand->b"])
    models = {
        e: learn(LEVEL, objects[e.parent], pull_step, action=("next", "both", "current")[i % 3], seed=i)
        for i, e in enumerate(graph.interactions)
    }
    return graph, models


def hand_path(ticks: int, seed: int = 3) -> FloatArray:
    """A wandering hand, shape (ticks, 2), within +-0.8."""
    rng = np.random.default_rng(seed)
    return 0.8 * np.sin(np.cumsum(rng.uniform(0.0, 0.6, (ticks, 2)), axis=0))
