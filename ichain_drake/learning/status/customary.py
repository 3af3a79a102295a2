"""Customary conditions: what always held while an interaction was active, without being known to matter.

A demonstration can't show what its world refuses: by contact no piece has a hand at food behind a shut door, so that
the classifier of hand and food finds nothing about the door. But in every piece in which the food is handled the door
stands open, and in the same pieces it also stands elsewhere. Such a condition may matter or be chance. So it is no
part of the classifier: a planner asks for it only once an interaction has failed although its classifier saw no reason
("do it as it was shown").
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields

import numpy as np

from ichain_drake.graph import Interaction
from ichain_drake.learning.data import GraphData
from ichain_drake.learning.effects.alignment import Alignment
from ichain_drake.learning.settings import LEARNING
from ichain_drake.learning.status.candidates import input_noise
from ichain_drake.learning.status.choice import Candidate
from ichain_drake.learning.status.inputs import (
    PlaceInput,
    RelativeInput,
    States,
    StatusInput,
    candidate_inputs,
    objects_of,
)
from ichain_drake.learning.status.status import StatusModel, input_choice
from ichain_drake.state import FloatArray


@dataclass(frozen=True)
class Customary:
    """Ranges of inputs in which an interaction was always shown.

    Attributes:
        inputs: of the child's other parents but the robot; may be empty.
        low, high: ranges of the inputs' columns, shape (n_columns,).
    """

    inputs: tuple[StatusInput, ...]
    low: FloatArray
    high: FloatArray

    @property
    def labels(self) -> tuple[str, ...]:
        """What is looked at, for reports."""
        return tuple(i.label for i in self.inputs)

    def fits(self, states: States) -> bool:
        """Whether each column of the inputs has a range, for states of shape (n, n_variables)."""
        shape = (sum(i(states).shape[1] for i in self.inputs),)
        return self.low.shape == shape == self.high.shape and bool((self.low < self.high).all())

    def decide(self, states: States) -> FloatArray:
        """Decision values, shape (n,), from states of shape (n, n_variables): >= 0 within all ranges, at most 1."""
        if not self.inputs:
            return np.ones(len(next(iter(states.values()))))
        columns = np.hstack([i(states) for i in self.inputs])
        middle, half = 0.5 * (self.low + self.high), 0.5 * (self.high - self.low)
        return np.asarray((1.0 - np.abs(columns - middle) / half).min(axis=1))


@dataclass(frozen=True)
class CautiousStatus(StatusModel):
    """A classifier that also asks for the customary conditions.

    Attributes:
        customary: see there.
    """

    customary: Customary

    @classmethod
    def of(cls, status: StatusModel, customary: Customary) -> CautiousStatus:
        """The same classifier with conditions."""
        return cls(**{f.name: getattr(status, f.name) for f in fields(StatusModel)}, customary=customary)

    def decide(self, states: States) -> FloatArray:
        """Decision values, shape (n,)."""
        return np.minimum(super().decide(states), self.customary.decide(states))


def learn_customary(
    data: GraphData,
    edge: Interaction,
    alignments: Mapping[Interaction, Alignment | None],
    status: StatusModel,
    noise: Mapping[str, FloatArray],
) -> Customary:
    """The customary conditions of an interaction.

    They are about what lies still while the robot works: where the robot is no end, the child's own place if the
    classifier doesn't look at it; else states of the child's other parents, but not of the robot. Only what by itself
    tells rows in which the interaction is inactive counts, and what the classifier looks at already is left out.

    Args:
        data: the pieces.
        edge: the interaction.
        alignments: of all interactions.
        status: its classifier.
        noise: measurement noise per object, shape (n_variables,).
    """
    truth = data.flag(edge)
    states = {n: data.stacked(n) for n in (edge.child, *data.graph.parents(edge.child))}
    known = {i.label for i in status.inputs}
    choice = input_choice(data, edge)
    found: list[StatusInput] = []
    ranges: list[tuple[FloatArray, FloatArray]] = []
    ends, others = candidate_inputs(data, edge, alignments)
    placed = any(isinstance(i, PlaceInput | RelativeInput) and edge.child in objects_of(i) for i in status.inputs)
    if not data.graph.by_robot(edge) and not placed:
        own: list[StatusInput] = [i for i in ends if isinstance(i, PlaceInput) and i.obj == edge.child]
        others = own or others
    for item in others if not truth.all() else ():
        if item.label in known or set(data.graph.roots) & set(objects_of(item)):
            continue
        columns, floor = item(states), input_noise(item, noise)
        if choice.tells(Candidate(item, columns, floor)):
            found.append(item)
            ranges.append(_shown(columns[truth], floor))
    return Customary(tuple(found), *(np.concatenate([[], *side]) for side in _sides(ranges)))


def _sides(ranges: Sequence[tuple[FloatArray, FloatArray]]) -> tuple[list[FloatArray], list[FloatArray]]:
    return [low for low, _ in ranges], [high for _, high in ranges]


def _shown(columns: FloatArray, floor: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Range of each column with some room at both ends, shape (n_columns,) each."""
    low, high = columns.min(axis=0), columns.max(axis=0)
    room = np.maximum(np.maximum(LEARNING.reach * (high - low), LEARNING.surely * floor), 1e-9)
    return low - room, high + room
