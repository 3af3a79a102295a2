"""What a plan over an interaction graph is made of (paper sec. V, VI and appendix B)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from ichain_drake.control.planning.motion import Motion
from ichain_drake.graph import Interaction
from ichain_drake.state import FloatArray

States = Mapping[str, FloatArray]
"""Observable state of every object and the robot, by name."""


@dataclass(frozen=True)
class Condition:
    """A wanted range of one variable.

    Attributes:
        object, variable: which.
        lower, upper: the range, in the variable's unit; infinite where open.
    """

    object: str
    variable: str
    lower: float
    upper: float


@dataclass(frozen=True)
class Goal:
    """What is wanted: ranges of variables, all at once.

    Attributes:
        conditions: the ranges.
        inactive: interactions that must not be active in the end (the hand is away).
        active: interactions that must be.
    """

    conditions: tuple[Condition, ...]
    inactive: tuple[Interaction, ...] = ()
    active: tuple[Interaction, ...] = ()


@dataclass(frozen=True)
class PlanStep:
    """One option: activate a chain of interactions, drive its last object, deactivate.

    Attributes:
        chain: interactions from the robot on that are active during the drive; the first is activated by a skill, the
            others become active on the way.
        wanted: values that variables of objects of the chain are brought to, as (object, variable) -> value: either
            of the first object (it is carried there) or of the last one (it is driven until there, or until it stops
            changing).
        until: the variable of the last object that is driven, with the direction (+1, -1) and the value predicted at
            the end; None for a step that only carries the first object somewhere.
        hold: robot state that the drive holds or approaches. Where the first object is carried it belongs to the grasp
            of a demonstration: what counts is where the object is, `wanted`.
        before: values that variables of a carried first object are brought to before the drive, and again after it;
            empty where nothing is driven.
        after: values that they are brought to in the end, where the object is let go.
        release: whether the first interaction is deactivated at the end.
        predicted: states predicted at the end.
        ticks: predicted duration.
        motion: of the robot by which the variable is driven; None where it holds still.
        variant: which way of doing it: each failure of an option makes the next try another one.
        probability: that its interactions become active as predicted, by the calibrated status models.
    """

    chain: tuple[Interaction, ...]
    wanted: Mapping[tuple[str, str], float] = field(default_factory=dict)
    until: tuple[str, str, int, float] | None = None
    hold: FloatArray | None = None
    before: Mapping[tuple[str, str], float] = field(default_factory=dict)
    after: Mapping[tuple[str, str], float] = field(default_factory=dict)
    release: bool = True
    predicted: States = field(default_factory=dict)
    ticks: int = 0
    motion: Motion | None = None
    variant: int = 0
    probability: float = 1.0


@dataclass(frozen=True)
class Plan:
    """A sequence of steps with what the learned models predict of it.

    Attributes:
        steps: in order.
        ticks: predicted duration.
        expansions, rollouts: effort of the search.
        seconds: duration of the search [s].
        cautious: interactions that it uses only as they were shown, beside what their classifiers ask for.
        probability: of success as predicted: that all steps work, and their spread leaves the goal's conditions met,
            at the first or the second try.
        cost: expected time until the goal holds, where what fails is tried again [ticks].
        optimal: whether no cheaper one is possible with the options that were found; see `OptimalSearch`.
    """

    steps: tuple[PlanStep, ...]
    ticks: int
    expansions: int = 0
    rollouts: int = 0
    seconds: float = 0.0
    cautious: tuple[Interaction, ...] = ()
    probability: float = 1.0
    cost: float = 0.0
    optimal: bool = False


@dataclass(frozen=True)
class NoPlan:
    """Why there is no plan.

    Attributes:
        condition: the one that could not be met.
        closest: the nearest value that the search found for its variable.
        edge: the interaction at which it failed; None where no interaction acts on the object.
        reason: in words.
        tree: what was tried for each condition, in indented lines; empty where nothing had to be tried to see it.
    """

    condition: Condition
    closest: float
    edge: Interaction | None
    reason: str
    tree: tuple[str, ...] = ()
