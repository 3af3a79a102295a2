"""Predictive intervals of one tick that cover what they say, whatever the distribution of residuals is.

Planning and control read the spreads themselves (`InteractionModel.spread`), as one normal distribution a variable.
Where residuals are not normal (a pour that begins in the middle of a tick, a mixture that is read badly while there is
little of it), an interval made of a spread covers too much or too little; these are scaled by what was measured.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ichain_drake.demonstrations import Demonstration, data_hash
from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction
from ichain_drake.learning.calibration import checked_level, conformal_factor
from ichain_drake.learning.model import InteractionModel
from ichain_drake.learning.residuals import Part, tick_scores
from ichain_drake.learning.spreads import spread_of
from ichain_drake.state import FloatArray


@dataclass(frozen=True)
class Intervals:
    """Conformal intervals of a model's predictions; make them by `conformal_intervals`.

    Attributes:
        model: what predicts.
        scores: sizes of residuals over spreads, on pieces that were set aside, shape (n,) for each part.
    """

    model: InteractionModel
    scores: Mapping[Part, FloatArray]

    def factor(self, part: Part, level: float) -> float:
        """By what the spread of a part is multiplied; infinite where too few rows show it for that level.

        Args:
            part: of the model.
            level: share to cover, in (0, 1).

        Raises:
            InputError: on a level outside (0, 1).
        """
        return conformal_factor(self.scores.get(part, np.zeros(0)), level)

    def half_width(self, child: str, active: Collection[Interaction], level: float) -> FloatArray:
        """How far to either side of the predicted state the next reading lies at most, shape (n_variables,).

        Args:
            child: the object.
            active: the interactions that act on it.
            level: share to cover, in (0, 1).

        Returns:
            In the variables' units; NaN for variables that can't change gradually, which have no interval, and infinite
            where the pieces that were set aside show too little.

        Raises:
            InputError: on a level outside (0, 1), an object or interaction that nothing was learned about, or a model
                of a chain, whose links know a spread of every row: use `factor`.
        """
        checked_level(level)
        model = self.model.for_goals()
        if child not in model.passive:
            raise InputError(f"{child}: nothing predicts it; there are intervals of {', '.join(model.passive)}")
        for edge in active:
            if edge not in model.edges or edge.child != child:
                into = ", ".join(e.name for e in model.graph.incoming(child))
                raise InputError(f"{getattr(edge, 'name', edge)!s} does not act on {child}; {into} do")
        acting = {e: model.edges[e] for e in active}
        spread, source = spread_of(model.passive[child], acting, model.noise[child])
        jumps = model.graph.objects[child].observable.jump_mask
        factors = [np.nan if jumps[i] else self.factor(Part(child, i, s), level) for i, s in enumerate(source)]
        return np.asarray(spread * factors)


def conformal_intervals(model: InteractionModel, pieces: Sequence[Demonstration]) -> Intervals:
    """Intervals by the residuals of pieces that were set aside (split conformal prediction).

    Args:
        model: the learned model.
        pieces: that it was not learned from, and that show each interaction.

    Raises:
        InputError: if there are none, if they are the pieces that the model was learned from, whose residuals are too
            small, or if they can't be read as the graph's.
    """
    if pieces and data_hash(pieces) == model.demonstrations_sha256:
        raise InputError("the model was learned from these pieces: their residuals are too small; give it others")
    return Intervals(model, {part: np.sort(found.sizes) for part, found in tick_scores(model, pieces).items()})
