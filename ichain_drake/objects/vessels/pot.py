"""A pot under a lid: what is poured over it gets in while that is open."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import ClassVar, Unpack

import numpy as np

from ichain_drake.errors import InputError
from ichain_drake.objects.base import ObjectArguments, ParentStates, WorldObject
from ichain_drake.objects.parents import position_indices
from ichain_drake.objects.region import GATE
from ichain_drake.objects.vessels.vessel import AMOUNT_NOISE, CAPACITY
from ichain_drake.state import FloatArray, Role, StateSpace, Variable
from ichain_drake.timing import FRAMES_PER_TICK

_CUT = 0.5
_PAST = FRAMES_PER_TICK - 1


@dataclass(frozen=True)
class PotSettings:
    """What a scenario gives about a pot.

    Attributes:
        lid: name of the parent that covers it; its handle is at `shut` along y when it is shut [m].
        shut: see there.
        middle: of its mouth, y, z in the robot's frame [m].
        over: half-widths of the place over it from where water falls in, along y and z [m].
        height: of the middle of that place above the mouth [m].
        ajar: how far the lid must be open for that [m].
    """

    lid: str = "lid"
    shut: float = 0.0
    middle: tuple[float, float] = (0.0, 0.16)
    over: tuple[float, float] = field(default=(0.05, 0.09), metadata={GATE: True})
    height: float = 0.17
    ajar: float = field(default=0.09, metadata={GATE: True})


class Pot(WorldObject):
    """The pot. Its parents: a vessel that is poured from, and the lid.

    Args:
        pot: see `PotSettings`.
        parents, initial, settings: see `WorldObject`.

    Raises:
        InputError: if they are not one vessel that shows what leaves it, with a position along y and z, and the lid.
    """

    state_space: ClassVar[StateSpace] = StateSpace(
        "pot",
        (
            Variable("water", "1", 0.0, CAPACITY, role=Role("amount")),
            Variable("change", "1", -CAPACITY, CAPACITY, role=Role("change", of="water")),
            Variable("spilled", hidden=True),
            *(Variable(f"past_{k}", hidden=True) for k in range(1, _PAST + 1)),
        ),
    )

    def __init__(
        self,
        name: str,
        parents: Mapping[str, StateSpace],
        pot: PotSettings | None = None,
        **given: Unpack[ObjectArguments],
    ) -> None:
        self.pot = pot or PotSettings()
        givers = [p for p, space in parents.items() if "flow" in space.names]
        if len(givers) != 1 or set(parents) != {*givers, self.pot.lid}:
            raise InputError(
                f"{name}: the parents of a pot are a vessel that is poured from and its lid {self.pot.lid}; got "
                f"{', '.join(parents) or 'none'}"
            )
        (self._giver,) = givers
        theirs = parents[self._giver]
        self._place = position_indices(theirs, "yz", name, self._giver)
        (self._lid,) = position_indices(parents[self.pot.lid], "y", name, self.pot.lid)
        self._flow = theirs.index("flow")
        super().__init__(name, parents, **given)

    def state_at(self, water: float) -> FloatArray:
        """A pot that holds an amount since ever, shape (n_variables,).

        Raises:
            InputError: if the amount is outside 0..1.
        """
        if not 0.0 <= water <= CAPACITY:
            raise InputError(f"{self.get_name()}: amount {water} given; it is between 0 and 1")
        state = np.full(len(self.state_space), water)
        state[1:3] = 0.0
        return state

    def decide_active(
        self, state: FloatArray, parents: ParentStates, active: Mapping[str, bool], touch: float | None
    ) -> Mapping[str, bool]:
        """The lid while it is open; the vessel while its rim is over the open pot."""
        pot, lid = self.pot, self.pot.lid
        slack = {p: 0.004 if active[p] else 0.0 for p in (lid, self._giver)}
        way = float(parents[lid][self._lid]) - pot.shut
        off = np.abs(parents[self._giver][self._place] - np.add(pot.middle, (0.0, pot.height)))
        over = bool((off <= np.add(pot.over, slack[self._giver])).all())
        return {
            lid: way >= pot.ajar - slack[lid],
            self._giver: over and way >= pot.ajar - slack[self._giver],
        }

    def step(
        self, state: FloatArray, parents: ParentStates, active: Mapping[str, FloatArray], noise: FloatArray, dt: float
    ) -> FloatArray:
        """Water comes in, or is spilled."""
        s = np.asarray(state, dtype=float).T
        new, flow = s.copy(), parents[self._giver].T[self._flow]
        taken = np.minimum(np.where(np.asarray(active[self._giver]).T > _CUT, flow, 0.0), CAPACITY - s[0])
        new[0] = s[0] + taken
        new[1] = new[0] - s[-1]
        new[2] += flow - taken
        new[4:] = s[3:-1]
        new[3] = s[0]
        return new.T

    def measure(self, state: FloatArray, noise: FloatArray) -> FloatArray:
        """Amount and change with noise."""
        read = state[..., self._observable] + AMOUNT_NOISE * noise
        return np.clip(read, [0.0, -CAPACITY], CAPACITY)
