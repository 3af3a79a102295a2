"""Goal expressions: what a user wants of variables of objects, as text."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ichain_drake.control.planning.frames import Frames
from ichain_drake.control.planning.goal_text import Bound, check_goal_text, read_goal_text
from ichain_drake.control.planning.model import conserved, keeps, span
from ichain_drake.control.planning.plan import Condition, Goal, NoPlan, States
from ichain_drake.control.settings import PLANNING
from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.model import InteractionModel
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import FloatArray


def parse_goal(expressions: Sequence[str], model: InteractionModel, start: States | None = None) -> Goal:
    """Read goal expressions.

    Args:
        expressions: such as `thing.level >= 0.6` or `not robot->thing`; see `goal_text`. Values are in the variable's
            unit; `start` in place of one stands for the value at the start, and `keep object.variable within value` for
            a range about it. Several on one variable narrow its range.
        model: knows graph, ranges and noise.
        start: states at the start, shape (n_variables,) each.

    Returns:
        The goal. An equality becomes a range of a fiftieth of the demonstrated range, or four times the noise, to
        either side.

    Raises:
        InputError: on another form, an unknown object, variable or interaction, a value that is no number, a range
            that is empty, or no expression at all.
    """
    check_goal_text(expressions, model.graph)
    ranges: dict[tuple[str, str], tuple[float, float]] = {}
    active: list[Interaction] = []
    inactive: list[Interaction] = []
    for text in expressions:
        clauses = read_goal_text(text, model.graph)
        active += clauses.active
        inactive += clauses.inactive
        for bound in clauses.bounds:
            lower, upper = _range(bound, text, model, start)
            low, high = ranges.get((bound.object, bound.variable), (-math.inf, math.inf))
            low, high = max(low, lower), min(high, upper)
            if low > high:
                name = f"{bound.object}.{bound.variable}"
                raise InputError(f"goal {text!r}: no value of {name} is in all the ranges given; widen one")
            ranges[bound.object, bound.variable] = (low, high)
    for edge in active:
        if edge in inactive:
            raise InputError(f"goal: {edge.name} can't be both active and not; leave one out")
    conditions = tuple(Condition(o, v, low, high) for (o, v), (low, high) in ranges.items())
    return Goal(conditions, tuple(dict.fromkeys(inactive)), tuple(dict.fromkeys(active)))


def _range(bound: Bound, text: str, model: InteractionModel, start: States | None) -> tuple[float, float]:
    """Lowest and highest value that a bound allows."""
    index = model.graph.objects[bound.object].observable.index(bound.variable)
    if bound.value is None or bound.sign == "within":
        if start is None:
            raise InputError(f"goal {text!r}: this needs the states at the start; give a number")
        now = float(start[bound.object][index])
    value = now if bound.value is None else bound.value
    if bound.sign == "within":
        return now - value, now + value
    if bound.sign == "==":
        slack = _slack(model, bound.object, index)
        return value - slack, value + slack
    # More than a value is from the next number on.
    if bound.sign in (">=", ">"):
        return (value if bound.sign == ">=" else math.nextafter(value, math.inf)), math.inf
    return -math.inf, (value if bound.sign == "<=" else math.nextafter(value, -math.inf))


def _slack(model: InteractionModel, obj: str, index: int) -> float:
    if model.graph.objects[obj].observable.variables[index].kind in ("binary", "integer"):
        return 0.0
    return float(max(PLANNING.same * span(model, obj)[index], LEARNING.surely * model.noise[obj][index]))


def stay(
    start: States, obj: str, variables: Sequence[str], model: InteractionModel, slack: float
) -> tuple[Condition, ...]:
    """Conditions that keep or bring back variables of an object to where they are at the start.

    Args:
        start: states at the start, shape (n_variables,) each.
        obj: the object.
        variables: names.
        model: knows the state spaces.
        slack: to either side, in the variables' unit.
    """
    space = model.graph.objects[obj].observable
    values = [float(start[obj][space.index(v)]) for v in variables]
    return tuple(Condition(obj, v, x - slack, x + slack) for v, x in zip(variables, values, strict=True))


def value_of(condition: Condition, states: Mapping[str, FloatArray], graph: InteractionGraph) -> FloatArray:
    """Value of a condition's variable, shape (...), from states of shape (..., n_variables)."""
    return states[condition.object][..., graph.objects[condition.object].observable.index(condition.variable)]


def gap(condition: Condition, value: FloatArray | float) -> FloatArray:
    """How far values are from the wanted range, shape (...), in the variable's unit; 0 inside."""
    return np.maximum(np.maximum(condition.lower - np.asarray(value), np.asarray(value) - condition.upper), 0.0)


def words(condition: Condition, graph: InteractionGraph) -> str:
    """A condition as it would be written, with its unit."""
    space = graph.objects[condition.object].observable
    unit = space.variables[space.index(condition.variable)].unit
    name, tail = f"{condition.object}.{condition.variable}", "" if unit == "1" else f" {unit}"
    if math.isinf(condition.upper):
        return f"{name} >= {condition.lower:.4g}{tail}"
    if math.isinf(condition.lower):
        return f"{name} <= {condition.upper:.4g}{tail}"
    return f"{condition.lower:.4g} <= {name} <= {condition.upper:.4g}{tail}"


def impossible(goal: Goal, model: InteractionModel, start: States) -> NoPlan | None:
    """Why no plan can meet a goal, seen without any search; None where one might.

    A condition that already holds is never refused.
    """
    for c in goal.conditions:
        space = model.graph.objects[c.object].observable
        i, now = space.index(c.variable), float(value_of(c, start, model.graph))
        if gap(c, now) == 0:
            continue
        name, variable = f"{c.object}.{c.variable}", space.variables[i]
        incoming = model.graph.incoming(c.object)
        acting = [e for e in incoming if any(f.variable == i for f in model.edges[e].effects)]
        if not incoming:
            return NoPlan(c, now, None, f"{words(c, model.graph)}: {c.object} is the robot; no interaction controls it")
        if not acting:
            edges = ", ".join(e.name for e in incoming)
            return NoPlan(
                c,
                now,
                None,
                f"{words(c, model.graph)}: no interaction was seen to change {name} (those that act: {edges})",
            )
        low, high = _limits(model, c.object, i)
        if c.lower > high or c.upper < low:
            near = high if c.lower > high else low
            bounded = math.isfinite(variable.upper if c.lower > high else variable.lower)
            why = "is bounded there" if bounded else "was never beyond that in a demonstration"
            return NoPlan(
                c, near, acting[0], f"{words(c, model.graph)}: {name} goes from {low:.4g} to {high:.4g} and {why}"
            )
    return _too_much(goal, model, start)


def _too_much(goal: Goal, model: InteractionModel, start: States) -> NoPlan | None:
    """Refuse a goal that needs more of a conserved amount than there is."""
    for group in conserved(model):
        names = [(o, model.graph.objects[o].observable.names[i]) for o, i in group]
        wanted = [c for c in goal.conditions if (c.object, c.variable) in names and c.lower > 0]
        there = sum(max(float(start[o][i]), 0.0) for o, i in group)
        slack = LEARNING.surely * float(np.sqrt(sum(float(model.noise[o][i]) ** 2 for o, i in group)))
        unmet = [c for c in wanted if gap(c, value_of(c, start, model.graph)) > 0]
        if unmet and sum(c.lower for c in wanted) > there + slack:
            c = unmet[0]
            rest = there - sum(other.lower for other in wanted if other is not c)
            index = model.graph.objects[c.object].observable.index(c.variable)
            acting = [
                e for e in model.graph.incoming(c.object) if any(f.variable == index for f in model.edges[e].effects)
            ]
            givers = [e for e in acting if any(e.parent == o for o, _ in group)] or acting
            what = " and ".join(words(x, model.graph) for x in wanted)
            return NoPlan(
                c,
                max(rest, 0.0),
                givers[0],
                f"{what}: there is only {there:.4g} in all of {', '.join(o for o, _ in names)}",
            )
    return None


def _limits(model: InteractionModel, obj: str, i: int) -> tuple[float, float]:
    """The declared bounds where there are any, or as far as it is taken, or a little more than shown."""
    variable = model.graph.objects[obj].observable.variables[i]
    more = LEARNING.near * float(span(model, obj)[i]) + LEARNING.surely * float(model.noise[obj][i])
    low = variable.lower if math.isfinite(variable.lower) else float(model.low[obj][i]) - more
    high = variable.upper if math.isfinite(variable.upper) else float(model.high[obj][i]) + more
    reach = Frames(model).reach(obj)
    if reach is None or not np.isfinite(reach[0][i]):
        return low, high
    return min(low, float(reach[0][i])), max(high, float(reach[1][i]))


def kept_by_itself(model: InteractionModel, condition: Condition) -> bool:
    """Whether the variable of a condition keeps its value once nothing acts on it."""
    index = model.graph.objects[condition.object].observable.index(condition.variable)
    return bool(keeps(model, condition.object)[index])


def surely(condition: Condition, model: InteractionModel, readings: int = LEARNING.look) -> Condition:
    """A condition that holds by as much as the mean of some readings can tell: when a goal counts as reached."""
    return inside(condition, model, LEARNING.sure / math.sqrt(readings))


def inside(condition: Condition, model: InteractionModel, noises: float, share: float = 0.0) -> Condition:
    """A condition that is met by a margin, where its range and the variable's bounds leave room.

    Args:
        condition: to be met.
        model: knows noise and demonstrated ranges.
        noises: of a reading, that the margin has at least.
        share: of the demonstrated range, the same.
    """
    space = model.graph.objects[condition.object].observable
    i = space.index(condition.variable)
    wide = max(noises * float(model.noise[condition.object][i]), share * float(span(model, condition.object)[i]))
    margin = min(wide, LEARNING.slight * (condition.upper - condition.lower))
    low, high = condition.lower + margin, condition.upper - margin
    variable = space.variables[i]
    return replace(
        condition,
        lower=min(low, max(variable.upper, condition.lower)),
        upper=max(high, min(variable.lower, condition.upper)),
    )
