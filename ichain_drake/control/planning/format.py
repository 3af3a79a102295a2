"""A plan as text."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ichain_drake.control.planning.plan import NoPlan, Plan, PlanStep, States
from ichain_drake.graph import InteractionGraph
from ichain_drake.timing import TICK

_CHANGED = 5e-3  # of a value or of 1, less is not worth a line


def format_plan(
    plan: Plan | NoPlan, graph: InteractionGraph, start: States | None = None, *, likely: bool = False
) -> str:
    """A plan in lines: for each step its interactions, what is brought where, predicted states and times.

    Args:
        plan: the plan, or why there is none.
        graph: names units.
        start: states at the start; with them the predicted changes of the first step are printed too.
        likely: whether to print how likely each step is.
    """
    if isinstance(plan, NoPlan):
        where = f" (at {plan.edge.name})" if plan.edge is not None else ""
        return f"no plan{where}: {plan.reason}"
    if not plan.steps:
        return "nothing to do: the goal is met"
    lines = [
        f"{count(plan)}, about {plan.ticks} ticks ({plan.ticks * TICK:.0f} s), success {plan.probability:.2f}, "
        f"cost {plan.cost:.0f} ticks{' (none is cheaper)' if plan.optimal else ''}; "
        f"{plan.expansions} states expanded, {plan.rollouts} options simulated"
    ]
    passed, known = 0, start
    for number, step in enumerate(plan.steps, 1):
        chain = "->".join([step.chain[0].parent, *(e.child for e in step.chain)])
        chance = f" (probability {step.probability:.3f} a try)" if likely else ""
        lines.append(f"{number}. {chain}: {_doing(step, graph)}{chance}")
        passed += step.ticks
        lines.append(f"   {step.ticks} ticks, until {passed * TICK:.0f} s{_changes(known, step.predicted, graph)}")
        known = step.predicted
    return "\n".join(lines)


def count(plan: Plan) -> str:
    """Number of a plan's steps in words."""
    return f"{len(plan.steps)} step{'' if len(plan.steps) == 1 else 's'}"


def _doing(step: PlanStep, graph: InteractionGraph) -> str:
    first = step.chain[0].child
    parts = []
    if step.before and step.before != step.wanted:
        parts.append(f"carry {first} to {_values(step.before, first, graph)}")
    carried = {k: v for k, v in step.wanted.items() if step.until is None or k != step.until[:2]}
    if carried:
        parts.append(f"{'turn' if step.before else 'carry'} it to {_values(carried, first, graph)}")
    if step.until is not None:
        obj, variable, direction, value = step.until
        parts.append(f"{'raise' if direction > 0 else 'lower'} {_value(obj, variable, value, graph)}")
    if step.after and step.until is not None:
        parts.append(f"put it at {_values(step.after, first, graph)}")
    if step.release or step.until is None:
        parts.append("let go" if step.release else "hold it")
    return "; ".join(parts)


def _values(values: Mapping[tuple[str, str], float], obj: str, graph: InteractionGraph) -> str:
    return ", ".join(_value("", v, x, graph, obj) for (o, v), x in values.items() if o == obj)


def _value(prefix: str, variable: str, value: float, graph: InteractionGraph, obj: str = "") -> str:
    space = graph.objects[obj or prefix].observable
    unit = space.variables[space.index(variable)].unit
    name = f"{prefix}.{variable} to" if prefix else variable
    return f"{name} {value:.3g}{'' if unit == '1' else ' ' + unit}"


def _changes(before: States | None, after: States, graph: InteractionGraph) -> str:
    if before is None:
        return ""
    parts = []
    for name in graph.objects:
        if name in graph.roots or name not in before or name not in after:
            continue
        space = graph.objects[name].observable
        delta = np.abs(space.difference(after[name], before[name]))
        for i in np.flatnonzero(delta > _CHANGED * np.maximum(1.0, np.abs(before[name]))):
            v = space.variables[i]
            parts.append(
                f"{name}.{v.name} {before[name][i]:.3g} -> {after[name][i]:.3g}{'' if v.unit == '1' else ' ' + v.unit}"
            )
    return ": " + ", ".join(parts) if parts else ""
