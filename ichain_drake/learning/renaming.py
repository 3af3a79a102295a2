"""What was learned about an interaction in one graph, under the names of another graph's objects."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.status.customary import Customary
from ichain_drake.learning.status.events import EdgeExamples, Switching
from ichain_drake.learning.status.inputs import (
    DifferenceInput,
    PlaceInput,
    RelativeInput,
    StatusInput,
    ValueInput,
    objects_of,
)
from ichain_drake.learning.tick import LearnedInteraction
from ichain_drake.state import FloatArray


def seen_by(learned: LearnedInteraction) -> set[str]:
    """Objects whose states decide the status of an interaction."""
    return {obj for item in learned.status.inputs for obj in objects_of(item)}


def renamed(learned: LearnedInteraction, names: Mapping[str, str], graph: InteractionGraph) -> LearnedInteraction:
    """The same interaction between other objects; its predictions are the same to the last bit.

    Customary conditions on objects that have no counterpart are left out, and so are such objects in its examples.

    Args:
        learned: from another graph.
        names: of its objects' counterparts, by their names there; all that `seen_by` tells, and both ends.
        graph: that has the counterparts.
    """
    status = replace(learned.status, inputs=tuple(_input(i, names, graph) for i in learned.status.inputs))
    examples = learned.examples
    return replace(
        learned,
        status=status,
        customary=_customary(learned.customary, names, graph),
        examples=EdgeExamples(
            _switching(examples.activations, names),
            _switching(examples.deactivations, names),
            _states(examples.active, names),
            _states(examples.inactive, names),
        ),
    )


def _input(item: StatusInput, names: Mapping[str, str], graph: InteractionGraph) -> StatusInput:
    if isinstance(item, RelativeInput):
        edge = Interaction(names[item.edge.parent], names[item.edge.child])
        return replace(item, edge=edge, label=f"position of {edge.child} relative to {edge.parent}")
    if isinstance(item, PlaceInput):
        obj = names[item.obj]
        return replace(item, obj=obj, label=f"position of {obj}")
    if isinstance(item, ValueInput):
        obj = names[item.obj]
        return replace(item, obj=obj, label=f"{obj}.{_variable(graph, obj, item.index)}")
    parent, child = names[item.parent], names[item.child]
    first, second = _variable(graph, parent, item.index[0]), _variable(graph, child, item.index[1])
    return DifferenceInput(parent, child, item.index, item.angle, f"{child}.{second} - {parent}.{first}")


def _variable(graph: InteractionGraph, obj: str, index: int) -> str:
    return graph.objects[obj].observable.names[index]


def _customary(customary: Customary, names: Mapping[str, str], graph: InteractionGraph) -> Customary:
    low, high, inputs, start = [np.zeros(0)], [np.zeros(0)], [], 0
    for item in customary.inputs:
        width = _width(item)
        if all(obj in names for obj in objects_of(item)):
            inputs.append(_input(item, names, graph))
            low.append(customary.low[start : start + width])
            high.append(customary.high[start : start + width])
        start += width
    return Customary(tuple(inputs), np.concatenate(low), np.concatenate(high))


def _width(item: StatusInput) -> int:
    """Number of an input's columns."""
    if isinstance(item, RelativeInput):
        return len(item.alignment.parent.indices)
    return item.turn.shape[1] if isinstance(item, PlaceInput) else 1


def _switching(events: Switching, names: Mapping[str, str]) -> Switching:
    return replace(events, before=_states(events.before, names), after=_states(events.after, names))


def _states(states: Mapping[str, FloatArray], names: Mapping[str, str]) -> dict[str, FloatArray]:
    return {names[n]: values for n, values in states.items() if n in names}
