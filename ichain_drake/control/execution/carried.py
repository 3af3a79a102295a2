"""What the robot holds, and where it let go of what it held: what whoever lays out its ways has to know."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ichain_drake.control.execution.following import pose_of
from ichain_drake.control.planning.frames import Frames
from ichain_drake.control.planning.model import span
from ichain_drake.control.planning.plan import States
from ichain_drake.control.settings import PLANNING
from ichain_drake.graph import Interaction
from ichain_drake.learning.model import InteractionModel
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import FloatArray


@dataclass(frozen=True)
class Carried:
    """Never changed: each event makes another.

    Attributes:
        held: object that goes along with the robot, if any.
        origin: its measured state when it was taken, n_variables numbers; empty if nothing is held.
        left: robot state in which each object that it held was let go of, shape (n_root,).
        seen: what was measured of each of these afterwards, shape (n_variables,).
        ticks: since it was taken.
        follows: whether it was seen to go along when the robot moved clearly last.
    """

    held: str | None = None
    left: Mapping[str, FloatArray] = field(default_factory=dict)
    seen: Mapping[str, FloatArray] = field(default_factory=dict)
    origin: tuple[float, ...] = ()
    ticks: int = 0
    follows: bool = False

    @property
    def following(self) -> str:
        """What is held, if it was seen to go along; else empty."""
        return self.held if self.held is not None and self.follows else ""

    def taken(self, obj: str, state: FloatArray) -> Carried:
        """From now on it goes along.

        Args:
            obj: the object.
            state: what is measured of it, shape (n_variables,).
        """
        if self.held == obj:
            return self
        left, seen = ({n: v for n, v in part.items() if n != obj} for part in (self.left, self.seen))
        return Carried(obj, left, seen, tuple(state.tolist()))

    def watched(self, went_along: bool | None) -> Carried:
        """A tick later.

        Args:
            went_along: whether what is held was seen to go along, as `goes_along` says it.
        """
        return replace(self, ticks=self.ticks + 1, follows=self.follows if went_along is None else went_along)

    def let_go(self, root: FloatArray) -> Carried:
        """What was held stays where the robot is, shape (n_root,)."""
        assert self.held is not None
        return Carried(None, {**self.left, self.held: np.array(root)}, self.seen)

    def slipped(self) -> Carried:
        """What was held is somewhere else."""
        return Carried(None, self.left, self.seen)

    def settled(self, obj: str, state: FloatArray) -> Carried:
        """What is measured of it, shape (n_variables,), once it has been let go of."""
        return replace(self, seen={**self.seen, obj: np.array(state)}) if obj in self.left else self

    def where(
        self, model: InteractionModel, readings: Sequence[States], now: States, command: FloatArray
    ) -> dict[str, FloatArray]:
        """Where things are: the robot's states in which, held as in demonstrations, each would be there.

        That is where the robot let go of it, or took it in the nearest demonstration, or its command while it holds it,
        moved by as much as the object is read elsewhere than a usual grasp would have it: no grasp is as the one
        before, and things slip. What is held is read at the same ticks as the robot: the command is ahead of both while
        it moves. What does not go along, or has not been read since, is where it was let go of, if it has not moved.

        Args:
            model: the learned graph.
            readings: measured states of the last ticks, shape (n_variables,) each.
            now: their average.
            command: the robot's, shape (n_root,).

        Returns:
            shape (n_root,) each, by the object's name.
        """
        root, out = model.graph.root, {}
        for edge in (e for e in model.edges if e.parent == root):
            obj, learned, robot = edge.child, model.edges[edge], None
            if obj in self.left and (obj not in self.seen or not _moved(model, obj, self.seen[obj], now[obj])):
                robot = out[obj] = self.left[obj]
            taken = learned.examples.activations.after
            if learned.alignment is None or not len(taken[obj]) or (obj in out and obj not in self.seen):
                continue
            off, usual = learned.alignment.relative, learned.alignment.relative(taken[root], taken[obj])
            if obj == self.held:
                robot, last = command, readings[-min(len(readings), self.ticks + 1) :]
                slip = np.median([off(r[root], r[obj]) for r in last], axis=0)
            else:
                robot = _as_taken(model, obj, taken, now[obj]) if robot is None else robot
                slip = off(robot, now[obj])
            out[obj] = np.array(robot)
            out[obj][list(learned.alignment.parent.indices)] += slip - np.median(usual, axis=0)
        return out

    def stayed(self, model: InteractionModel, now: States) -> bool:
        """Whether what should go along with the robot is still where it was taken: it never went along.

        Args:
            model: the learned graph.
            now: measured states, shape (n_variables,) each.
        """
        return self.held is not None and not _moved(model, self.held, np.array(self.origin), now[self.held])

    def in_the_air(self, model: InteractionModel, edge: Interaction, now: States) -> bool:
        """Whether what is held is neither where it was taken nor where it was let go of in a demonstration.

        Args:
            model: the learned graph.
            edge: from the robot to what is held.
            now: measured states, shape (n_variables,) each.
        """
        obj = edge.child
        if self.held != obj:
            return False
        places = model.edges[edge].examples.deactivations.after[obj]
        return all(_moved(model, obj, was, now[obj]) for was in (np.array(self.origin), *places))


@dataclass(frozen=True)
class Places:
    """Where what the robot may hold was seen last while it did not. Never changed: each tick makes another.

    Attributes:
        at: measured state of each, shape (n_variables,).
        moved: how often one of them was seen clearly elsewhere than before.
        ticks: for how long each has been seen there.
        stood: measured states in which each stood still for some time, shape (n_variables,) each.
    """

    at: Mapping[str, FloatArray] = field(default_factory=dict)
    moved: int = 0
    ticks: Mapping[str, int] = field(default_factory=dict)
    stood: Mapping[str, tuple[FloatArray, ...]] = field(default_factory=dict)

    def seen(self, model: InteractionModel, now: States, held: str | None) -> Places:
        """A tick later.

        Args:
            model: the learned graph.
            now: measured states, shape (n_variables,) each.
            held: what the robot holds, if anything.
        """
        mine = [e.child for e in model.edges if e.parent == model.graph.root and e.child != held]
        fresh = {n: now[n] for n in mine if n not in self.at or _moved(model, n, self.at[n], now[n])}
        at = {n: self.at[n] for n in self.at if n in mine} | fresh
        ticks = {n: 1 if n in fresh else self.ticks[n] + 1 for n in mine}
        still = [n for n in mine if ticks[n] == LEARNING.look and not _in_a_hand(model, n, now)]
        stood = {**self.stood, **{n: (*self.stood.get(n, ()), now[n]) for n in still}}
        return Places(at, self.moved + sum(n in self.at for n in fresh), ticks, stood)


def _in_a_hand(model: InteractionModel, obj: str, now: States) -> bool:
    """Whether any robot holds it, as the classifiers see it."""
    return any(model.graph.by_robot(e) and bool(model.decide(e, now) >= 0) for e in model.edges if e.child == obj)


def _as_taken(model: InteractionModel, obj: str, taken: States, now: FloatArray) -> FloatArray:
    """The robot's state where it took an object in the nearest demonstration, moved and turned as that was."""
    root, pose = model.graph.root, sorted(pose_of(model.graph.objects[obj].observable))
    k = int(np.argmin(np.linalg.norm((_off(model, obj, taken[obj], now) / span(model, obj))[:, pose], axis=1)))
    return Frames(model).along(root, taken[root][k], obj, taken[obj][k], now)


def _moved(model: InteractionModel, obj: str, was: FloatArray, now: FloatArray) -> bool:
    off = _off(model, obj, was, now)
    pose = sorted(pose_of(model.graph.objects[obj].observable))
    return bool((off > np.maximum(LEARNING.near * span(model, obj), PLANNING.noises * model.noise[obj]))[pose].any())


def _off(model: InteractionModel, obj: str, was: FloatArray, now: FloatArray) -> FloatArray:
    return np.abs(model.graph.objects[obj].observable.difference(now, was))
