"""A step of a plan as tasks: deactivate, activate, carry and drive, deactivate (paper appendix B)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ichain_drake.control.execution.carried import Carried
from ichain_drake.control.execution.carrying import CarryPartTask, CarryTask
from ichain_drake.control.execution.driving import Approach, DriveTask
from ichain_drake.control.execution.following import pose_of
from ichain_drake.control.execution.keep import Keep
from ichain_drake.control.execution.moving import Moving
from ichain_drake.control.execution.switching import Switch
from ichain_drake.control.execution.tasks import Look, Task
from ichain_drake.control.planning.plan import PlanStep, States
from ichain_drake.control.planning.slope import independent
from ichain_drake.graph import Interaction
from ichain_drake.learning.model import InteractionModel
from ichain_drake.learning.settings import LEARNING
from ichain_drake.rules import enabled


def step_tasks(model: InteractionModel, step: PlanStep, now: States, holds: Carried | None = None) -> list[Task]:
    """The tasks of a step.

    Args:
        model: the learned graph.
        step: of a plan.
        now: measured states, shape (n_variables,) each.
        holds: what the robot holds; if that is no part of the step, it is let go of where such a thing may be.
    """
    edge, root = step.chain[0], model.graph.root
    mine = [e for e in model.graph.interactions if e.parent == root and e != edge]
    holds = holds or Carried()
    out: list[Task] = []
    for e in mine:
        if e.child == holds.following or float(model.decide(e, now)) >= 0:
            out += [*(_put_back(model, e, holds) if holds.in_the_air(model, e, now) else []), Switch(e, activate=False)]
    if not step.wanted and not step.before and not step.after and step.until is None:
        if step.release or step.hold is None:
            return [*out, Switch(edge, activate=False), Look(None, LEARNING.look)]
        taken = Switch(edge, activate=True, first=step.variant)
        return [*out, taken, Keep(edge, goal=step.hold), Look(None, LEARNING.look)]
    if step.motion is not None:
        out += [Switch(edge, activate=True, motion=step.motion, first=step.variant), Moving(edge, step=step)]
        # Whatever the classifier says in the end: nothing else tells whether what is geared only while held is free.
        return [*out, Switch(edge, activate=False, forced=True, motion=step.motion), Look(None, LEARNING.look)]
    carried = indices(model, step.wanted, edge, but=step.until)
    goes_along = bool(step.before or step.after or step.until is None)
    before = indices(model, step.before, edge)
    first = carry_tasks(model, edge, before, place_first=True) if before else []
    approach = carry_tasks(model, edge, carried, place_first=True) if goes_along and carried else []
    onward = next(iter([*first, *approach]), None)
    out.append(Switch(edge, activate=True, onward=onward, first=step.variant))
    out += first
    if step.until is None:
        out += approach
    else:
        drive = DriveTask(edge, step=step, goal=None if goes_along or step.hold is None else step.hold)
        out += [Approach(edge, carry=t, drive=drive) for t in approach]
        out.append(drive)
        if step.before:
            out += carry_tasks(model, edge, indices(model, step.before, edge), place_first=False)
    after = indices(model, step.after, edge)
    if after and after != carried:
        out += carry_tasks(model, edge, after, place_first=False)
    if step.release:
        out.append(Switch(edge, activate=False))
    return [*out, Look(None, LEARNING.look)]


def _put_back(model: InteractionModel, edge: Interaction, holds: Carried) -> list[Task]:
    pose = sorted(pose_of(model.graph.objects[edge.child].observable))
    return carry_tasks(model, edge, {i: holds.origin[i] for i in pose}, place_first=False)


def indices(
    model: InteractionModel,
    values: Mapping[tuple[str, str], float],
    edge: Interaction,
    but: Sequence[object] | None = None,
) -> dict[int, float]:
    """Wanted values of an interaction's child by the index of the variable.

    Args:
        model: the learned graph.
        values: by object and variable.
        edge: the interaction.
        but: object and variable to leave out.
    """
    space = model.graph.objects[edge.child].observable
    skip = tuple(but[:2]) if but is not None else None
    return {space.index(v): x for (o, v), x in values.items() if o == edge.child and (o, v) != skip}


def carry_tasks(
    model: InteractionModel, edge: Interaction, target: Mapping[int, float], *, place_first: bool
) -> list[Task]:
    """Carrying in two parts: what is turned is turned at the place where that is wanted, not on the way.

    Turned on the way, a full cup spills. What one motion changes (a drawer's place and its opening) has no parts.

    Args:
        model: the learned graph.
        edge: from the robot to what is carried.
        target: wanted values by the index of the variable.
        place_first: whether to turn at the place of arrival, else where it is.
    """
    space = model.graph.objects[edge.child].observable
    place = {i for i in target if (r := space.variables[i].role) is not None and r.kind == "position"}
    if not enabled("place_first") or not place or place == set(target) or not independent(model, edge, sorted(target)):
        return [CarryTask(edge, target=dict(target))]
    part = {i: x for i, x in target.items() if (i in place) == place_first}
    return [CarryPartTask(edge, target=part, every=tuple(target)), CarryTask(edge, target=dict(target))]


def way_back(model: InteractionModel, step: PlanStep, origin: Mapping[int, float]) -> list[Task]:
    """Put what a step carries where it was taken from, and let go.

    Args:
        model: the learned graph.
        step: that can't be gone on with.
        origin: values of the child's variables where it was taken, by index; may be empty.
    """
    edge = step.chain[0]
    moved = {**indices(model, {**step.wanted, **step.before, **step.after}, edge, but=step.until)}
    target = {i: origin[i] for i in moved if i in origin}
    back = carry_tasks(model, edge, target, place_first=False) if target else []
    return [*back, Switch(edge, activate=False)]
