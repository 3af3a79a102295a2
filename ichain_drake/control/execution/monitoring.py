"""What an execution compares: readings with what can be brought back, with the goal, and with what was predicted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ichain_drake.control.planning.goals import gap, surely, value_of, words
from ichain_drake.control.planning.plan import Goal, PlanStep, States
from ichain_drake.control.settings import EXECUTION, PLANNING
from ichain_drake.learning.model import InteractionModel
from ichain_drake.learning.settings import LEARNING
from ichain_drake.rules import enabled


def gone(model: InteractionModel, reading: States) -> str:
    """Which object is where nothing brings it back from (it fell, say), in words; empty if there is none.

    Args:
        model: the learned graph.
        reading: measured states, shape (n_variables,) each.
    """
    for name in model.passive:
        low, high = model.low[name], model.high[name]
        for i, v in enumerate(model.graph.objects[name].observable.variables):
            away = max(low[i] - reading[name][i], reading[name][i] - high[i])
            most = EXECUTION.gone * max(high[i] - low[i], EXECUTION.narrow)
            if v.role is not None and v.role.kind == "position" and away > most:
                return f"{name} is gone: its {v.name} is {reading[name][i]:.4g} {v.unit}; start again"
    return ""


def unmet(model: InteractionModel, goal: Goal, states: States, readings: int = LEARNING.look) -> str:
    """Which condition of a goal does not hold, or not surely, in words; empty if all hold.

    Args:
        model: the learned graph.
        goal: what is wanted.
        states: measured, means of readings, shape (n_variables,) each.
        readings: how many each is the mean of: the more there are, the less a goal has to hold by.
    """
    for c in goal.conditions:
        value = float(value_of(c, states, model.graph))
        if gap(c, value) > 0:
            return f"{words(c, model.graph)} does not hold: it is {value:.4g}"
        if gap(surely(c, model, readings), value) > 0:
            return f"{words(c, model.graph)} holds by less than readings can tell: it is {value:.4g}"
    for e in goal.inactive:
        if float(model.decide(e, states)) >= 0:
            return f"{e.name} is still active"
    for e in goal.active:
        if float(model.decide(e, states)) < 0:
            return f"{e.name} is not active"
    return ""


def asked(model: InteractionModel, goal: Goal, now: States) -> Goal:
    """A goal as it is asked of a planner: what holds already is to hold by as much as `unmet` wants in the end.

    Else what holds by less than readings can tell is done to the planner, and unmet as soon as it has planned nothing.

    Args:
        model: the learned graph, with the noise of this run.
        goal: what is wanted.
        now: measured states, shape (n_variables,) each.
    """
    conditions = (surely(c, model) if gap(c, value_of(c, now, model.graph)) == 0 else c for c in goal.conditions)
    return replace(goal, conditions=tuple(conditions))


def deviation(model: InteractionModel, step: PlanStep, now: States) -> str:
    """What is not as predicted at a step's end, in words; empty if all is.

    Args:
        model: the learned graph.
        step: that has been done.
        now: measured states, shape (n_variables,) each.
    """
    if not enabled("deviation"):
        return ""
    # How far what is moved goes follows from the driven variable under feedback; no number was ever meant.
    on_the_way = {e.child for e in step.chain[:-1]} if step.motion is not None else set()
    for name, dynamics in model.passive.items():
        space = model.graph.objects[name].observable
        if name not in step.predicted or name in on_the_way:
            continue
        off = np.abs(space.difference(now[name], step.predicted[name]))
        width = model.high[name] - model.low[name]
        for i, v in enumerate(space.variables):
            if dynamics.variables[i].kind != "hold" or v.kind in ("binary", "integer"):
                continue
            pose = v.role is not None and v.role.kind in ("position", "orientation")
            allowed = max(
                (LEARNING.near if pose else EXECUTION.value) * width[i], LEARNING.surely * model.noise[name][i]
            )
            if off[i] > allowed:
                return (
                    f"{name}.{v.name} is {now[name][i]:.3g} where {step.predicted[name][i]:.3g} was predicted "
                    f"after {step.chain[-1].name}"
                )
    return ""


def undriven(model: InteractionModel, step: PlanStep, began: States, now: States) -> bool:
    """Whether what a step should drive hardly changed: the last interaction of its chain was not active after all.

    Args:
        model: the learned graph.
        step: that has been done.
        began: measured states when it began, shape (n_variables,) each.
        now: measured states, shape (n_variables,) each.
    """
    if step.until is None or not began:
        return False
    target, name, direction, value = step.until
    i = model.graph.objects[target].observable.index(name)
    change = direction * (now[target][i] - began[target][i])
    return bool(change < PLANNING.hardly * direction * (value - began[target][i]))
