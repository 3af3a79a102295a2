"""What the robot holds, and where it let go of what it held: what whoever lays out its ways has to know."""

from __future__ import annotations

from collections.abc import Mapping
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

    def standing(self, model: InteractionModel, now: States) -> dict[str, FloatArray]:
        """Of what stands around: the robot's state in which it would let go of it there, shape (n_root,).

        Where the robot let go of an object that has not moved since, that state; of another that goes along with the
        robot when it is held, the one in which it was taken in the nearest demonstration, moved as the object was.

        Args:
            model: the learned graph.
            now: measured states, shape (n_variables,) each.
        """
        frames, root, out = Frames(model), model.graph.root, {}
        for edge in model.edges:
            obj = edge.child
            if edge.parent != root or obj == self.held:
                continue
            if obj in self.left and (obj not in self.seen or not _moved(model, obj, self.seen[obj], now[obj])):
                out[obj] = self.left[obj]
            elif frames.is_carried(obj) and len(taken := model.edges[edge].examples.activations.after[obj]):
                off = _off(model, obj, taken, now[obj]) / span(model, obj)
                k = int(np.argmin(np.linalg.norm(off[:, sorted(pose_of(model.graph.objects[obj].observable))], axis=1)))
                robot = model.edges[edge].examples.activations.after[root][k]
                out[obj] = frames.along(root, robot, obj, taken[k], now[obj])
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


def _moved(model: InteractionModel, obj: str, was: FloatArray, now: FloatArray) -> bool:
    off = _off(model, obj, was, now)
    pose = sorted(pose_of(model.graph.objects[obj].observable))
    return bool((off > np.maximum(LEARNING.near * span(model, obj), PLANNING.noises * model.noise[obj]))[pose].any())


def _off(model: InteractionModel, obj: str, was: FloatArray, now: FloatArray) -> FloatArray:
    return np.abs(model.graph.objects[obj].observable.difference(now, was))
