"""A cup of water: a hand moves and tilts it, a dispenser or another cup fills it (paper sec. VI)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import ClassVar, Unpack

import numpy as np

from ichain_drake.errors import InputError
from ichain_drake.objects.base import ObjectArguments, ParentStates, WorldObject
from ichain_drake.objects.camera import FRAME as CAMERA
from ichain_drake.objects.fault_clock import FaultClock
from ichain_drake.objects.hand_reading import HandReading
from ichain_drake.objects.parents import hand_among, position_indices
from ichain_drake.objects.touch import TouchRule
from ichain_drake.objects.vessels.cup_settings import CupSettings
from ichain_drake.objects.vessels.vessel import (
    AMOUNT_NOISE,
    CAPACITY,
    Exchange,
    bookkeeping,
    contents,
    fill,
    vessels,
)
from ichain_drake.state import BoolArray, FloatArray, Role, StateSpace, Variable, wrap_angle

POSITION_NOISE = 0.0015
"""Standard deviation of a reading of the position [m]."""

TILT_NOISE = 0.01
"""Standard deviation of a reading of the tilt [rad]."""

UPRIGHT = 0.3
"""Tilt up to which a vessel catches water, and loses none when it is let go [rad]."""

_POUR_RATE = 2.0  # 1/s; what is too much leaves exponentially
_DROPS = 1e-6  # less stays in
_LIFTED = 0.02  # m above its support: only then a grasp slips
_TOUCH = TouchRule(2.0, 0.5)
_CUT = 0.5

_ATTACHMENT = ("lean", "held", "offset_x", "offset_y", "offset_z", "axis_x", "axis_y", "axis_z", "grip", "age")


class Cup(WorldObject):
    """The cup. Its parents: one hand, the tanks that dispense into it, and the vessels that are poured into it.

    Its position is that of its mouth, the middle of its rim, in the camera's frame, `tilt` its inclination about the
    axis that a hand pours about (the robot's x axis; paper sec. VI: theta). Hidden are `lean`, the inclination about
    the other axis, and the grasp: whether and where in the hand's frame the cup is held.

    Args:
        cup: see `CupSettings`.
        parents, initial, settings: see `WorldObject`.

    Raises:
        InputError: if there is not exactly one hand, or a parent that gives water has neither outlet nor inlet.
    """

    state_space: ClassVar[StateSpace]
    _heaters: tuple[str, ...] = ()  # parents that are neither hand nor vessel

    @staticmethod
    def space(givers: Sequence[str] = ("tank",)) -> StateSpace:
        """The state space of a cup that certain tanks dispense, or vessels are poured into."""
        pose = [Variable(a, "m", role=Role("position", CAMERA, a), measured_in="plant") for a in ("x", "y", "z")]
        tilt = Variable(
            "tilt", "rad", -math.pi, math.pi, "angle", Role("orientation", CAMERA, "x"), measured_in="plant"
        )
        hidden = [
            Variable(n, hidden=True, measured_in="plant" if n == "lean" else "")
            for n in (*_ATTACHMENT, "slips_done", "knocks_done")
        ]
        return StateSpace("cup", (*pose, tilt, *contents("water"), *hidden, *bookkeeping(givers)))

    def __init__(
        self,
        name: str,
        parents: Mapping[str, StateSpace],
        cup: CupSettings | None = None,
        **given: Unpack[ObjectArguments],
    ) -> None:
        self.cup = cup or CupSettings()
        tanks = vessels(parents)
        self._hand = hand_among(parents, [*tanks, *self._heaters], name, "a cup")
        for tank in tanks:
            if (tank in self.cup.outlets) == (tank in self.cup.inlets):
                raise InputError(
                    f"{name}: no outlet is given for its parent {tank}, or an inlet too; name it in "
                    "CupSettings.outlets or CupSettings.inlets"
                )
        self.state_space = self.space(tanks)  # type: ignore[misc]
        super().__init__(name, parents, **given)
        self._read = HandReading(parents[self._hand], name, grips=True)
        self._exchange = Exchange(name, self.state_space, parents)
        self._pourers = {t: position_indices(parents[t], "xyz", name, t) for t in tanks if t in self.cup.inlets}
        index = self.state_space.index
        self._water, self._lean, self._holding = index("water"), index("lean"), index("held")
        self._offset, self._axis = index("offset_x"), index("axis_x")
        self._grip, self._age = index("grip"), index("age")
        self._faults = FaultClock(self.cup.faults, self.state_space)
        self._spilled = index("spilled")

    def state_at(self, mouth: Sequence[float] | FloatArray, water: float, temperature: float) -> FloatArray:
        """An upright cup, not held.

        Args:
            mouth: the middle of the rim, in the robot's frame [m], shape (3,).
            water: amount, 0 to 1.
            temperature: 0 to 1.

        Returns:
            shape (n_variables,).

        Raises:
            InputError: if a value is outside 0..1.
        """
        state = np.zeros(len(self.state_space))
        state[:3] = self.cup.camera.from_robot(np.asarray(mouth, dtype=float))
        fill(self.state_space, state, water, temperature, self.get_name())
        return state

    def default_state(self) -> FloatArray:
        """Empty, upright at the robot's origin."""
        state = np.zeros(len(self.state_space))
        state[:3] = self.cup.camera.from_robot(np.array([*self.cup.mouth, self.cup.height]))
        return state

    def support(self, x: FloatArray, y: FloatArray, z: FloatArray) -> FloatArray:
        """Height of what is below an upright cup [m], for a position of its mouth in the robot's frame [m]."""
        x, y = x - self.cup.mouth[0], y - self.cup.mouth[1]
        below: FloatArray = np.zeros_like(x)
        for s in self.cup.surfaces:
            over = s.reaches(x, y) & (z - self.cup.height > s.height - 0.5 * self.cup.height)
            below = np.where(over, np.maximum(below, s.height), below)
        return below

    def step(
        self, state: FloatArray, parents: ParentStates, active: Mapping[str, FloatArray], noise: FloatArray, dt: float
    ) -> FloatArray:
        """Water runs out as far as the cup is tilted, and in from a dispenser."""
        s = np.asarray(state, dtype=float).T
        water = s[self._water]
        out = np.maximum(water - self.stays(s), 0.0) * (1.0 - math.exp(-_POUR_RATE * dt))
        new = self._exchange.step(s, parents, np.where(out > _DROPS * dt, out, 0.0))
        new[self._grip] = parents[self._hand].T[self._read.grip_index] > _CUT
        new[self._age] += dt
        return new.T

    def stays(self, s: FloatArray) -> FloatArray:
        """How much the cup holds as it is tilted, shape (n_variables, ...) -> (...)."""
        over = (inclination(s[3], s[self._lean]) - self.cup.holds_to) / self.cup.emptying
        return np.minimum(np.maximum(1.0 - over, 0.0), 1.0) * CAPACITY

    def settle(self, state: FloatArray, parents: ParentStates, active: Mapping[str, bool]) -> FloatArray:
        """A held cup is where the hand has it, a released one on what is below; faults happen."""
        new = np.array(state, dtype=float)
        self._exchange.show(new, active)
        if self.settings.body_size:
            return new  # the plant moves it
        held, was = np.asarray(active[self._hand]) > _CUT, new[..., self._holding] > _CUT
        if np.count_nonzero(held | was):
            new = self._carry(new, parents[self._hand], held, was)
        return self._knock(new, held, parents[self._hand]) if self._faults.knocks else new

    def _knock(self, state: FloatArray, held: BoolArray, hand: FloatArray) -> FloatArray:
        s = state.T
        now = self._faults.knock(s, ~held.T, self.cup.camera, self._read.position(hand))
        if np.count_nonzero(now):
            x, y, z = self.cup.camera.to_robot(s[:3].T).T
            stands = np.array([x, y, self.support(x, y, z) + self.cup.height])
            s[:3] = np.where(now, self.cup.camera.from_robot(stands.T).T, s[:3])
        return s.T

    def _carry(self, state: FloatArray, hand: FloatArray, held: BoolArray, was: BoolArray) -> FloatArray:
        s = state.T
        held, was = held.T, was.T
        rim = self.cup.camera.to_robot(state[..., :3]).T
        place = self._read.position(hand)
        # Where the grasp begins, the cup's place and axis in the hand's frame are kept.
        begins = held & ~was
        if np.count_nonzero(begins):
            axis = _axis(s[3], s[self._lean])
            for k, vector in ((self._offset, rim - place), (self._axis, axis)):
                s[k : k + 3] = np.where(begins, self._read.rotate_back(hand, vector), s[k : k + 3])
        s[self._holding] = held
        moved = place + self._read.rotate(hand, s[self._offset : self._offset + 3])
        axis = self._read.rotate(hand, s[self._axis : self._axis + 3])
        tilt = np.arctan2(-axis[1], axis[2])
        lean = np.arcsin(np.minimum(np.maximum(axis[0], -1.0), 1.0))
        falls = was & ~held
        if np.count_nonzero(falls):
            # Let go while tilted, it spills what it holds; then it stands again (nobody could set it up).
            spills = falls & (np.cos(s[3]) * np.cos(s[self._lean]) < math.cos(UPRIGHT))
            w, k = self._water, self._spilled
            s[k] += np.where(spills, s[w], 0.0)
            s[k + 1] += np.where(spills, s[w] * s[w + 1], 0.0)
            s[w] = np.where(spills, 0.0, s[w])
        floor = self.support(rim[0], rim[1], rim[2]) + self.cup.height
        # What it stands on also stops a held cup; a tilted one reaches less far down than an upright one.
        stop = self.support(moved[0], moved[1], moved[2]) + self.cup.height * np.maximum(axis[2], 0.0)
        moved[2] = np.maximum(moved[2], stop)
        rim = np.where(held, moved, np.array([rim[0], rim[1], np.where(falls, floor, rim[2])]))
        s[:3] = np.where(held | falls, self.cup.camera.from_robot(rim.T).T, s[:3])
        s[3] = np.where(held, tilt, np.where(falls, 0.0, s[3]))
        s[self._lean] = np.where(held, lean, np.where(falls, 0.0, s[self._lean]))
        self._faults.slipped(s, falls & (hand.T[self._read.grip_index] > _CUT))
        return s.T

    def decide_active(
        self, state: FloatArray, parents: ParentStates, active: Mapping[str, bool], touch: float | None
    ) -> Mapping[str, bool]:
        """The hand: from closing around the cup until it opens. What gives water: while its mouth and this one meet."""
        rim = self.cup.camera.to_robot(state[:3]).tolist()
        on = {t: region.holds(rim, active[t]) for t, region in self.cup.outlets.items() if t in self.parents}
        upright = bool(self._pourers) and float(inclination(state[3], state[self._lean])) < UPRIGHT
        for vessel, index in self._pourers.items():
            apart = self.cup.camera.to_robot(parents[vessel][index]) - rim
            on[vessel] = upright and self.cup.inlets[vessel].holds(apart.tolist(), active[vessel])
        hand = parents[self._hand]
        on[self._hand] = bool(hand[self._read.grip_index] > _CUT) and self._grasped(state, hand, rim, active, touch)
        return on

    def _grasped(
        self, state: FloatArray, hand: FloatArray, rim: list[float], active: Mapping[str, bool], touch: float | None
    ) -> bool:
        was = active[self._hand]
        if touch is not None:
            return _TOUCH.holds(touch, was)
        if was:
            return not self._slips_now(state, rim)
        relative = (self._read.position(hand) - rim).tolist()
        closes = state[self._grip] < _CUT
        return bool(closes) and self.cup.grasp.holds(relative) and bool(self._read.points_level(hand))

    def _slips_now(self, state: FloatArray, rim: list[float]) -> bool:
        if not self._faults.slips(state):
            return False
        lifted = rim[2] - self.cup.height - float(self.support(*np.array(rim))) > _LIFTED
        return bool(lifted)

    def decide_rows(
        self, state: FloatArray, parents: ParentStates, active: Mapping[str, BoolArray]
    ) -> Mapping[str, BoolArray]:
        """See `DecidesRows`."""
        rim = self.cup.camera.to_robot(state[:, :3]).T
        on = {t: r.holds_rows(rim, active[t]) for t, r in self.cup.outlets.items() if t in self.parents}
        upright = inclination(state[:, 3], state[:, self._lean]) < UPRIGHT if self._pourers else False
        for vessel, index in self._pourers.items():
            apart = self.cup.camera.to_robot(parents[vessel][:, index]).T - rim
            on[vessel] = upright & self.cup.inlets[vessel].holds_rows(apart, active[vessel])
        hand, was = parents[self._hand], active[self._hand]
        around = self.cup.grasp.holds_rows(self._read.position(hand) - rim, np.zeros(len(state), dtype=bool))
        taken = (state[:, self._grip] < _CUT) & around & self._read.points_level(hand)
        lost = self._faults.slips(state.T)
        if np.count_nonzero(lost):
            lost = lost & (rim[2] - self.cup.height - self.support(*rim) > _LIFTED)
        on[self._hand] = (hand[:, self._read.grip_index] > _CUT) & np.where(was, ~lost, taken)
        return on

    def sample_body(self, body: FloatArray) -> FloatArray:
        """Mouth, tilt, lean of a free body [q (w, x, y, z, position); v] whose origin is the middle of its bottom."""
        w, x, y, z = body[..., :4].T
        axis = np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])
        a, b = self.cup.mouth
        rim = body[..., 4:7].T + self.cup.height * axis
        rim += a * np.array([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)])
        rim += b * np.array([2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)])
        rim = self.cup.camera.from_robot(rim.T).T
        tilt, lean = np.arctan2(-axis[1], axis[2]), np.arcsin(np.minimum(np.maximum(axis[0], -1.0), 1.0))
        return np.array([*rim, tilt, lean]).T

    def measure(self, state: FloatArray, noise: FloatArray) -> FloatArray:
        """Pose and content with noise."""
        std = np.array([POSITION_NOISE] * 3 + [TILT_NOISE] + [AMOUNT_NOISE] * 3)
        read = state[..., self._observable] + std * noise
        read[..., 3] = wrap_angle(read[..., 3])
        read[..., 4:] = np.clip(read[..., 4:], [0.0, 0.0, -CAPACITY], CAPACITY)
        return read


Cup.state_space = Cup.space()


def inclination(tilt: FloatArray, lean: FloatArray) -> FloatArray:
    """Angle between the cup's axis and the vertical [rad], shape (...)."""
    return np.arccos(np.minimum(np.maximum(np.cos(tilt) * np.cos(lean), -1.0), 1.0))


def _axis(tilt: FloatArray, lean: FloatArray) -> FloatArray:
    """Direction of the cup's axis in the robot's frame, shape (3, ...)."""
    c = np.cos(lean)
    return np.array([np.sin(lean), -np.sin(tilt) * c, np.cos(tilt) * c])
