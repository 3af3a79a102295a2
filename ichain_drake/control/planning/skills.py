"""Skills: paths of the robot that activate or deactivate one of its interactions (paper sec. V, appendix B).

A learned skill is a demonstrated switching event with the few ticks before and after it, which carry the direction of
the approach and of the retreat. It is moved with the object through the learned alignment, and of all events that one
is taken which the learned classifier is surest about.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ichain_drake.control.planning.frames import Frames
from ichain_drake.control.planning.plan import States
from ichain_drake.control.planning.travel import jumping
from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction
from ichain_drake.learning.model import InteractionModel
from ichain_drake.learning.settings import LEARNING
from ichain_drake.learning.status.events import SwitchingWindow, Windows
from ichain_drake.state import FloatArray

SkillFunction = Callable[[States, int], FloatArray]
"""A designer's own skill: states now, shape (n_variables,) each, and the number of the attempt -> robot states to pass,
shape (n, n_root)."""

OwnSkills = Mapping[tuple[Interaction, bool], SkillFunction]
"""A designer's own skills, by interaction and whether they activate."""


@dataclass(frozen=True, eq=False)
class Skills:
    """How the robot's interactions are activated and deactivated.

    Attributes:
        activations, deactivations: demonstrated events of each interaction of the robot.
        own: functions in place of what was learned, by interaction and whether they activate.
    """

    activations: Windows
    deactivations: Windows
    own: OwnSkills = field(default_factory=dict)

    @classmethod
    def of(cls, model: InteractionModel, own: OwnSkills | None = None) -> Skills:
        """Those that a model's demonstrations show.

        Args:
            model: the learned graph.
            own: a designer's functions in place of learned skills.

        Raises:
            InputError: if a function is for something that is no interaction of the robot.
        """
        mine = [e for e in model.graph.interactions if model.graph.by_robot(e)]
        for edge, _ in own or {}:
            if edge not in mine:
                raise InputError(
                    f"a skill is given for {edge.name}; skills belong to the robot's own interactions, "
                    f"{', '.join(e.name for e in mine)}"
                )
        return cls(model.activations, model.deactivations, dict(own or {}))

    def path(
        self,
        model: InteractionModel,
        edge: Interaction,
        activate: bool,
        states: States,
        attempt: int,
        prefer: FloatArray | None = None,
        first: int = 0,
    ) -> FloatArray:
        """Robot states to pass, shape (n, n_root), that should switch an interaction.

        Args:
            model: the learned graph.
            edge: an interaction of the robot.
            activate: or deactivate.
            states: now, shape (n_variables,) each; the robot's is its last command.
            attempt: number of the attempt, from 0; each takes another event.
            prefer: robot state in which the object should be taken, or let go of, shape (n_root,); None for any.
            first: rank of the event that the first attempt takes: the surest one, or the next after a failure.

        Raises:
            InputError: if no such event was demonstrated and no function is given.
        """
        if (edge, activate) in self.own:
            return np.asarray(self.own[edge, activate](states, attempt), dtype=float)
        windows = (self.activations if activate else self.deactivations).get(edge, ())
        if not windows:
            what = "activated" if activate else "deactivated"
            raise InputError(
                f"{edge.name}: it is {what} in no demonstration; add a piece, or give a function as a skill"
            )
        paths = [_moved(model, edge, w, states, activate, here=prefer is not None) for w in windows]
        order = _ranking(model, edge, windows, paths, states, activate, prefer)
        return paths[order[(first + _spread(attempt, len(order))) % len(order)]]


def _spread(attempt: int, count: int) -> int:
    """First the best, then ever others: 0, a third, two thirds, one, ..."""
    return 0 if attempt == 0 else (attempt * max(1, count // 4) + attempt // 4) % count


def _moved(
    model: InteractionModel, edge: Interaction, window: SwitchingWindow, states: States, activate: bool, *, here: bool
) -> FloatArray:
    """A window's path for the present states: relative to the object where its place matters.

    What is let go of `here` is let go of where the robot is, whether it is known how the object's place goes with it.
    """
    frames = Frames(model)
    path, relative = window.root.copy(), frames.goes_with(edge)
    if not relative and (activate or not here):
        return path if activate else path[max(window.event - 1, 0) :]
    if activate:
        return frames.along(edge.parent, path, edge.child, window.child, states[edge.child]) if relative else path
    # Away from where the robot is now: its grasp differs from the demonstrated one.
    last = max(window.event - 1, 0)
    kinds = model.graph.objects[edge.parent].observable.variables
    real = np.array([v.kind not in ("binary", "integer") for v in kinds])
    space = model.graph.objects[edge.parent].observable
    moved = states[edge.parent] + space.difference(path[last:], path[last])
    return np.where(real, moved, path[last:])[1:]


def _ranking(
    model: InteractionModel,
    edge: Interaction,
    windows: Sequence[SwitchingWindow],
    paths: Sequence[FloatArray],
    states: States,
    activate: bool,
    prefer: FloatArray | None = None,
) -> list[int]:
    """Events in order of how sure the classifier is that the wanted status results, or of how near it leads."""
    root = model.graph.root
    ends = np.array([p[-1] for p in paths])
    batch = {n: np.repeat(np.asarray(states[n], dtype=float)[None], len(ends), axis=0) for n in model.graph.objects}
    batch[root] = ends
    if not activate:
        # Opened and closed again at once the hand has not left: what was shown whole comes first.
        left = np.array([len(w.root) - w.event for w in windows])
        return [int(k) for k in np.lexsort((model.decide(edge, batch), left < min(LEARNING.ticks + 1, left.max())))]
    # The object goes along once it is taken, so the row of the event itself is judged.
    batch[root] = np.array([p[min(w.event, len(p) - 1)] for p, w in zip(paths, windows, strict=True)])
    sure = model.decide(edge, batch)
    # An object that has to be switched (a level) is not yet so: the demonstrated one right after the event counts too.
    low, high = model.low[root], model.high[root]
    outside = ((ends < low - 1e-9) | (ends > high + 1e-9)).sum(axis=1)
    if prefer is not None:
        space = model.graph.objects[root].observable
        off = np.abs(space.difference(batch[root], prefer)) / np.maximum(model.step_limit[root], 1e-9)
        return [int(k) for k in np.lexsort((off[:, ~jumping(space)].max(axis=1), outside, sure < 0.0))]
    return [int(k) for k in np.lexsort((-sure, outside))]
