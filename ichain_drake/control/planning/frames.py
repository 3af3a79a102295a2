"""States re-expressed where other objects are now: what was beside something is beside it again.

Roles say which variables are a position or an orientation in which frame, learned alignments how frames are turned to
each other. What a sample of a demonstration is relative to, the learned status says: if that looks at where the two
ends of an interaction are to each other, the sample holds wherever they are.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import product
from typing import Any

import numpy as np

from ichain_drake.control.settings import PLANNING
from ichain_drake.graph import Interaction
from ichain_drake.learning.effects.alignment import apart, frame_turns, heading_of
from ichain_drake.learning.model import InteractionModel
from ichain_drake.learning.settings import LEARNING
from ichain_drake.rules import enabled
from ichain_drake.state import BoolArray, FloatArray, wrap_angle


class Frames:
    """How the frames of a learned graph lie to each other.

    Args:
        model: the learned graph.
    """

    def __init__(self, model: InteractionModel) -> None:
        self._spaces = {n: s.observable for n, s in model.graph.objects.items()}
        self._edges, self._root, self._roots = model.edges, model.graph.root, model.graph.roots
        self._model = model
        self._known: dict[tuple[str, str], Any] = {}
        alignments = {e: learned.alignment for e, learned in model.edges.items()}
        self._turns = frame_turns(self._spaces, model.graph.root, alignments)

    def is_relative(self, edge: Interaction) -> bool:
        """Whether an interaction's status looks at where its two ends are relative to each other."""
        return bool(self._edges[edge].relative)

    def goes_with(self, edge: Interaction) -> bool:
        """Whether samples of an interaction's parent hold wherever the child is."""
        return self._edges[edge].alignment is not None or self.is_relative(edge)

    def has_place(self, obj: str, variables: Iterable[int]) -> bool:
        """Whether some of an object's variables say where it is."""
        roles = [self._spaces[obj].variables[i].role for i in variables]
        return any(r is not None and r.kind == "position" for r in roles)

    def anchors(self, obj: str) -> tuple[str, ...]:
        """What places of an object are relative to: the other ends of its interactions, but the robot."""
        mine = [
            e for e in self._edges if obj in (e.parent, e.child) and e.parent not in self._roots and self.is_relative(e)
        ]
        return tuple(dict.fromkeys(e.child if e.parent == obj else e.parent for e in mine))

    def is_carried(self, obj: str) -> bool:
        """Whether an object goes along with the robot when that holds it."""
        learned: Any = self._edges.get(Interaction(self._root, obj))
        return learned is not None and learned.alignment is not None

    def beside(self, obj: str, places: FloatArray, by: str, then: FloatArray, now: FloatArray) -> FloatArray:
        """As `along`, for places at which an object stands: how high it stands depends on what is below it."""
        out = self.along(obj, places, by, then, now)
        for i, v in enumerate(self._spaces[obj].variables):
            if v.role is not None and (v.role.kind, v.role.axis) == ("position", "z"):
                out[..., i] = places[..., i]
        return out

    def along(self, obj: str, states: FloatArray, by: str, then: FloatArray, now: FloatArray) -> FloatArray:
        """States of an object, moved and turned as another one was.

        Args:
            obj: the object.
            states: shape (..., n_obj).
            by: what it is relative to.
            then: its state when the object's was so, shape (..., n_by).
            now: its state now, shape (..., n_by).

        Returns:
            shape (..., n_obj); as they are where it is not known how the two frames lie to each other.
        """
        two = self._between(obj, by)
        lead = np.broadcast_shapes(states.shape[:-1], then.shape[:-1], now.shape[:-1])
        out = np.broadcast_to(states, (*lead, states.shape[-1])).copy()
        if two is None:
            return out
        mine, theirs = list(two.parent.indices), list(two.child.indices)
        out[..., mine] = out[..., mine] + (now[..., theirs] - then[..., theirs]) @ two.turn
        heading = heading_of(self._spaces[by], two.child.frame)
        if heading is None or two.rows or two.parent.frame != two.child.frame or not {"x", "y"} <= set(two.child.axes):
            return out
        turn = wrap_angle(now[..., heading] - then[..., heading])
        x, y = (two.parent.axes.index(axis) for axis in "xy")
        c, s = np.cos(turn), np.sin(turn)
        off = out[..., mine] - now[..., theirs]
        out[..., mine[x]] = now[..., theirs[x]] + c * off[..., x] - s * off[..., y]
        out[..., mine[y]] = now[..., theirs[y]] + s * off[..., x] + c * off[..., y]
        own = heading_of(self._spaces[obj], two.parent.frame)
        if own is not None:
            out[..., own] = wrap_angle(out[..., own] + turn)
        return out

    def reach(self, obj: str) -> tuple[FloatArray, FloatArray] | None:
        """Lowest and highest position that an object has wherever the robot takes it within its bounds.

        Returns:
            Values of the object's variables, NaN for those that are no position, shape (n_obj,) each; None where it
            does not go with the robot, or the robot has no bounds.
        """
        learned: Any = self._edges.get(Interaction(self._root, obj))
        if learned is None or learned.alignment is None:
            return None
        two, space = learned.alignment, self._spaces[self._root]
        ends = np.array([(space.lower[i], space.upper[i]) for i in two.parent.indices])
        if not np.isfinite(ends).all():
            return None
        places = np.array(list(product(*ends))) @ two.turn.T + two.shift
        sway = np.abs(two.sway).sum(axis=1)  # however the robot turns
        low, high = np.full((2, len(self._spaces[obj])), np.nan)
        low[list(two.child.indices)], high[list(two.child.indices)] = (
            places.min(axis=0) - sway,
            places.max(axis=0) + sway,
        )
        return low, high

    def in_reach(self, obj: str, states: FloatArray, *, nearly: bool = False) -> BoolArray:
        """Whether the robot can be there, or bring an object there, give or take a grasp.

        Args:
            obj: the robot, or an object.
            states: shape (..., n_obj).
            nearly: whether of the robot, too, what is as good as within its bounds is.

        Returns:
            shape (...); true where it is not known how the object goes with the robot.
        """
        space, robot = self._spaces[obj], obj in self._roots
        ends = (space.lower, space.upper) if robot else self.reach(obj)
        if ends is None:
            return np.ones(states.shape[:-1], dtype=bool)
        room: FloatArray | float = 0.0
        if nearly or not robot:
            room = LEARNING.near * (self._model.high[obj] - self._model.low[obj])
        low, high = ends[0] - room, ends[1] + room
        places = space.role_indices("position")
        outside = (states[..., places] < low[places]) | (states[..., places] > high[places])  # never, where it is NaN
        return np.asarray(~outside.any(axis=-1))

    def is_shown(self, obj: str, states: FloatArray) -> BoolArray:
        """Whether an object was ever about there: of what it may hit elsewhere nothing is known.

        Args:
            obj: the object.
            states: shape (..., n_obj).

        Returns:
            shape (...).
        """
        if not enabled("brought_where_shown"):
            return np.ones(states.shape[:-1], dtype=bool)
        places = self._spaces[obj].role_indices("position")
        low, high = self._model.low[obj][places], self._model.high[obj][places]
        room, place = PLANNING.same * (high - low), states[..., places]
        return np.asarray(((place >= low - room) & (place <= high + room)).all(axis=-1))

    def _between(self, obj: str, by: str) -> Any:
        """The alignment of the object, as a parent, with the other."""
        if (obj, by) not in self._known:
            learned: Any = self._edges.get(Interaction(obj, by))
            two = None if learned is None else learned.alignment
            self._known[obj, by] = two or apart(self._spaces[obj], self._spaces[by], self._turns)
        return self._known[obj, by]
