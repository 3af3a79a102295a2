"""One level of a chain's control: from wanted states of a child to wanted states of its parent."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from ichain_drake.control.tracking.offset import OffsetEstimate
from ichain_drake.control.tracking.tick_model import TickModel
from ichain_drake.learning.chain.models import InverseModel
from ichain_drake.state import FloatArray, StateSpace

_HARM = 2.0  # times the best cost so far; a step over a small rise often leads on
_SHORTER = 0.3  # of a step that did harm


class Level(Protocol):
    """Turns wanted states of a child into wanted states of its parent."""

    @property
    def memory_size(self) -> int:
        """Length of what it keeps from one tick to the next."""

    @property
    def lookahead(self) -> int:
        """How many ticks of wanted states it reads."""

    def decide(
        self, child: FloatArray, parent: FloatArray, wanted: FloatArray, memory: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """One decision.

        Args:
            child, parent: measured states now, shape (n, n_child) and (n, n_parent).
            wanted: wanted values of the child's target variables in the coming ticks, shape (n, k, n_targets).
            memory: shape (n, memory_size); zeros at the start.

        Returns:
            Wanted states of the parent in the coming ticks, shape (n, k', n_parent), and the new memory.
        """


def plan_step(space: StateSpace, current: FloatArray, wanted: FloatArray, limit: FloatArray, ticks: int) -> FloatArray:
    """The waypoint that lies `ticks` along a straight path to a wanted state (paper, Algorithm 1: path planning).

    A wanted state within reach is its own waypoint; one further off is approached over several ticks.

    Args:
        space: of the variables concerned; angles go the short way round.
        current: shape (n, n_variables).
        wanted: shape (n, n_variables).
        limit: largest change of each variable in one tick, shape (n_variables,).
        ticks: how far along.

    Returns:
        shape (n, n_variables).
    """
    delta = space.difference(wanted, current)
    needed = np.max(np.abs(delta) / limit, axis=-1, keepdims=True)
    return current + delta * np.minimum(1.0, ticks / np.maximum(needed, 1e-12))


@dataclass(frozen=True)
class InverseLevel:
    """The paper's way (sec. III, IV): ask the learned inverse transition for the parent's state.

    Attributes:
        inverse: the inverse model.
        limit: largest change of each target variable in one tick that the demonstrations show, shape (n_targets,).
    """

    inverse: InverseModel
    limit: FloatArray
    memory_size: int = 0

    @property
    def lookahead(self) -> int:
        """Ticks of wanted states that are read."""
        return self.inverse.aim

    def decide(
        self, child: FloatArray, parent: FloatArray, wanted: FloatArray, memory: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """See `Level.decide`."""
        aim = self.inverse.aim
        targets = list(self.inverse.targets)
        space = self.inverse.child_space.subspace([self.inverse.child_space.names[i] for i in targets])
        goal = wanted[:, min(aim, wanted.shape[1]) - 1]
        waypoint = plan_step(space, child[:, targets], goal, self.limit, aim)
        return self.inverse(child, waypoint)[:, None], memory


@dataclass(frozen=True)
class PredictiveWeights:
    """What a predictive level weighs.

    Attributes:
        horizon: ticks that are planned.
        effort: weight of a change of the parent's state by its usual spread in one tick, against an error of one
            usual step of the target.
        along: weight of an error along the wanted motion, against one across it: being late is better than
            cutting a corner.
        iterations: Gauss-Newton steps of one decision.
        offset: weight of the newest error of the model in the estimate of its lasting error; 0 to take the model at
            its word; see `OffsetEstimate`.
    """

    horizon: int = 5
    effort: float = 0.05
    along: float = 0.2
    iterations: int = 3
    offset: float = 0.0


@dataclass(frozen=True)
class PredictiveLevel:
    """Model predictive control: the parent's states of the next ticks that bring the child nearest to the wanted ones.

    Gauss-Newton over the parent's states, box-constrained by projection, warm-started from the last decision; the best
    iterate wins, so that a bad step can't do harm.

    Attributes:
        model: one-tick model of the child.
        child_space: the model's state space.
        targets: indices of the child's target variables.
        target_scale: usual change of each target variable in one tick, shape (n_targets,).
        lower, upper: range of the parent's states, shape (n_parent,).
        parent_scale: usual spread of the parent's states, shape (n_parent,).
        weights: see `PredictiveWeights`.
        parent_step: largest change of each parent variable in one tick that the level below can bring about, shape
            (n_parent,); None for any.
    """

    model: TickModel
    child_space: StateSpace
    targets: tuple[int, ...]
    target_scale: FloatArray
    lower: FloatArray
    upper: FloatArray
    parent_scale: FloatArray
    weights: PredictiveWeights = PredictiveWeights()
    parent_step: FloatArray | None = None

    @property
    def memory_size(self) -> int:
        """One flag, the parent's planned states, the states of both one tick before, and the model's errors."""
        return 1 + self.weights.horizon * len(self.lower) + self._error_memory

    @cached_property
    def _offset(self) -> OffsetEstimate:
        return OffsetEstimate(len(self.child_space), self.weights.offset)

    @cached_property
    def _error_memory(self) -> int:
        size = self._offset.memory_size
        return size + len(self.child_space) + len(self.lower) if size else 0

    @property
    def lookahead(self) -> int:
        """Ticks of wanted states that are read."""
        return self.weights.horizon

    def decide(
        self, child: FloatArray, parent: FloatArray, wanted: FloatArray, memory: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """See `Level.decide`."""
        n, m, horizon = len(child), len(self.lower), self.weights.horizon
        wanted = _extend(wanted, horizon)
        last = memory[:, 1 : 1 + horizon * m].reshape(n, horizon, m)
        errors = self._errors(child, parent, memory)
        offsets = self._offset.offsets(errors, horizon)
        shifted = np.concatenate([last[:, 1:], last[:, -1:]], axis=1)
        plan = np.where(memory[:, :1, None] > 0, shifted, parent[:, None])
        plan = self._within_reach(parent, np.clip(plan, self.lower, self.upper))
        metric = self._error_metric(child, wanted)
        best, best_cost, trust = plan, np.full(n, np.inf), np.ones(n)
        at_last: tuple[FloatArray, FloatArray, FloatArray] | None = None
        for iteration in range(self.weights.iterations + 1):
            final = iteration == self.weights.iterations
            residual, jacobian = self._residual(child, parent, plan, offsets, wanted, metric, with_jacobian=not final)
            cost = np.einsum("nr,nr->n", residual, residual)
            better, harmed = cost < best_cost, cost > _HARM * best_cost
            best = np.where(better[:, None, None], plan, best)
            best_cost = np.where(better, cost, best_cost)
            if final or jacobian is None:
                break
            if at_last is not None and harmed.any():  # a step that did harm is tried again, shorter, from its start
                plan = np.where(harmed[:, None, None], at_last[0], plan)
                residual = np.where(harmed[:, None], at_last[1], residual)
                jacobian = np.where(harmed[:, None, None], at_last[2], jacobian)
            trust = np.where(harmed, _SHORTER * trust, 1.0)
            at_last = plan, residual, jacobian
            plan = self._within_reach(parent, self._improve(plan, residual, jacobian, trust))
        now = [child, parent, errors] if self._error_memory else []
        return best, np.concatenate([np.ones((n, 1)), best.reshape(n, -1), *now], axis=1)

    def _errors(self, child: FloatArray, parent: FloatArray, memory: FloatArray) -> FloatArray:
        """What is remembered of the model's errors, with the last tick's, shape (n, memory size of the estimate)."""
        if not self._error_memory:
            return np.zeros((len(child), 0))
        kept = memory[:, -self._error_memory :]
        n_child, n_both = len(self.child_space), len(self.child_space) + len(self.lower)
        before, parent_before, errors = kept[:, :n_child], kept[:, n_child:n_both], kept[:, n_both:]
        error = self.child_space.difference(child, self.model.predict(before, parent_before, parent))
        return np.where(memory[:, :1] > 0, self._offset.update(errors, error), errors)

    def _error_metric(self, child: FloatArray, wanted: FloatArray) -> FloatArray:
        """Weight matrices of the scaled error in each tick, (n, k, t, t): full across the motion, less along it."""
        start = child[:, None, list(self.targets)]
        path = np.concatenate([start, wanted], axis=1)
        motion = self._target_space.difference(path[:, 1:], path[:, :-1])
        motion[:, 0] = motion[:, min(1, motion.shape[1] - 1)]  # from the reference, not from where the child is
        motion = motion / self.target_scale
        length = np.linalg.norm(motion, axis=-1, keepdims=True)
        tangent = np.where(length > 1e-9, motion / np.maximum(length, 1e-9), 0.0)
        outer = tangent[..., :, None] * tangent[..., None, :]
        return np.eye(len(self.targets)) - (1.0 - self.weights.along) * outer

    def _residual(
        self,
        child: FloatArray,
        parent: FloatArray,
        plan: FloatArray,
        offsets: FloatArray,
        wanted: FloatArray,
        metric: FloatArray,
        *,
        with_jacobian: bool,
    ) -> tuple[FloatArray, FloatArray | None]:
        n, horizon, m = plan.shape
        after, sensitivity = self._rollout(child, parent, plan, offsets, with_jacobian=with_jacobian)
        targets = list(self.targets)
        error = self._target_space.difference(after[..., targets], wanted) / self.target_scale
        errors = np.einsum("nkij,nkj->nki", metric, error)
        effort = self.weights.effort / self.parent_scale
        way = np.concatenate([parent[:, None], plan], axis=1)
        moves = (way[:, 1:] - way[:, :-1]) * effort
        residual = np.concatenate([errors.reshape(n, -1), moves.reshape(n, -1)], axis=1)
        if sensitivity is None:
            return residual, None
        slopes = metric @ (sensitivity[:, :, targets] / self.target_scale[:, None])
        jacobian = np.empty((n, residual.shape[1], horizon * m))
        jacobian[:, : -horizon * m] = slopes.reshape(n, -1, horizon * m)
        jacobian[:, -horizon * m :] = self._moves_by_plan
        return residual, jacobian

    def _rollout(
        self, child: FloatArray, parent: FloatArray, plan: FloatArray, offsets: FloatArray, *, with_jacobian: bool
    ) -> tuple[FloatArray, FloatArray | None]:
        """The child's states under a plan, shape (n, k, n_child), and their derivatives by the planned states."""
        n, horizon, m = plan.shape
        states, notes = np.empty((n, horizon, child.shape[1])), []
        state, previous = child, parent
        for k in range(horizon):
            if with_jacobian:
                after, note = self.model.predict_noted(state, previous, plan[:, k])
                notes.append(note)
            else:
                after = self.model.predict(state, previous, plan[:, k])
            state, previous = after + offsets[:, k], plan[:, k]
            states[:, k] = state
        if not with_jacobian:
            return states, None
        by_child, by_parent, by_next = self.model.derivatives(notes)
        by_both = np.concatenate([by_parent, by_next], axis=-1)
        sensitivity = np.zeros((n, horizon, child.shape[1], horizon * m))
        sensitivity[:, 0, :, :m] = by_next[0]
        for k in range(1, horizon):
            after = np.matmul(by_child[k], sensitivity[:, k - 1], out=sensitivity[:, k])
            after[..., (k - 1) * m : (k + 1) * m] += by_both[k]
        return states, sensitivity

    @cached_property
    def _target_space(self) -> StateSpace:
        return self.child_space.subspace([self.child_space.names[i] for i in self.targets])

    @cached_property
    def _moves_by_plan(self) -> FloatArray:
        """Derivative of the weighed changes of the parent's states by the states, (horizon n_parent,) twice."""
        horizon, effort = self.weights.horizon, self.weights.effort / self.parent_scale
        return np.asarray(np.kron(np.eye(horizon) - np.eye(horizon, k=-1), np.diag(effort)))

    @cached_property
    def _of_plan(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Lower and upper bound of every planned state, how far a step may go, and its damping."""
        horizon = self.weights.horizon
        lower, upper = np.tile(self.lower, horizon), np.tile(self.upper, horizon)
        damping = 1e-6 * np.eye(len(lower)) / np.tile(self.parent_scale, horizon) ** 2
        return lower, upper, 0.35 * (upper - lower), damping

    def _within_reach(self, parent: FloatArray, plan: FloatArray) -> FloatArray:
        """The plan with every step as far as `parent_step` lets it be, shape (n, horizon, n_parent)."""
        if self.parent_step is None:
            return plan
        steps, at = np.empty_like(plan), parent
        for k in range(plan.shape[1]):
            at = np.minimum(np.maximum(plan[:, k], at - self.parent_step), at + self.parent_step, out=steps[:, k])
        return steps

    def _improve(self, plan: FloatArray, residual: FloatArray, jacobian: FloatArray, trust: FloatArray) -> FloatArray:
        lower, upper, reach, damping = self._of_plan
        flat = plan.reshape(len(plan), -1)
        transposed = np.swapaxes(jacobian, 1, 2)
        gradient = (transposed @ residual[..., None])[..., 0]
        # Projected Newton (Bertsekas 1982): what is at a bound and pushed against it stays, the rest is solved for.
        free = ~(((flat <= lower) & (gradient > 0)) | ((flat >= upper) & (gradient < 0)))
        hessian = transposed @ jacobian + damping
        hessian = np.where(free[:, :, None] & free[:, None, :], hessian, np.eye(len(lower)) * hessian)
        step = -np.linalg.solve(hessian, np.where(free, gradient, 0.0)[..., None])[..., 0]
        return np.clip(flat + trust[:, None] * np.clip(step, -reach, reach), lower, upper).reshape(plan.shape)


def _extend(wanted: FloatArray, ticks: int) -> FloatArray:
    """Repeat the last wanted state until there are enough ticks."""
    missing = ticks - wanted.shape[1]
    if missing <= 0:
        return wanted[:, :ticks]
    return np.concatenate([wanted, np.repeat(wanted[:, -1:], missing, axis=1)], axis=1)
