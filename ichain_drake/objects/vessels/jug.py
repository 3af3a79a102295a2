"""A jug that hands hold by its rim, and pour from by turning it there."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import ClassVar, Unpack

import numpy as np

from ichain_drake.errors import InputError
from ichain_drake.objects.base import ObjectArguments, ParentStates, WorldObject
from ichain_drake.objects.hands import Hands
from ichain_drake.objects.region import GATE
from ichain_drake.objects.vessels.vessel import AMOUNT_NOISE, CAPACITY
from ichain_drake.state import FloatArray, Role, StateSpace, Variable, wrap_angle
from ichain_drake.timing import FRAMES_PER_TICK

POSITION_NOISE = 0.0015
"""Standard deviation of a reading of the rim's place [m]."""

TILT_NOISE = 0.01
"""Standard deviation of a reading of the tilt [rad]."""

_POUR_RATE = 2.0  # 1/s; what is too much leaves exponentially
_DROPS = 1e-6  # less stays in
_LIFTED = 0.02  # m above what is below: only then a grasp slips
_CUT = 0.5
_PAST = FRAMES_PER_TICK - 1


@dataclass(frozen=True)
class JugSettings:
    """What a scenario gives about a jug.

    Attributes:
        height: of its rim above its bottom [m].
        reach: how far from the rim, along y and z, a hand that closes takes it [m].
        holds_to: tilt at which a full one begins to pour [rad].
        emptying: how much more until nothing stays in [rad].
        blocks: what it can stand on beside the table: from and to along y, and height [m].
        slips: times from which on the hand loses it, as soon as it is in the air [s].
    """

    height: float = 0.12
    reach: tuple[float, float] = field(default=(0.02, 0.025), metadata={GATE: True})
    holds_to: float = 0.3
    emptying: float = 1.5
    blocks: tuple[tuple[float, float, float], ...] = ()
    slips: tuple[float, ...] = ()


class Jug(WorldObject):
    """The jug, by the place of its rim and how far it is tilted there. Its parents are hands.

    What left it in the last frame is hidden in `flow`: whatever is below takes it, or it is spilled.

    Args:
        jug: see `JugSettings`.
        parents, initial, settings: see `WorldObject`.

    Raises:
        InputError: if there is no parent, or one is no hand.
    """

    state_space: ClassVar[StateSpace]

    @staticmethod
    def space(hands: tuple[str, ...] = ("hand",)) -> StateSpace:
        """The state space of a jug that certain hands may hold."""
        place = [Variable(a, "m", -2.0, 2.0, role=Role("position", "robot", a)) for a in "yz"]
        tilt = Variable("tilt", "rad", -math.pi, math.pi, "angle", Role("orientation", "robot", "x"))
        amounts = (
            Variable("water", "1", 0.0, CAPACITY, role=Role("amount")),
            Variable("change", "1", -CAPACITY, CAPACITY, role=Role("change", of="water")),
        )
        names = ["off_y", "off_z", "roll_off", "flow", "age", "slips_done", *(f"past_{k}" for k in range(1, _PAST + 1))]
        hidden = [Variable(n, hidden=True) for n in names]
        holds = [Variable(f"held_{h}", "1", 0.0, 1.0, "binary", hidden=True) for h in hands]
        return StateSpace("jug", (*place, tilt, *amounts, *hidden, *holds, *Hands.variables(hands)))

    def __init__(
        self,
        name: str,
        parents: Mapping[str, StateSpace],
        jug: JugSettings | None = None,
        **given: Unpack[ObjectArguments],
    ) -> None:
        self.jug = jug or JugSettings()
        self.state_space = space = self.space(tuple(parents))  # type: ignore[misc]
        self._hands = Hands(name, space, parents, self.jug.reach)
        self._turned = {}
        for hand, theirs in parents.items():
            turns = [i for i in theirs.role_indices("orientation") if theirs.variables[i].role.axis == "x"]  # type: ignore[union-attr]
            if not turns:
                raise InputError(f"{name}: its parent {hand} can't be turned about x")
            self._turned[hand] = int(turns[0])
        index = space.index
        self._water, self._flow, self._past = index("water"), index("flow"), index("past_1")
        self._off, self._turn = index("off_y"), index("roll_off")
        self._age, self._slips_done = index("age"), index("slips_done")
        self._holding = {h: index(f"held_{h}") for h in parents}
        super().__init__(name, parents, **given)

    def state_at(self, y: float, water: float, hand: str = "", z: float | None = None) -> FloatArray:
        """An upright jug that stands on the table, or that a hand holds.

        Args:
            y: of its rim, in the robot's frame [m].
            water: amount, 0 to 1.
            hand: that holds it there; none if empty.
            z: of its rim [m]; where it stands if None.

        Returns:
            shape (n_variables,).

        Raises:
            InputError: if the amount is outside 0..1.
        """
        if not 0.0 <= water <= CAPACITY:
            raise InputError(f"{self.get_name()}: amount {water} given; it is between 0 and 1")
        state = np.zeros(len(self.state_space))
        state[:2] = y, self.jug.height if z is None else z
        state[[self._water, *range(self._past, self._past + _PAST)]] = water
        if hand:
            state[self._holding[hand]] = 1.0
        return state

    def default_state(self) -> FloatArray:
        """Empty, upright at the robot's origin."""
        return self.state_at(0.0, 0.0)

    def support(self, y: FloatArray, z: FloatArray) -> FloatArray:
        """Height of what is below a jug whose rim is somewhere [m], shape (...)."""
        below: FloatArray = np.zeros_like(y)
        for low, high, height in self.jug.blocks:
            over = (low <= y) & (y <= high) & (z - self.jug.height > height - 0.5 * self.jug.height)
            below = np.where(over, np.maximum(below, height), below)
        return below

    def decide_active(
        self, state: FloatArray, parents: ParentStates, active: Mapping[str, bool], touch: float | None
    ) -> Mapping[str, bool]:
        """A hand, from closing around the rim until it opens, or until it slips."""
        was = {h: active[h] or bool(state[i] > _CUT) for h, i in self._holding.items()}
        if any(was.values()) and self._slips_now(state):
            return dict.fromkeys(was, False)
        return self._hands.holding(state, parents, was)

    def _slips_now(self, state: FloatArray) -> bool:
        due = sum(time <= state[self._age] for time in self.jug.slips) > state[self._slips_done]
        bottom = state[1] - self.jug.height
        return bool(due and bottom - float(self.support(*np.array(state[:2]))) > _LIFTED)

    def settle(self, state: FloatArray, parents: ParentStates, active: Mapping[str, bool]) -> FloatArray:
        """A held jug is where the hand has it, a released one upright on what is below."""
        new = np.array(state, dtype=float)
        s = new.T
        below = self.support(s[0], s[1]) + self.jug.height
        for hand, index in self._holding.items():
            held, was = np.asarray(active[hand]).T > _CUT, s[index] > _CUT
            place = parents[hand].T[self._hands.places[hand]]
            roll = parents[hand].T[self._turned[hand]]
            begins, falls = held & ~was, was & ~held
            s[self._off : self._off + 2] = np.where(begins, s[:2] - place, s[self._off : self._off + 2])
            s[self._turn] = np.where(begins, wrap_angle(roll - s[2]), s[self._turn])
            moved = place + s[self._off : self._off + 2]
            moved[1] = np.maximum(moved[1], self.jug.height * np.maximum(np.cos(s[2]), 0.0))  # the table stops it
            s[:2] = np.where(held, moved, s[:2])
            s[2] = np.where(held, wrap_angle(roll - s[self._turn]), np.where(falls, 0.0, s[2]))
            s[1] = np.where(falls, below, s[1])
            lost = falls & (parents[hand].T[self._hands.grips[hand]] > _CUT)
            s[self._slips_done] += lost
            s[index] = held
        self._hands.remember(new, parents)
        return new

    def stays(self, tilt: FloatArray) -> FloatArray:
        """How much it holds as it is tilted, shape (...)."""
        over = (np.abs(tilt) - self.jug.holds_to) / self.jug.emptying
        return np.clip(1.0 - over, 0.0, 1.0) * CAPACITY

    def step(
        self, state: FloatArray, parents: ParentStates, active: Mapping[str, FloatArray], noise: FloatArray, dt: float
    ) -> FloatArray:
        """Water runs out as far as it is tilted."""
        s = np.asarray(state, dtype=float).T
        new, i, past = s.copy(), self._water, self._past
        out = np.maximum(s[i] - self.stays(s[2]), 0.0) * (1.0 - math.exp(-_POUR_RATE * dt))
        new[self._flow] = np.where(out > _DROPS * dt, out, 0.0)
        new[i] = s[i] - new[self._flow]
        new[i + 1] = new[i] - s[past + _PAST - 1]
        new[past + 1 : past + _PAST] = s[past : past + _PAST - 1]
        new[past] = s[i]
        new[self._age] += dt
        return new.T

    def measure(self, state: FloatArray, noise: FloatArray) -> FloatArray:
        """Place, tilt and content with noise."""
        std = np.array([POSITION_NOISE] * 2 + [TILT_NOISE] + [AMOUNT_NOISE] * 2)
        read = state[..., self._observable] + std * noise
        read[..., 2] = wrap_angle(read[..., 2])
        read[..., 3:] = np.clip(read[..., 3:], [0.0, -CAPACITY], CAPACITY)
        return read


Jug.state_space = Jug.space()
