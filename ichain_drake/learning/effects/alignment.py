"""Where a child is while it moves with its parent, learned from demonstrations.

A camera's frame and the robot's differ by a turn and a shift that nobody declares. While an interaction is active and
the child moves with its parent, their displacements show the turn (Kabsch 1976), and their median offset the shift. A
child that is held off its own origin also sways when its parent turns about an axis.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ichain_drake.graph import Interaction
from ichain_drake.learning.blocks import runs
from ichain_drake.learning.data import GraphData
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import FloatArray, StateSpace


@dataclass(frozen=True)
class PositionGroup:
    """The position components of one frame in a state space.

    Attributes:
        frame: as declared in the roles; compared, never interpreted.
        axes: such as `("x", "y", "z")`, sorted.
        indices: of the variables, in the order of `axes`.
    """

    frame: str
    axes: tuple[str, ...]
    indices: tuple[int, ...]


def position_groups(space: StateSpace) -> list[PositionGroup]:
    """All position groups of a state space, by roles alone."""
    found: dict[str, dict[str, int]] = {}
    for i, v in enumerate(space.variables):
        if v.role is not None and v.role.kind == "position":
            found.setdefault(v.role.frame, {})[v.role.axis] = i
    return [PositionGroup(f, tuple(sorted(a)), tuple(a[k] for k in sorted(a))) for f, a in found.items()]


@dataclass(frozen=True)
class Alignment:
    """`p_child = turn @ p_parent + sway @ [cos, sin](parent's angles) + shift` while the two are together.

    Attributes:
        parent, child: the position groups.
        angles: indices of the parent's angles.
        turn: shape (n_child_axes, n_parent_axes); a rotation where the axes are the same.
        sway: shape (n_child_axes, 2 n_angles), in the child's units: cosines first.
        shift: shape (n_child_axes,), in the child's units; contains the mean offset of the two bodies.
        rows: number of displacements that it was learned from; 0 where the frames are declared the same.
        unexplained: share of the child's squared motion that is left.
    """

    parent: PositionGroup
    child: PositionGroup
    angles: tuple[int, ...]
    turn: FloatArray
    sway: FloatArray
    shift: FloatArray
    rows: int
    unexplained: float

    def place(self, parent: FloatArray) -> FloatArray:
        """Where the child would be, shape (..., n_child_axes), for states of the parent, shape (..., n)."""
        position = parent[..., list(self.parent.indices)] @ self.turn.T
        return position + _circular(parent, self.angles) @ self.sway.T + self.shift

    def relative(self, parent: FloatArray, child: FloatArray) -> FloatArray:
        """Where the child is instead, along the axes of the parent's frame, shape (..., n_parent_axes)."""
        return (child[..., list(self.child.indices)] - self.place(parent)) @ self.turn


def frame_turns(
    spaces: Mapping[str, StateSpace], root: str, alignments: Mapping[Interaction, Alignment | None]
) -> dict[str, FloatArray]:
    """For each frame how its coordinates turn into the root's: `p_root = p_frame @ turn` (rows).

    Args:
        spaces: observable state space per object.
        root: the robot.
        alignments: of all interactions; where several lead to a frame, that of most displacements counts.
    """
    turns = {group.frame: np.eye(len(group.indices)) for group in position_groups(spaces[root])}
    known = sorted((a for a in alignments.values() if a is not None), key=lambda a: -a.rows)
    while best := next((a for a in known if a.parent.frame in turns and a.child.frame not in turns), None):
        turns[best.child.frame] = best.turn @ turns[best.parent.frame]
    return turns


def apart(parent: StateSpace, child: StateSpace, turns: Mapping[str, FloatArray]) -> Alignment | None:
    """How the frames of two objects that don't move together lie to each other, but for their shift.

    Args:
        parent, child: observable state spaces.
        turns: see `frame_turns`.

    Returns:
        None where one has no position, or it is not known how its frame is turned.
    """
    groups = [next(iter(position_groups(s)), None) for s in (parent, child)]
    if any(g is None for g in groups):
        return None
    p, c = (g for g in groups if g is not None)
    if p.axes != c.axes:
        return None
    if p.frame == c.frame:
        turn = np.eye(len(c.indices))
    elif p.frame in turns and c.frame in turns and turns[p.frame].shape == turns[c.frame].shape:
        turn = turns[c.frame] @ turns[p.frame].T
    else:
        return None
    return Alignment(p, c, (), turn, np.zeros((len(c.indices), 0)), np.zeros(len(c.indices)), 0, 1.0)


def heading_of(space: StateSpace, frame: str) -> int | None:
    """Index of an object's orientation about the vertical of a frame, by its role; None if there is none."""
    for i, v in enumerate(space.variables):
        if v.role is not None and (v.role.kind, v.role.axis, v.role.frame) == ("orientation", "z", frame):
            return i
    return None


def learn_alignment(data: GraphData, edge: Interaction, noise: Mapping[str, FloatArray]) -> Alignment | None:
    """The alignment of the two ends of an interaction, or None where they don't move together.

    Args:
        data: the pieces.
        edge: the interaction.
        noise: measurement noise per object, shape (n_variables,).
    """
    parents, children = position_groups(data.spaces[edge.parent]), position_groups(data.spaces[edge.child])
    if not parents or not children:
        return None
    p, c = parents[0], children[0]
    space = data.spaces[edge.parent]
    angles = tuple(i for i in data.variables[edge.parent] if space.angle_mask[i])
    ip, ic = list(p.indices), list(c.indices)
    now, then = [], []
    for piece in data.pieces:
        both = np.hstack([piece.states[edge.parent], piece.states[edge.child]])
        for a, b in runs(piece.flags[edge]):
            starts = np.arange(a, b - LEARNING.ticks)
            now.append(both[starts])
            then.append(both[starts + LEARNING.ticks])
    n = len(space)
    before, after = np.vstack(now or [np.zeros((0, 1))]), np.vstack(then or [np.zeros((0, 1))])
    same_frame = p.frame == c.frame and p.axes == c.axes
    if not len(before):
        return None
    child_columns = [n + i for i in ic]
    moved_p, moved_c = after[:, ip] - before[:, ip], after[:, child_columns] - before[:, child_columns]
    turned = _circular(after, angles) - _circular(before, angles)
    least = LEARNING.plain * np.sqrt(2.0) * np.linalg.norm(noise[edge.parent][ip])
    moving = np.linalg.norm(moved_p, axis=1) > least
    turn, sway, left = np.eye(len(ic), len(ip)), np.zeros((len(ic), 2 * len(angles))), 0.0
    if moving.sum() >= LEARNING.several:
        # A turning parent sways the child: the turn of the frames is learned where it doesn't, then the sway from all.
        still = np.abs(turned).sum(axis=1) < LEARNING.near
        steady = moving & still if (moving & still).sum() >= LEARNING.several else moving
        turn = _fit_turn(moved_p[steady], moved_c[steady], rigid=p.axes == c.axes)
        sway = _fit_sway(turned, moved_c - moved_p @ turn.T)
        rest = moved_c - moved_p @ turn.T - turned @ sway.T
        left = float(np.sum(_kept(rest[moving] ** 2)) / max(np.sum(_kept(moved_c[moving] ** 2)), 1e-300))
        if left > LEARNING.together:
            return None
        turn = np.eye(len(ic)) if same_frame else turn
    elif not same_frame:
        return None
    places = before[:, ip] @ turn.T + _circular(before, angles) @ sway.T
    shift = np.median(before[:, child_columns] - places, axis=0)
    return Alignment(p, c, angles, turn, sway, shift, int(moving.sum()), left)


def _circular(states: FloatArray, angles: tuple[int, ...]) -> FloatArray:
    """Cosines, then sines of some angles, shape (..., 2 n_angles)."""
    values = states[..., list(angles)]
    return np.concatenate([np.cos(values), np.sin(values)], axis=-1)


def _fit_sway(turned: FloatArray, rest: FloatArray) -> FloatArray:
    """Ridge regression of what is left of the child's motion on the parent's turning, shape (n_child, n_turned)."""
    gram = turned.T @ turned + LEARNING.sway * np.eye(turned.shape[1])
    if not turned.shape[1]:
        return np.zeros((rest.shape[1], 0))
    return np.asarray(np.linalg.solve(gram, turned.T @ rest).T, dtype=float)


def _kept(squares: FloatArray) -> FloatArray:
    """The smaller nine tenths of the rows' sums: a few odd rows don't decide whether the two move together."""
    total = np.sort(squares.sum(axis=1))
    return total[: max(1, int(0.9 * len(total)))]


def _fit_turn(dp: FloatArray, dc: FloatArray, *, rigid: bool) -> FloatArray:
    keep: NDArray[np.bool_] = np.ones(len(dp), dtype=bool)
    turn = np.eye(dc.shape[1], dp.shape[1])
    for _ in range(4):
        linear = np.linalg.lstsq(dp[keep], dc[keep], rcond=None)[0].T
        turn = _kabsch(dp[keep], dc[keep]) if rigid else np.asarray(linear, dtype=float)
        residual = np.linalg.norm(dc - dp @ turn.T, axis=1)
        keep = residual <= LEARNING.clear * max(float(np.median(residual)), 1e-12)
    return turn


def _kabsch(dp: FloatArray, dc: FloatArray) -> FloatArray:
    """The rotation that turns displacements `dp` (n, d) into `dc` (n, d) with the least squared error."""
    u, _, vt = np.linalg.svd(dc.T @ dp)
    sign = np.ones(len(u))
    sign[-1] = np.sign(np.linalg.det(u @ vt))
    return (u * sign) @ vt
