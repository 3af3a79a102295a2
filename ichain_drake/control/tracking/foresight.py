"""Where a chain will be when a command begins to act: what was measured is old by then."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.linalg import fractional_matrix_power

from ichain_drake.learning.chain.chain import LearnedChain, LearnedLink
from ichain_drake.state import FloatArray, wrap_angle


def foreseen(chain: LearnedChain, states: Sequence[FloatArray], command: FloatArray, ticks: float) -> list[FloatArray]:
    """States of all objects of a chain a while later, under the command that is in force.

    Whole ticks by the learned models; of a tick's part by the flow that, after a whole tick, is the model linearised:
    what settles quickly has then settled, what moves steadily has gone that part of the way. Within a tick parents
    have come to where they were sent, since a hand moves at the beginning of one; and what is told by its parent alone
    is where its parent brings it.

    Args:
        chain: the learned chain.
        states: robot first, shape (n, n_variables) each.
        command: where the hand was sent last, shape (n, n_hand).
        ticks: how much later, any number from 0.
    """
    now = list(states)
    while ticks > 0:
        part, after = min(1.0, ticks), [np.asarray(command, dtype=float)]
        for k, link in enumerate(chain.links):
            after.append(_later(link, now[k + 1], now[k] if part == 1.0 else after[k], after[k], part))
        now, ticks = after, ticks - part
    return now


def _later(
    link: LearnedLink, child: FloatArray, parent: FloatArray, parent_next: FloatArray, part: float
) -> FloatArray:
    model = link.forward.model
    if part == 1.0 or model.features == "none":
        return model.predict(child, parent, parent_next)
    ahead, slope, *_ = model.linearize(child, parent, parent_next)
    space = model.child_space
    there = child + np.stack(
        [_part_of_flow(a, c, part) for a, c in zip(slope, space.difference(ahead, child), strict=True)]
    )
    return np.where(space.angle_mask, wrap_angle(there), there)


def _part_of_flow(slope: FloatArray, change: FloatArray, part: float) -> FloatArray:
    """Displacement after a part of a tick under the affine map z -> slope z + change, from 0, shape (n,).

    The map's power (Higham & Lin 2011); its real part, since a learned slope may turn over what decays within a tick.
    """
    n = len(change)
    affine = np.block([[slope, change[:, None]], [np.zeros((1, n)), np.ones((1, 1))]])
    return np.real(fractional_matrix_power(affine, part))[:n, n]
