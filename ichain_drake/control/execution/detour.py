"""Ways around places at which the robot was stopped, where nobody knows beforehand what stands in its way.

Whatever was not found to be blocked is taken for free (the freespace assumption; Koenig, Tovey & Smirnov 2003): the way
is straight until the robot is seen not to get on, then around that place, and so on.
"""

from __future__ import annotations

import heapq
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise, product

import numpy as np

from ichain_drake.control.planning.travel import jumping, step_towards
from ichain_drake.control.settings import EXECUTION, PLANNING
from ichain_drake.errors import UnreachableError
from ichain_drake.learning.model import InteractionModel
from ichain_drake.learning.settings import LEARNING
from ichain_drake.motion_query import MotionQuery
from ichain_drake.state import BoolArray, FloatArray, IntArray, StateSpace

_Node = tuple[int, ...]


def places(space: StateSpace) -> IntArray:
    """Indices of a robot's variables that say where it is."""
    return space.role_indices("position")


def stopped_before(
    model: InteractionModel, readings: Sequence[Mapping[str, FloatArray]], command: FloatArray
) -> FloatArray | None:
    """Where a robot would be a step further that does not get on although it is told to; None if it does get on.

    Args:
        model: the learned graph.
        readings: measured states of the last ticks, the newest last.
        command: the last command, shape (n_root,).

    Returns:
        A place, shape (n_place,).
    """
    if len(readings) < LEARNING.ticks:
        return None
    root = model.graph.root
    space, limit = model.graph.objects[root].observable, np.maximum(model.step_limit[root], 1e-9)
    floor, smooth = LEARNING.surely * model.noise[root], ~space.jump_mask
    here, before = (readings[k][root] for k in (-1, -LEARNING.ticks))
    way = space.difference(command, here)
    moved = np.abs(space.difference(here, before)) > np.maximum(EXECUTION.slack * limit, floor)
    short = np.abs(way) > np.maximum(PLANNING.push * limit, floor)
    if moved[smooth].any() or not short[smooth].any():
        return None
    further = here + way / max(1.0, float(np.max(np.abs(way[smooth]) / limit[smooth])))
    return np.asarray(further[places(space)])


@dataclass(frozen=True, eq=False)
class Blocked:
    """Where the robot was stopped while it held something, or nothing. Never changed: each event makes another.

    Attributes:
        places: of the robot, one step further than it got, shape (n, n_place).
        held: what it held.
        again: how often it was stopped at a place that was known.
    """

    places: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))
    held: str = ""
    again: int = 0

    def met(self, place: FloatArray, held: str, step: FloatArray) -> Blocked:
        """With another place; what was in the way of something else says nothing of this.

        Args:
            place: of the robot, one step further, shape (n_place,).
            held: what it holds.
            step: largest of the robot in a tick, shape (n_place,).
        """
        if held != self.held or not len(self.places):
            return Blocked(place[None], held)
        known = bool((np.abs(self.places - place) <= PLANNING.alike * step).all(axis=1).any())
        return Blocked(np.vstack([self.places, place]), held, self.again + known)


@dataclass(frozen=True, eq=False)
class Detour:
    """A `RobotMotion` around places where the robot was stopped.

    Attributes:
        space: of the robot.
        limit: largest change in a tick, shape (n_root,).
        blocked: where it was stopped.
    """

    space: StateSpace
    limit: FloatArray
    blocked: Blocked

    def path(self, query: MotionQuery) -> FloatArray:
        """See `RobotMotion`; what else changes does so in proportion. What was shown, it may be to push, is free.

        Raises:
            UnreachableError: if the goal itself is blocked, or all ways to it are.
        """
        if query.shown is not None:
            return np.array(query.shown, dtype=float)
        now, goal = (np.array(v, dtype=float) for v in (query.now, query.goal))
        start, end = now[self._place], goal[self._place]
        if self.blocked.again > LEARNING.few or self._hits(end[None], PLANNING.push).any():
            raise UnreachableError("the robot was stopped on the way there")
        corners = [start, end] if self._clear(start, end) else self._around(start, end)
        parts = [np.max(np.abs(b - a) / self._step) for a, b in pairwise(corners)]
        shares = np.cumsum(parts) / max(float(np.sum(parts)), 1e-9)
        rows, at = [], now
        way = self.space.difference(goal, now)
        for corner, share in zip(corners[1:], shares, strict=True):
            target = np.where(jumping(self.space), now, now + share * way)
            target[self._place] = corner
            there = False
            while not there:
                at, there = step_towards(self.space, at, target, self.limit)
                rows.append(at)
        rows[-1] = goal
        return np.array(rows)

    @property
    def _place(self) -> IntArray:
        return places(self.space)

    @property
    def _step(self) -> FloatArray:
        return np.maximum(self.limit[self._place], 1e-9)

    def _hits(self, places: FloatArray, near: float) -> BoolArray:
        """Which places, shape (n, n_place), are within so many steps of a blocked one, shape (n,)."""
        off = np.abs(places[:, None] - self.blocked.places[None]) / self._step
        return np.asarray((off.max(axis=2) < near - 1e-6).any(axis=1))

    def _clear(self, start: FloatArray, end: FloatArray) -> bool:
        """Whether nothing is known to be in the way of a straight line from where it stands; what is, is wide."""
        count = max(1, int(np.ceil(np.max(np.abs(end - start) / self._step) / PLANNING.push)))
        share = np.arange(1, count + 1)[:, None] / count
        return not self._hits(start + share * (end - start), 1.0).any()

    def _around(self, start: FloatArray, end: FloatArray) -> list[FloatArray]:
        """Corners of a shortest way in steps of the robot (A*), with both ends."""
        low, high = self.space.lower[self._place], self.space.upper[self._place]
        room = LEARNING.most_rows * self._step  # where there are no bounds
        low, high = np.maximum(low, start - room), np.minimum(high, start + room)
        moves = [np.array(m) for m in product((-1, 0, 1), repeat=len(start)) if any(m)]
        first: _Node = (0,) * len(start)
        came: dict[_Node, _Node] = {first: first}
        cost = {first: 0.0}
        queue = [(0.0, first)]
        for _ in range(EXECUTION.nodes):
            if not queue:
                break
            _, node = heapq.heappop(queue)
            here = start + np.array(node) * self._step
            if np.max(np.abs(end - here) / self._step) <= 1.0 and self._clear(here, end):
                return self._pulled(start, came, node, end)
            for move in moves:
                there: _Node = tuple(int(v) for v in np.array(node) + move)
                place = start + np.array(there) * self._step
                further = cost[node] + 1.0 + 1e-3 * float(np.abs(move).sum())
                if further >= cost.get(there, np.inf) or (place < low).any() or (place > high).any():
                    continue
                if not self._clear(here, place):
                    continue
                came[there], cost[there] = node, further
                heapq.heappush(queue, (further + float(np.max(np.abs(end - place) / self._step)), there))
        raise UnreachableError("the robot was stopped on every way there")

    def _pulled(self, start: FloatArray, came: Mapping[_Node, _Node], node: _Node, end: FloatArray) -> list[FloatArray]:
        """The way with its corners cut as far as nothing is known to be in the way."""
        steps = [node]
        while came[steps[-1]] != steps[-1]:
            steps.append(came[steps[-1]])
        every = [*(start + np.array(n) * self._step for n in steps[::-1]), end]
        out, k = [every[0]], 0
        while k < len(every) - 1:
            k = max(j for j in range(k + 1, len(every)) if j == k + 1 or self._clear(every[k], every[j]))
            out.append(every[k])
        return out
