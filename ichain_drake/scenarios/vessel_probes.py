"""States around the borders of interactions with vessels and buttons, for the evaluation of classifiers alone."""

from __future__ import annotations

from collections.abc import Mapping
from typing import cast

import numpy as np

from ichain_drake.objects import Button, Cup, Region, WorldObject
from ichain_drake.objects.parts.button import LEVELS
from ichain_drake.objects.vessels.cup import POSITION_NOISE
from ichain_drake.scenarios.border_probes import BorderProbes, Move, State, drawn
from ichain_drake.state import FloatArray

_STANDING = 0.01  # m above what is below it
_UPRIGHT = 0.15  # rad


class VesselProbes(BorderProbes):
    """What the probes of scenarios with vessels and buttons share; see `BorderProbes`.

    Its methods move a state in place, and say whether it can be so.
    """

    def reread(self, system: WorldObject, value: FloatArray, full: FloatArray, rng: np.random.Generator) -> None:
        """Place of a vessel, level of a button."""
        scale = self.scenario.config.noise.scale
        if isinstance(system, Cup):
            value[:3] += scale * POSITION_NOISE * rng.standard_normal(3)
        elif isinstance(system, Button):
            value[:] = system.measure(full, scale * rng.standard_normal(1))

    def beside(self, name: str) -> Mapping[str, Move]:
        """Borders between the hand and a vessel or button, by the object that is moved; none in `contact`.

        Between bodies contact decides, and no box: fingers that are off by a little touch all the same.

        Args:
            name: of the vessel or button.
        """
        if self.scenario.physics == "contact":
            return {}
        near = self.beside_vessel if isinstance(self.objects[name], Cup) else self.beside_button
        return {self.hand: lambda s, rng: near(name, s, rng)}

    def beside_vessel(self, name: str, state: State, rng: np.random.Generator) -> bool:
        """A closed hand near a standing vessel."""
        vessel = cast("Cup", self.objects[name])
        rim = self.camera.to_robot(state[name][:3])
        floor = float(vessel.support(*rim)) + vessel.cup.height
        if rim[2] - floor > _STANDING or abs(state[name][3]) > _UPRIGHT:
            return False
        rim[2] = floor
        state[name][:4] = [*self.camera.from_robot(rim), 0.0]
        grasp = vessel.cup.grasp
        state[self.hand][self.hand_place] = rim + drawn(grasp.center, grasp.half, rng, round=grasp.round)
        return True

    def beside_button(self, name: str, state: State, rng: np.random.Generator) -> bool:
        """A hand near a button; what lies below the button's travel can't be reached, so that height has no more."""
        button = cast("Button", self.objects[name])
        mount = button.mount
        half = mount.travel / 2
        middle = (*mount.top[:2], mount.touch_height - half)
        place = drawn(middle, (mount.reach, mount.reach, half), rng, round=True)
        if place[2] < middle[2] - half:
            return False
        state[self.hand][self.hand_place] = place
        modes = button.decide_active(np.zeros(2), self.full(state), {self.hand: False}, None)
        active = {p: np.float64(on) for p, on in modes.items()}
        state[name] = button.settle(np.zeros(2), self.full(state), active)[button.state_space.observable_indices]  # type: ignore[arg-type]
        return True

    @staticmethod
    def press(name: str, state: State, rng: np.random.Generator) -> bool:
        """A level that triggers, or the highest that does not: the only one within half a half-width of 4 to 6."""
        state[name][:] = rng.integers(LEVELS // 2, LEVELS + 1)
        return True

    def put_down(self, name: str, region: Region, floor: float, state: State, rng: np.random.Generator) -> bool:
        """A vessel in and around a region over what it stands on, or held upright a little above that.

        Args:
            name: of the vessel.
            region: of its mouth.
            floor: height of what it stands on [m].
            state: moved in place.
            rng: draws the place.
        """
        cup = cast("Cup", self.objects[name]).cup
        lowest = floor + cup.height
        rim = drawn(region.center, region.half, rng, round=region.round)
        vessel = state[name]
        held = self.holds(name, state)
        if not held:
            rim[2] = lowest
        if rim[2] < lowest or abs(vessel[3]) > _UPRIGHT:
            return False
        if held:
            self.carry(name, rim, state)
        else:
            vessel[:3] = self.camera.from_robot(rim)
        vessel[3] = 0.0
        return True

    def holds(self, name: str, state: State) -> bool:
        """Whether a closed hand is so near a vessel that it must hold it: nearer to its mouth than mouth and bottom."""
        cup, hand = cast("Cup", self.objects[name]).cup, state[self.hand]
        apart = np.linalg.norm(hand[self.hand_place] - self.camera.to_robot(state[name][:3]))
        return bool(apart < np.linalg.norm([*cup.mouth, cup.height]) and hand[-1])

    def carry(self, name: str, mouth: FloatArray, state: State) -> None:
        """Vessel and hand move together, until its mouth is at a place of the robot's frame, shape (3,) [m]."""
        moved = mouth - self.camera.to_robot(state[name][:3])
        state[self.hand][self.hand_place] += moved
        state[name][:3] = self.camera.from_robot(mouth)
