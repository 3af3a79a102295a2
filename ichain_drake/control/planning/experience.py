"""What an execution has shown so far, for the plans that are made on the way.

What it contradicted: an option that failed where it was predicted to work is less likely to work there. An option is a
chain with what it drives or where it carries its object; where it failed is the state it began in. With a flat prior on
the probability p that it works in that region, n failures make the mean of p 1 / (n + 2): the expected time of an
option is its time over p, and each failure makes the next try another one (another demonstrated grasp, another way of
holding). So no plan is ever repeated as it was. What failed twice has a reason that the model doesn't know: it is left
until nothing else is found, and what can be brought elsewhere is brought where such a step was shown to work.

And where objects stood by themselves: there they stay when they are brought back, wherever anybody let go of them in
demonstrations.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from ichain_drake.control.planning.model import span
from ichain_drake.control.planning.plan import PlanStep, States
from ichain_drake.control.planning.travel import jumping
from ichain_drake.control.settings import PLANNING
from ichain_drake.graph import Interaction
from ichain_drake.learning.model import InteractionModel
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import FloatArray


@dataclass(frozen=True, eq=False)
class Contradiction:
    """A step that did not do what was predicted.

    Attributes:
        step: of a plan.
        began: states in which it began, shape (n_variables,) each.
        no_way: `to it` where the robot found no way to what the step begins with, `with it` where it found none once
            it held that, else empty. Anything that stood anywhere may have been in the way.
    """

    step: PlanStep
    began: States
    no_way: Literal["", "to it", "with it"] = ""


@dataclass(frozen=True, eq=False)
class Experience:
    """What an execution has shown so far.

    Attributes:
        contradictions: steps that did not do what was predicted; no plan is made again as it was.
        cautious: interactions that failed where their classifier saw no reason. They are used only as they were shown,
            under their customary conditions; where there is no such plan, as without.
        stood: by object, measured states in which it was seen to stand by itself, shape (n_variables,) each.
    """

    contradictions: tuple[Contradiction, ...] = ()
    cautious: tuple[Interaction, ...] = ()
    stood: Mapping[str, tuple[FloatArray, ...]] = field(default_factory=dict)


class Record:
    """All contradictions of an execution, asked about options.

    Args:
        model: the learned graph.
        contradictions: so far.
        final: whether what failed for a reason is left; else nothing is, since no other plan was found.
    """

    def __init__(
        self, model: InteractionModel, contradictions: Sequence[Contradiction] = (), *, final: bool = True
    ) -> None:
        self._model, self._all, self._final = model, tuple(contradictions), final

    def failures(self, step: PlanStep, states: States) -> int | None:
        """How often an option failed in states like these; None where it is left, since that has a reason.

        It has where the robot found no way, of which several ends were asked for, and where a second try failed, too.

        Args:
            step: the option.
            states: in which it is to begin, shape (n_variables,) each.
        """
        alike = [c for c in self._all if self._same(c, step) and self._alike(c, states)]
        return None if self._final and (len(alike) > 1 or any(c.no_way for c in alike)) else len(alike)

    def doubted(self, states: States) -> frozenset[Interaction]:
        """Interactions of chains that did not do what was predicted in states like these, of shape (n_variables,)."""
        failed = (c.step.chain for c in self._all if not c.no_way and self._alike(c, states))
        return frozenset(e for chain in failed for e in chain)

    def _same(self, past: Contradiction, other: PlanStep) -> bool:
        one = past.step
        if past.no_way == "to it" and one.chain[0] == other.chain[0]:
            return True  # whatever is to be done with it
        if one.chain != other.chain or (one.until is None) != (other.until is None):
            return False
        if one.until is not None and other.until is not None:
            # Held still, a chain does all that it does at once; whichever variable says when to stop, it is one option.
            return one.motion is None or one.until[2] == other.until[2]
        return one.wanted.keys() == other.wanted.keys() and all(
            abs(one.wanted[k] - other.wanted[k]) <= self._width(k[0])[self._index(*k)] for k in one.wanted
        )

    def _alike(self, past: Contradiction, states: States) -> bool:
        """Whether all that the chain's interactions may depend on is where it was, but the robot.

        Nor what a motion moves on the way: it is the same motion wherever in it the objects are.
        """
        moved = {e.child for e in past.step.chain[:-1]} if past.step.motion is not None else set()
        around = _around(self._model, past.step.chain[:1] if past.no_way == "to it" else past.step.chain)
        for name in self._model.passive if past.no_way else around:
            if name in moved:
                continue
            space = self._model.graph.objects[name].observable
            off = np.abs(space.difference(states[name], past.began[name]))
            far = off > np.where(jumping(space), 0.0, self._width(name))
            if far.any() if name in around else far[space.role_indices("position")].any():
                return False
        return True

    def _width(self, name: str) -> np.ndarray:
        return np.maximum(LEARNING.near * span(self._model, name), PLANNING.noises * self._model.noise[name])

    def _index(self, obj: str, variable: str) -> int:
        return self._model.graph.objects[obj].observable.index(variable)


def expected_ticks(ticks: int, failures: int) -> int:
    """Time that an option takes until it works, after some failures in the region, relative to one without."""
    return int(np.ceil(0.5 * ticks * (failures + 2)))


def _around(model: InteractionModel, chain: Sequence[Interaction]) -> list[str]:
    """Objects that the interactions of a chain may depend on, but the robot."""
    names = {n for e in chain for n in model.suspects(e)}
    return sorted(names.difference(model.graph.roots))
