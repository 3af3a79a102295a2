"""Validation on the learned graph: following paths that the demonstrations took, with learned models for a world."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ichain_drake.control.settings import TRACKING
from ichain_drake.control.tracking.move_to import MoveTo
from ichain_drake.control.tracking.path import PathLimits, TimedPath
from ichain_drake.errors import InputError
from ichain_drake.learned_graph.reference import LearnedGraphReference
from ichain_drake.learning.chain.chain import LearnedChain
from ichain_drake.learning.features import planar_poses
from ichain_drake.state import FloatArray
from ichain_drake.timing import TICK


@dataclass(frozen=True)
class ValidationCase:
    """One path to follow, and where the object starts.

    Attributes:
        path: the timed path.
        start: the last object's state, shape (n_variables,).
    """

    path: TimedPath
    start: FloatArray


def make_cases(chain: LearnedChain, limits: PathLimits, count: int, ticks: int, seed: int) -> list[ValidationCase]:
    """Cut paths out of the demonstrated trajectories of the last object, smoothed.

    Args:
        chain: the learned chain; its `validation` trajectories are used.
        limits: how paths are followed.
        count: how many; fewer where the demonstrations are short.
        ticks: length of each.
        seed: draws where they are cut.

    Raises:
        InputError: if no demonstration is long enough.
    """
    targets = list(chain.targets)
    space = chain.graph.objects[chain.names[-1]].observable
    rng = np.random.default_rng(seed)
    needed = ticks + TRACKING.smoothing
    windows = [(piece, start) for piece in chain.validation for start in range(0, len(piece) - needed, ticks // 4)]
    if not windows:
        raise InputError(f"no demonstration of {chain.names[-1]} is longer than {needed} ticks; record a longer piece")
    cases = []
    for index in rng.permutation(len(windows)):
        piece, start = windows[index]
        part = piece[start : start + ticks + TRACKING.smoothing - 1, targets]
        kernel = np.ones(TRACKING.smoothing) / TRACKING.smoothing
        smooth = np.stack([np.convolve(c, kernel, mode="valid") for c in part.T], axis=1)
        if np.linalg.norm(np.diff(smooth, axis=0), axis=1).sum() < limits.speed * TICK * ticks / 4:
            continue  # the object stood still
        state = piece[start + TRACKING.smoothing // 2].copy()
        state[targets] = smooth[0]
        path = TimedPath(smooth, limits)
        for x, y, orientation in planar_poses(space):
            if {x, y} == set(targets):
                state[orientation] = path.direction[0]  # along the path, as a run starts
        if path.speed.min() < TRACKING.slowest * limits.speed:
            continue
        cases.append(ValidationCase(path, state))
        if len(cases) == count:
            break
    if not cases:
        raise InputError(
            f"no part of the demonstrations of {chain.names[-1]} can be a validation path: it hardly moves or turns "
            f"too sharply for {limits.speed:g} a second; record a longer piece"
        )
    return cases


def validation_error(chain: LearnedChain, policy: MoveTo, cases: Sequence[ValidationCase], seed: int) -> float:
    """Mean distance to the validation paths when the policy controls the learned graph.

    Args:
        chain: the learned chain.
        policy: commands of its robot level must be wanted hand states.
        cases: see `make_cases`.
        seed: of the noise, the same for every policy.

    Returns:
        In the target's unit, the mean over the better three quarters of the runs: some paths cut out of demonstrations
        ask for more than any method can do. Infinite if more than a quarter was lost.
    """
    names, targets, n = chain.names, list(chain.targets), len(cases)
    graph = chain.graph
    models = {link.interaction: link.forward.model for link in chain.links}
    scale = {link.interaction: link.forward.residual_std for link in chain.links}
    reference = LearnedGraphReference(graph, models)
    rng = np.random.default_rng(seed)
    usual = float(np.linalg.norm(chain.links[-1].child_scale[targets]))

    states = {names[-1]: np.stack([c.start for c in cases])}
    for link in reversed(chain.links):
        middle = (link.parent_lower + link.parent_upper) / 2
        states[link.interaction.parent] = np.tile(middle, (n, 1))
    memory = np.zeros((n, policy.memory_size))
    progress = np.zeros(n, dtype=int)
    ahead = TICK * np.arange(1, policy.lookahead + 1)
    longest = int(np.ceil((1.0 + TRACKING.band) * max(c.path.time[-1] for c in cases) / TICK))
    distance, counted = np.zeros(n), np.zeros(n)
    running = np.ones(n, dtype=bool)
    lost = np.zeros(n, dtype=bool)
    for tick in range(longest):
        position = states[names[-1]][:, targets]
        progress = np.array(
            [c.path.advance(p, k, TRACKING.search * TICK) for c, p, k in zip(cases, position, progress, strict=True)]
        )
        running &= ~np.array([c.path.near_end(int(k)) for c, k in zip(cases, progress, strict=True)])
        nearest = np.stack([c.path.points[k] for c, k in zip(cases, progress, strict=True)])
        off = np.linalg.norm(position - nearest, axis=1)
        lost |= running & ~(off <= TRACKING.lost * usual)
        running &= ~lost
        if not running.any():
            break
        if tick:
            distance += np.where(running, off, 0.0)
            counted += running
        wanted = np.stack([c.path.at_time(c.path.time[k] + ahead) for c, k in zip(cases, progress, strict=True)])
        command, memory, _ = policy.decide([states[m] for m in names], wanted, memory)
        normal = {m: rng.standard_normal(states[m].shape) for m in names[1:]}
        states = reference.tick(states, command, normal=normal, scale=scale)
    errors = np.where(lost | running, np.inf, distance / np.maximum(counted, 1.0))
    return float(np.sort(errors)[: max(1, round(TRACKING.kept * n))].mean())
