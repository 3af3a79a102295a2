"""Whole models of a link as ONNX: states in, states out, features and codes inside."""

from __future__ import annotations

from typing import Any

import numpy as np

from ichain_drake.learning.chain.models import ForwardModel, InverseModel
from ichain_drake.learning.features import FeatureKind, StateFeatures, planar_poses
from ichain_drake.learning.portable.frozen import add_frozen
from ichain_drake.learning.portable.graph import OnnxGraph
from ichain_drake.state import StateSpace


def forward_bytes(model: ForwardModel) -> bytes:
    """Tr as ONNX: `child` and `parent` at t and `parent_next`, as far as it looks at them, to `child_next`."""
    graph = OnnxGraph("forward")
    child = graph.input("child", len(model.child_space))
    seen = [_features(graph, child, StateFeatures(model.child_space, model.features))]
    for name, actions in (("parent", ("current", "both")), ("parent_next", ("next", "both"))):
        if model.action in actions:
            parent = graph.input(name, len(model.parent_space))
            offset = None if model.origin is None else model.origin.offset(model.parent_space)
            parent = parent if offset is None else graph("Sub", parent, offset)
            seen.append(_features(graph, parent, StateFeatures(model.parent_space, "raw")))
    code = add_frozen(graph, model.frozen, graph.join([s for s in seen if s]))
    after = _decoded(graph, child, code, model.child_space, model.features)
    graph.output("child_next", after, len(model.child_space))
    spaces = {"child": model.child_space, "parent": model.parent_space}
    return graph.to_bytes({"model": "forward", **{n: space_words(s) for n, s in spaces.items()}})


def inverse_bytes(model: InverseModel) -> bytes:
    """Tr^-1 as ONNX: `child` now and `wanted` values of its target variables, to `parent`."""
    graph = OnnxGraph("inverse")
    space = model.child_space
    child, wanted = graph.input("child", len(space)), graph.input("wanted", len(model.targets))
    change = _encoded_targets(graph, child, wanted, model)
    seen = [_features(graph, child, StateFeatures(space, model.features)), change]
    answer = add_frozen(graph, model.frozen, graph.join([s for s in seen if s]))
    offset = None if model.origin is None else model.origin.offset(model.parent_space)
    answer = answer if offset is None else graph("Add", answer, offset)
    answer = graph("Min", graph("Max", answer, model.lower), model.upper)
    graph.output("parent", answer, len(model.parent_space))
    spaces = {
        "child": space,
        "parent": model.parent_space,
        "wanted": space.subspace([space.names[i] for i in model.targets]),
    }
    return graph.to_bytes(
        {"model": "inverse", "ticks_ahead": model.aim, **{n: space_words(s) for n, s in spaces.items()}}
    )


def space_words(space: StateSpace) -> list[dict[str, Any]]:
    """The variables of a state space as plain values, in order."""
    return [{"name": v.name, "unit": v.unit, "kind": v.kind} for v in space.variables]


def _features(graph: OnnxGraph, state: str, features: StateFeatures) -> str:
    """See `StateFeatures`; empty where there are none."""
    parts = []
    if len(features.plain):
        parts.append(graph.columns(state, features.plain))
    if len(features.angles):
        angles = graph.columns(state, features.angles)
        parts += [graph("Cos", angles), graph("Sin", angles)]
    return graph.join(parts) if parts else ""


def _singly(graph: OnnxGraph, table: str, width: int) -> list[str]:
    return [graph.columns(table, [i]) for i in range(width)]


def _turned(graph: OnnxGraph, x: str, y: str, heading: str, way: int) -> tuple[str, str]:
    """A vector in a frame that is turned by the heading (way 1), or back (way -1)."""
    c, s = graph("Cos", heading), graph("Mul", graph("Sin", heading), np.float64(way))
    return (
        graph("Sub", graph("Mul", c, x), graph("Mul", s, y)),
        graph("Add", graph("Mul", s, x), graph("Mul", c, y)),
    )


def _decoded(graph: OnnxGraph, state: str, code: str, space: StateSpace, kind: FeatureKind) -> str:
    """The state that a code leads to, angles brought back; see `ChangeCode`."""
    changes = _singly(graph, code, len(space))
    if kind != "none":
        now = _singly(graph, state, len(space))
        for x, y, h in planar_poses(space) if kind == "body" else []:
            changes[x], changes[y] = _turned(graph, changes[x], changes[y], now[h], 1)
        changes = [graph("Add", n, c) for n, c in zip(now, changes, strict=True)]
    return graph.join([graph.wrapped(c) if a else c for c, a in zip(changes, space.angle_mask, strict=True)])


def _encoded_targets(graph: OnnxGraph, child: str, wanted: str, model: InverseModel) -> str:
    """The coded change of the target variables; the others are wanted to stay."""
    space, targets = model.child_space, model.targets
    goals = _singly(graph, wanted, len(targets))
    if model.features == "none":
        return graph.join(goals)
    now = _singly(graph, child, len(space))
    changes = [graph("Mul", n, np.float64(0.0)) for n in now]
    for i, goal in zip(targets, goals, strict=True):
        change = graph("Sub", goal, now[i])
        changes[i] = graph.wrapped(change) if space.angle_mask[i] else change
    for x, y, h in planar_poses(space) if model.features == "body" else []:
        changes[x], changes[y] = _turned(graph, changes[x], changes[y], now[h], -1)
    return graph.join([changes[i] for i in targets])
