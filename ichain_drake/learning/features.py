"""Features from kinds and roles: what a regression sees of a state, and how a change of state is coded.

Nothing here looks at a name. A pose (two positions and an orientation about z in one frame) can be described in the
body's own frame, in which motion does not depend on where the body is or, but for what the world adds, on its heading.
"""

from __future__ import annotations

from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ichain_drake.errors import InputError
from ichain_drake.state import FloatArray, StateSpace, wrap_angle

FeatureKind = Literal["none", "raw", "body"]
"""`none`: the child's own state is left out (a child that only mirrors its parent); `raw`: all variables; `body`: no
position, changes of position in the body's frame."""


def planar_poses(space: StateSpace) -> list[tuple[int, int, int]]:
    """Indices (x, y, orientation about z) of every frame in which a state space has all three."""
    poses = []
    frames = dict.fromkeys(v.role.frame for v in space.variables if v.role and v.role.kind == "orientation")
    for frame in frames:
        found: dict[tuple[str, str], int] = {
            (v.role.kind, v.role.axis): i for i, v in enumerate(space.variables) if v.role and v.role.frame == frame
        }
        keys = (("position", "x"), ("position", "y"), ("orientation", "z"))
        if all(k in found for k in keys):
            poses.append((found[keys[0]], found[keys[1]], found[keys[2]]))
    return poses


class StateFeatures:
    """What a regression sees of a state: angles as cosine and sine, the rest as it is.

    Args:
        space: the observable state space.
        kind: see `FeatureKind`.

    Attributes:
        plain: indices of the variables that are seen as they are, which come first.
        angles: indices of those of which first all cosines, then all sines are seen.

    Raises:
        InputError: for `body` where the state space has no planar pose.
    """

    def __init__(self, space: StateSpace, kind: FeatureKind) -> None:
        self.space = space
        self.kind = kind
        poses = planar_poses(space)
        if kind == "body" and not poses:
            raise InputError(
                f"{space.type} has no position x, y with an orientation about z: 'body' features need them"
            )
        dropped = {i for x, y, _ in poses for i in (x, y)} if kind == "body" else set()
        kept = [] if kind == "none" else [i for i in range(len(space)) if i not in dropped]
        self.plain = np.array([i for i in kept if not space.angle_mask[i]], dtype=np.intp)
        self.angles = np.array([i for i in kept if space.angle_mask[i]], dtype=np.intp)
        self._as_it_is = len(self.plain) == len(space)
        self._plain, self._angles = _of_run(self.plain), _of_run(self.angles)
        self.names = (
            *(space.names[i] for i in self.plain),
            *(f"cos({space.names[i]})" for i in self.angles),
            *(f"sin({space.names[i]})" for i in self.angles),
        )

    def __len__(self) -> int:
        return len(self.names)

    def __call__(self, state: NDArray) -> NDArray:
        """Features of states, shape (..., n_variables) -> (..., n_features). Works on AutoDiffXd arrays too."""
        parts = self.parts(state)
        return parts[0] if len(parts) == 1 else np.concatenate(parts, axis=-1)

    def parts(self, state: NDArray) -> list[NDArray]:
        """The features of states in pieces, in their order, to be joined by whoever has more to join them with."""
        if self._as_it_is:
            return [state]
        plain = state[..., self._plain]
        if not len(self.angles):
            return [plain]
        angles = state[..., self._angles]
        return [plain, np.cos(angles), np.sin(angles)]

    def jacobian(self, state: FloatArray) -> FloatArray:
        """Derivative of the features by the state, shape (..., n_features, n_variables)."""
        out = np.empty((*state.shape[:-1], *self._of_plain.shape))
        out[...] = self._of_plain
        n, m = len(self.plain), len(self.angles)
        for i, angle in enumerate(self.angles.tolist()):
            out[..., n + i, angle] = -np.sin(state[..., angle])
            out[..., n + m + i, angle] = np.cos(state[..., angle])
        return out

    def by_state(self, by_features: FloatArray, state: FloatArray) -> FloatArray:
        """The derivative by the state of what has a derivative by the features, `by_features @ jacobian(state)`.

        Args:
            by_features: shape (..., n, n_features).
            state: where, shape (..., n_variables).
        """
        return by_features if self._as_it_is else by_features @ self.jacobian(state)

    @cached_property
    def _of_plain(self) -> FloatArray:
        """Jacobian without the angles' entries."""
        out = np.zeros((len(self), len(self.space)))
        out[np.arange(len(self.plain)), self.plain] = 1.0
        return out


def _of_run(indices: NDArray[np.intp]) -> slice | NDArray[np.intp]:
    """Indices that follow on each other as a slice, with which numpy need not copy."""
    first = int(indices[0]) if len(indices) else 0
    return slice(first, first + len(indices)) if np.array_equal(indices - first, np.arange(len(indices))) else indices


class ChangeCode:
    """How the change from one state to the next is coded as the output of a regression.

    `none`: the next state itself. `raw`: the difference. `body`: the difference, positions turned into the body frame.

    Args:
        space: the observable state space.
        kind: see `FeatureKind`.
    """

    def __init__(self, space: StateSpace, kind: FeatureKind) -> None:
        self.space = space
        self.kind = kind
        self._poses = planar_poses(space) if kind == "body" else []
        self._diagonal = np.arange(len(space))
        self._wraps = bool(space.angle_mask.any())

    def encode(self, state: FloatArray, after: FloatArray) -> FloatArray:
        """Code of a change, shape (..., n_variables), from states of the same shape; angles the short way round."""
        if self.kind == "none":
            return np.array(after, dtype=float)
        delta = self.space.difference(after, state)
        for x, y, h in self._poses:
            c, s = np.cos(state[..., h]), np.sin(state[..., h])
            dx, dy = delta[..., x].copy(), delta[..., y].copy()
            delta[..., x], delta[..., y] = c * dx + s * dy, -s * dx + c * dy
        return delta

    def decode(self, state: NDArray, code: NDArray) -> NDArray:
        """The state that a code leads to; the inverse of `encode`, but for wrapping. AutoDiffXd works too."""
        if self.kind == "none":
            return code
        delta = code.copy()
        for x, y, h in self._poses:
            c, s = np.cos(state[..., h]), np.sin(state[..., h])
            delta[..., x] = c * code[..., x] - s * code[..., y]
            delta[..., y] = s * code[..., x] + c * code[..., y]
        return state + delta

    def jacobians(self, state: FloatArray, code: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Derivatives of `decode` by the state and by the code, each (..., n_variables, n_variables)."""
        n = state.shape[-1]
        by_code = np.zeros((*state.shape[:-1], n, n))
        by_code[..., self._diagonal, self._diagonal] = 1.0
        if self.kind == "none":
            return np.zeros(by_code.shape), by_code
        by_state = by_code.copy()
        for x, y, h in self._poses:
            c, s = np.cos(state[..., h]), np.sin(state[..., h])
            by_code[..., x, x], by_code[..., x, y] = c, -s
            by_code[..., y, x], by_code[..., y, y] = s, c
            by_state[..., x, h] = -s * code[..., x] - c * code[..., y]
            by_state[..., y, h] = c * code[..., x] - s * code[..., y]
        return by_state, by_code

    def wrap(self, state: FloatArray) -> FloatArray:
        """Bring angles back to [-pi, pi)."""
        if not self._wraps:
            return state
        return np.where(self.space.angle_mask, wrap_angle(state), state)
