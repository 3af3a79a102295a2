"""Hands the plan of a frame to the plant step by step, in C++ alone."""

from __future__ import annotations

import numpy as np
from pydrake.systems.framework import Context
from pydrake.systems.primitives import LinearSystem

from ichain_drake.state import FloatArray


class Playout(LinearSystem):
    """A shift register, with the plant's period, of desired positions of a frame's steps.

    With rows x_0 (the last row played), x_1 ... x_m and input rows u_1 ... u_m+1 for m steps a frame:

        played = x_1 + u_1,  x_0' = played,  x_i' = x_i+1 + u_i+1,  x_m' = x_m + u_m+1

    An input that is the difference to what the register holds at the frame's first step, and zero at the others, is
    played from that very step on, row by row; the last row stays. Drake's own linear system does it, since nothing
    else in C++ selects by time.

    Ports: input, (steps + 1) x width numbers; output: positions of the first n_joints columns,
    their velocities (the difference to the last row), the other columns, and as many zeros.

    Args:
        n_joints: columns with velocity.
        n_fingers: columns without.
        steps: steps a frame.
        step: [s].
        row: what all rows hold at first, shape (width,).
    """

    def __init__(self, n_joints: int, n_fingers: int, steps: int, step: float, row: FloatArray) -> None:
        width = n_joints + n_fingers
        one, joints = np.eye(width), np.eye(n_joints, width)
        fingers = np.eye(n_fingers, width, n_joints)
        shift = np.eye(steps + 1, k=1)
        shift[-1, -1] = 1.0
        load = np.eye(steps + 1)
        first = np.eye(1, steps + 1, 1)
        last = np.eye(1, steps + 1)
        none = np.zeros((n_fingers, (steps + 1) * width))
        c = [np.kron(first, joints), np.kron(first - last, joints) / step, np.kron(first, fingers), none]
        d = [np.kron(last, joints), np.kron(last, joints) / step, np.kron(last, fingers), none]
        super().__init__(
            A=np.kron(shift, one),
            B=np.kron(load, one),
            C=np.vstack(c),
            D=np.vstack(d),
            time_period=step,
        )
        self._rows = steps + 1
        self.configure_default_state(np.tile(row, self._rows))

    def set_rows(self, context: Context, row: FloatArray) -> None:
        """Let every row hold the same, shape (width,): at rest."""
        context.SetDiscreteState(np.tile(row, self._rows))

    def played(self, context: Context) -> FloatArray:
        """The positions that the plant was given at the last step, shape (width,)."""
        values = context.get_discrete_state_vector().value()
        return values[: len(values) // self._rows].copy()
