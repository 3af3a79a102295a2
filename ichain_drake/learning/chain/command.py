"""What was learned about commanding the hand."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ichain_drake.errors import InputError
from ichain_drake.graph import Origin
from ichain_drake.learning.estimators import make_estimator
from ichain_drake.learning.frozen import FrozenModel, freeze
from ichain_drake.state import FloatArray


@dataclass(frozen=True)
class LearnedCommand:
    """The parts of a learned chain that belong to the robot, saved with the link whose parent it is.

    Attributes:
        map: from a wanted hand state to the command that reaches it, or None where they are the same.
        lower, upper: range of the commands, shape (n_hand,).
        hand_limit: largest change of the hand in one tick, shape (n_hand,).
        origin: what the positions of states and commands are relative to in `map`: the declared origin of the object
            that the hand was at; None where none is declared.
    """

    map: FrozenModel | None
    lower: FloatArray
    upper: FloatArray
    hand_limit: FloatArray
    origin: Origin | None = None


def learn_command(commands: FloatArray, states: FloatArray, degrees: Sequence[int] = (1, 2, 3)) -> FrozenModel | None:
    """The command that brings the hand to a wanted state: corrects what the hand does systematically off.

    Args:
        commands, states: hand commands, and the hand states they led to, shape (n, n_hand).
        degrees: of the polynomials that are tried.

    Returns:
        The map, of the degree with the best cross-validation score; None where it does no better than commanding
        the wanted state itself.
    """
    plain = float(np.mean((commands - states) ** 2))
    best, best_error = None, plain
    for degree in degrees:
        estimator = make_estimator("polynomial", degree=degree)
        try:
            estimator.fit(states, commands)
        except InputError:
            continue
        error = float(np.mean(estimator.residual_std_**2))
        if error < best_error:
            best, best_error = estimator, error
    return None if best is None else freeze(best)
