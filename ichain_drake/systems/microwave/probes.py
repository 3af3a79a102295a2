"""States around the borders of the microwave oven's interactions, for the evaluation of classifiers alone."""

from __future__ import annotations

from collections.abc import Mapping
from typing import cast

import numpy as np

from ichain_drake.graph import Interaction
from ichain_drake.objects import WorldObject
from ichain_drake.objects.parts.food import POSITION_NOISE, Food
from ichain_drake.objects.parts.oven_part import OvenPart
from ichain_drake.scenarios.border_probes import BorderProbes, Move, State, drawn
from ichain_drake.state import FloatArray
from ichain_drake.systems.microwave.layout import LAYOUT

_STANDING = 0.01  # m above what is below it


class OvenProbes(BorderProbes):
    """Makes the probes of the microwave oven; see `BorderProbes`."""

    def borders(self, edge: Interaction) -> Mapping[str, Move]:
        """See `BorderProbes`.

        Heating has no border of the food's place: no food is in a shut doorway, and none in a wall.
        """
        child = self.objects[edge.child]
        if edge.parent == self.hand:
            # Between bodies contact decides, and no box: fingers that are off by a little touch all the same.
            if self.scenario.physics == "contact":
                return {}
            if isinstance(child, OvenPart):
                return {self.hand: lambda s, rng: self._beside_part(edge.child, s, rng)}
            door = cast("Food", child).food.oven.door
            return {
                self.hand: lambda s, rng: self._beside_food(edge.child, s, rng),
                door: lambda s, rng: self._behind_door(edge.child, s, rng),
            }
        oven = cast("Food", child).food.oven
        if edge.parent == oven.door:
            return {edge.child: lambda s, rng: self._over_doorstep(edge.child, s, rng)}
        return {
            oven.door: lambda s, rng: self._slide(oven.door, 0.0, oven.shut_until, s, rng),
            oven.button: lambda s, rng: self._slide(oven.button, oven.on_from, LAYOUT.button.travel, s, rng),
        }

    def reread(self, system: WorldObject, value: FloatArray, full: FloatArray, rng: np.random.Generator) -> None:
        """Place of the food, coordinates of the parts."""
        scale = self.scenario.config.noise.scale
        if isinstance(system, Food):
            value[:3] += scale * POSITION_NOISE * rng.standard_normal(3)
        else:
            value[:] = system.measure(full, scale * rng.standard_normal(len(value)))

    def _beside_part(self, name: str, state: State, rng: np.random.Generator) -> bool:
        """A closed hand near where a part is grasped."""
        part = cast("OvenPart", self.objects[name])
        point = part.grasp_point(float(state[name][part.coordinate_index]))
        state[self.hand][self.hand_place] = drawn(point, part.mount.reach, rng)
        return True

    def _beside_food(self, name: str, state: State, rng: np.random.Generator) -> bool:
        """A closed hand near standing food."""
        food = cast("Food", self.objects[name])
        place = self.camera.to_robot(state[name][:3])
        floor = float(food.support(*place)) + food.food.height / 2
        if place[2] - floor > _STANDING:
            return False
        place[2] = floor
        state[name][:3] = self.camera.from_robot(place)
        grasp = food.food.grasp
        state[self.hand][self.hand_place] = place + drawn(grasp.center, grasp.half, rng)
        return True

    def _behind_door(self, name: str, state: State, rng: np.random.Generator) -> bool:
        """The door around where it begins to let the hand in, with food in its way that the hand is at."""
        oven, place = cast("Food", self.objects[name]).food.oven, self.camera.to_robot(state[name][:3])
        if not oven.doorway.holds(place.tolist()):
            return False
        return self._slide(oven.door, oven.open_from, LAYOUT.door.travel, state, rng)

    def _over_doorstep(self, name: str, state: State, rng: np.random.Generator) -> bool:
        """Food further in, or further out and over the doorstep: the one border that no wall is at, nor a shut door."""
        food = cast("Food", self.objects[name]).food
        if self._coordinate(food.oven.door, state) < food.oven.open_from:
            return False
        place, hand = self.camera.to_robot(state[name][:3]), state[self.hand]
        held = bool(hand[-1]) and food.grasp.holds((hand[self.hand_place] - place).tolist(), True)
        (middle, _, _), (half, _, _) = food.oven.cavity.center, food.oven.cavity.half
        way = float(drawn([middle], [half], rng)[0]) - place[0]
        place[0] += way
        if place[0] > middle + half or (not held and place[0] < LAYOUT.front):
            return False  # the back wall; or it would fall down the doorstep
        if held:
            hand[self.hand_place[0]] += way
        state[name][:3] = self.camera.from_robot(place)
        return True

    def _coordinate(self, name: str, state: State) -> float:
        return float(state[name][cast("OvenPart", self.objects[name]).coordinate_index])

    def _slide(self, name: str, start: float, end: float, state: State, rng: np.random.Generator) -> bool:
        """A part around a range of its coordinate [m], where it can go, with the hand that holds it."""
        part = cast("OvenPart", self.objects[name])
        at, now = float(drawn([(start + end) / 2], [(end - start) / 2], rng)[0]), self._coordinate(name, state)
        before, after = (np.array(part.grasp_point(c)) for c in (now, at))
        hand = state[self.hand]
        if hand[-1] and (np.abs(hand[self.hand_place] - before) <= part.mount.reach).all():
            hand[self.hand_place] += after - before
        state[name][part.coordinate_index] = at
        return 0.0 <= at <= part.mount.travel
