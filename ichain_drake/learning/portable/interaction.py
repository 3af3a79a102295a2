"""The parts of a learned graph as ONNX: status and effects of an interaction, passive dynamics of an object."""

from __future__ import annotations

import numpy as np

from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction
from ichain_drake.learning.effects.alignment import Alignment
from ichain_drake.learning.effects.columns import Column
from ichain_drake.learning.effects.fitted import Regression
from ichain_drake.learning.model import InteractionModel
from ichain_drake.learning.passive import PassiveDynamics
from ichain_drake.learning.portable.frozen import add_frozen
from ichain_drake.learning.portable.graph import OnnxGraph
from ichain_drake.learning.portable.link import space_words
from ichain_drake.learning.settings import LEARNING
from ichain_drake.learning.status.inputs import (
    DifferenceInput,
    PlaceInput,
    RelativeInput,
    StatusInput,
    ValueInput,
    objects_of,
)
from ichain_drake.state import StateSpace


def status_bytes(model: InteractionModel, edge: Interaction) -> bytes:
    """Whether an interaction is active: states of the objects that its status looks at, to `decision`, `probability`.

    What is known to be active stays so down to a decision of minus the margin, which is in the metadata.
    """
    status, graph = model.edges[edge].status, OnnxGraph("status")
    looked = dict.fromkeys(o for i in status.inputs for o in objects_of(i)) or {edge.child: None}
    spaces = {name: model.graph.objects[name].observable for name in looked}
    states = {name: graph.input(name, len(space)) for name, space in spaces.items()}
    if status.inputs:
        seen = graph.join([_status_input(graph, i, states) for i in status.inputs])
        scaled = graph("Div", graph("Sub", seen, status.offset), status.scale)
        decision = add_frozen(graph, status.frozen, scaled)
    else:
        always = status.frozen.value(np.zeros(0))
        decision = graph.rows(states[edge.child], len(spaces[edge.child]), always)
    sure = graph.single("Erf", graph("Div", decision, np.float64(status.spread * np.sqrt(2.0))))
    share = graph("Mul", graph("Add", sure, np.float64(1.0)), np.float64(0.5 - status.slip))
    graph.output("decision", decision, 1)
    graph.output("probability", graph("Add", share, np.float64(status.slip)), 1)
    about = {"model": "status", "interaction": edge.name, "margin": status.margin}
    return graph.to_bytes({**about, **{n: space_words(s) for n, s in spaces.items()}})


def effect_bytes(model: InteractionModel, edge: Interaction) -> bytes:
    """What an interaction adds to the child in a tick while active: `parent`, `parent_next`, `child`, to `change`."""
    graph = OnnxGraph("effect")
    parent_space, space = (model.graph.objects[n].observable for n in (edge.parent, edge.child))
    parent, after = (graph.input(n, len(parent_space)) for n in ("parent", "parent_next"))
    child = graph.input("child", len(space))
    changes = [graph.rows(child, len(space), [0.0]) for _ in range(len(space))]
    for effect in model.edges[edge].effects:
        seen = [_column(graph, c, parent, after, child) for c in effect.columns]
        changes[effect.variable] = _regression(graph, effect.regression, graph.join(seen) if seen else child, space)
    graph.output("change", graph.join(changes), len(space))
    about = {"model": "effect", "interaction": edge.name}
    return graph.to_bytes({**about, "parent": space_words(parent_space), "child": space_words(space)})


def passive_bytes(passive: PassiveDynamics) -> bytes:
    """What an object does while nothing acts on it: `state` to `next_state`; changes of amounts are given as 0."""
    graph, space = OnnxGraph("passive"), passive.space
    state, width = graph.input("state", len(space)), len(space)
    after = []
    for i, v in enumerate(passive.variables):
        now = graph.columns(state, [i])
        if v.kind in ("constant", "change"):
            now = graph.rows(state, width, [v.value if v.kind == "constant" else 0.0])
        elif v.drift is not None:
            seen = graph.columns(state, v.inputs) if v.inputs else state
            now = graph("Add", now, _regression(graph, v.drift, seen, space))
        after.append(now)
    graph.output("next_state", graph.join(after), width)
    return graph.to_bytes({"model": "passive", "state": space_words(space)})


def _regression(graph: OnnxGraph, regression: Regression, rows: str, space: StateSpace) -> str:
    """See `Regression`; where it is a constant, `rows` are states of `space`."""
    if regression.frozen is None:
        width = len(regression.columns) or len(space)
        return graph.rows(rows, width, [regression.constant])
    if regression.low is not None and regression.high is not None:
        rows = graph("Min", graph("Max", rows, regression.low), regression.high)
    value = graph.columns(add_frozen(graph, regression.frozen, rows), [0])
    if regression.sign:
        way = np.float64(regression.sign)
        value = graph("Mul", way, graph("Relu", graph("Mul", way, value)))
    if regression.dead_band <= 0:
        return value
    beyond = graph("Less", graph("Abs", value), np.float64(regression.dead_band))
    return graph("Where", beyond, np.float64(0.0), value)


def _column(graph: OnnxGraph, column: Column, parent: str, after: str, child: str) -> str:
    """See `Column`."""
    if column.source in ("parent", "child"):
        value = graph.columns(after if column.source == "parent" else child, [column.index])
        return value if column.view == "plain" else graph("Cos" if column.view == "cos" else "Sin", value)
    if column.source == "parent_change":
        delta = graph("Sub", graph.columns(after, [column.index]), graph.columns(parent, [column.index]))
        return graph.wrapped(delta) if column.wrap else delta
    if column.source == "aligned_change":
        assert column.alignment is not None
        moved = graph("Sub", _place(graph, column.alignment, after), _place(graph, column.alignment, parent))
        return graph.columns(moved, [column.index])
    if column.source not in ("received", "mixing"):
        raise InputError(f"an effect of {column.source} can't be written as ONNX")
    left = graph("Sub", graph.columns(parent, [column.index]), graph.columns(after, [column.index]))
    back = graph("Less", left, np.float64(-LEARNING.clear * column.floor))
    received = graph("Where", back, np.float64(0.0), left)
    if column.source == "received":
        return received
    theirs, amount, own = column.mixes
    total = graph("Add", graph("Relu", graph.columns(child, [amount])), graph("Relu", received))
    squared = graph("Add", graph("Mul", total, total), np.float64((LEARNING.faint * column.floor) ** 2 + 1e-24))
    share = graph("Min", graph("Div", graph("Mul", received, total), squared), np.float64(1.0))
    return graph("Mul", share, graph("Sub", graph.columns(after, [theirs]), graph.columns(child, [own])))


def _place(graph: OnnxGraph, alignment: Alignment, parent: str) -> str:
    """See `Alignment.place`."""
    place = graph("MatMul", graph.columns(parent, alignment.parent.indices), alignment.turn.T)
    if alignment.angles:
        angles = graph.columns(parent, alignment.angles)
        circular = graph.join([graph("Cos", angles), graph("Sin", angles)])
        place = graph("Add", place, graph("MatMul", circular, alignment.sway.T))
    return graph("Add", place, alignment.shift)


def _status_input(graph: OnnxGraph, item: StatusInput, states: dict[str, str]) -> str:
    """See `StatusInput`."""
    if isinstance(item, ValueInput):
        value = graph.columns(states[item.obj], [item.index])
        return graph.wrapped(graph("Sub", value, np.float64(item.middle))) if item.angle else value
    if isinstance(item, PlaceInput):
        return graph("MatMul", graph.columns(states[item.obj], item.group.indices), item.turn)
    if isinstance(item, RelativeInput):
        parent, child = states[item.edge.parent], states[item.edge.child]
        place = _place(graph, item.alignment, parent)
        away = graph("Sub", graph.columns(child, item.alignment.child.indices), place)
        return graph("MatMul", away, item.alignment.turn)
    if not isinstance(item, DifferenceInput):
        raise InputError(f"a status that looks at {type(item).__name__} can't be written as ONNX")
    delta = graph(
        "Sub", graph.columns(states[item.child], [item.index[1]]), graph.columns(states[item.parent], [item.index[0]])
    )
    return graph.wrapped(delta) if item.angle else delta
