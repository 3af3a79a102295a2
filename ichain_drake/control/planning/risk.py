"""How likely a plan is to succeed, by what its learned models say of themselves, and what it costs.

Risk and time are one cost: the expected time until success, where what fails is noticed at its end and tried again, so
that an option of probability p takes 1 / p tries in the mean.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.special import ndtr

from ichain_drake.control.planning.goals import value_of
from ichain_drake.control.planning.plan import Condition, Goal, PlanStep
from ichain_drake.learning.model import InteractionModel

_LEAST = 1e-3  # probability: less is known to no model here, and would make costs infinite


def success_probability(model: InteractionModel, goal: Goal, steps: Sequence[PlanStep]) -> float:
    """Probability that a plan, carried out, ends with the goal's conditions met.

    What fails, a step or the goal at the end, is noticed and tried once more. Further tries, which execution makes, are
    not counted: what failed twice will have a reason that a third time has, too. Steps count as independent of each
    other, and so do conditions.

    Args:
        model: the learned graph.
        goal: what is wanted.
        steps: of the plan.
    """
    tried = [*(s.probability for s in steps), goal_probability(model, goal, steps)]
    return math.prod(p + (1.0 - p) * p for p in tried)


def goal_probability(model: InteractionModel, goal: Goal, steps: Sequence[PlanStep]) -> float:
    """Probability that the goal's conditions hold after steps that all work; arguments as above."""
    return float(math.prod(_holds(model, c, steps) for c in goal.conditions))


def step_cost(step: PlanStep) -> float:
    """Expected time of a step until it works [ticks]."""
    return step.ticks / max(step.probability, _LEAST)


def plan_cost(model: InteractionModel, goal: Goal, steps: Sequence[PlanStep]) -> float:
    """Expected time of a plan until the goal holds [ticks]; arguments as for `success_probability`."""
    return sum(map(step_cost, steps)) / max(goal_probability(model, goal, steps), _LEAST)


def _holds(model: InteractionModel, condition: Condition, steps: Sequence[PlanStep]) -> float:
    """Probability that a condition on what some step changes holds in the end, by its margin there."""
    last = next((s for s in reversed(steps) if s.chain[-1].child == condition.object), None)
    if last is None:
        return 1.0
    obj, value = condition.object, float(value_of(condition, steps[-1].predicted, model.graph))
    i = model.graph.objects[obj].observable.index(condition.variable)
    # A drive ends under feedback: what is left open is a tick of it, and the readings that say when to stop.
    std = max(float(np.hypot(model.spread(obj, last.chain)[i], model.noise[obj][i])), 1e-12)
    return float(ndtr((value - condition.lower) / std) * ndtr((condition.upper - value) / std))
