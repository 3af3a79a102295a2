"""States around the borders of the water dispenser's interactions, for the evaluation of classifiers alone.

A held-out state in which an interaction acts is moved to a place drawn from its region blown up by half, together with
whatever holds or is held; the world's own rules then say whether it still acts. What the demonstrations' sweeps show is
not used, and nothing of this reaches learning or control.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ichain_drake.demonstrations import Demonstration
from ichain_drake.graph import Interaction
from ichain_drake.objects import Button, Cup, WorldObject
from ichain_drake.objects.button import LEVELS
from ichain_drake.objects.cup import POSITION_NOISE
from ichain_drake.scenarios.status_accuracy import Probes
from ichain_drake.scenarios.water_dispenser_layout import LAYOUT
from ichain_drake.state import FloatArray

if TYPE_CHECKING:
    from ichain_drake.scenarios.water_dispenser import WaterDispenser

NEAR = 1.5
"""How far a near miss may lie from a region's middle, in half-widths."""

_STANDING = 0.01  # m above what is below it
_UPRIGHT = 0.15  # rad
_TRIES = 400  # a probe wanted
_PURPOSE = 3

State = dict[str, FloatArray]
Move = Callable[[State, np.random.Generator], bool]


class DispenserProbes:
    """Makes the probes of one scenario.

    Args:
        scenario: the water dispenser.
    """

    def __init__(self, scenario: WaterDispenser) -> None:
        self.scenario, self.graph, self.camera = scenario, scenario.graph, scenario.camera()
        # The rules are those of `ideal`; `arm` has the same, and in `contact` only some edges are asked about.
        world, _ = scenario.build_world(scenario.start(0), 0, "ideal")
        self._objects: dict[str, WorldObject] = {n: world.system(n) for n in self.graph.objects if n != self.graph.root}
        hand = scenario.config.robot.hand
        self._hand = self.graph.root
        self._hand_place = self._place(self._hand)
        self._hand_noise = np.array([hand.noise_std.get(n, 0.0) for n in hand.space.names])

    def make(self, edge: Interaction, pieces: Sequence[Demonstration], count: int) -> Probes | None:
        """See `HasProbes.probes`."""
        move = self._move(edge)
        bases = self._bases(edge, pieces)
        if move is None or not bases:
            return None
        rng = np.random.default_rng([self.scenario.seed, _PURPOSE, self.graph.interactions.index(edge)])
        found: dict[bool, list[State]] = {True: [], False: []}
        for _ in range(_TRIES * count):
            if min(len(v) for v in found.values()) >= count:
                break
            state = {n: v.copy() for n, v in bases[int(rng.integers(len(bases)))].items()}
            if move(state, rng):
                on = self._truth(edge, state)
                if len(found[on]) < count:
                    found[on].append(state)
        true = [*found[True], *found[False]]
        if not found[False]:
            return None
        active = np.array([True] * len(found[True]) + [False] * len(found[False]))
        read = [self._read(edge, state, rng) for state in true]
        gate = np.array([self._truth(edge, state) for state in read])
        names = (edge.child, *self.graph.parents(edge.child))
        stacked = [{n: np.array([s[n] for s in states]) for n in names} for states in (true, read)]
        return Probes(stacked[0], stacked[1], active, gate)

    # What is moved, and where to.

    def _move(self, edge: Interaction) -> Move | None:
        child, parent = self._objects[edge.child], self._objects.get(edge.parent)
        if edge.parent == self._hand:
            # Between bodies contact decides, and no box: fingers that are off by a little touch all the same.
            if self.scenario.physics == "contact":
                return None
            if isinstance(child, Cup):
                return lambda s, rng: self._beside_cup(edge.child, child, s, rng)
            return lambda s, rng: self._beside_button(edge.child, s, rng)
        if isinstance(parent, Button):
            return lambda s, rng: _level(s[edge.parent], rng)
        if isinstance(child, Cup):
            return lambda s, rng: self._below_outlet(edge.child, s, rng)
        return lambda s, rng: self._over_inlet(edge.parent, s, rng)

    def _beside_cup(self, name: str, cup: Cup, state: State, rng: np.random.Generator) -> bool:
        """A closed hand near a standing cup."""
        rim = self.camera.to_robot(state[name][:3])
        floor = float(cup.support(*rim)) + cup.cup.height
        if rim[2] - floor > _STANDING or abs(state[name][3]) > _UPRIGHT:
            return False
        rim[2] = floor
        state[name][:4] = [*self.camera.from_robot(rim), 0.0]
        grasp = cup.cup.grasp
        state[self._hand][self._hand_place] = rim + _drawn(grasp.center, grasp.half, rng)
        return True

    def _beside_button(self, name: str, state: State, rng: np.random.Generator) -> bool:
        """A hand near a button; what lies below the button's travel can't be reached, so that height has no more."""
        mount = self.scenario.button_mount(name)
        half = mount.travel / 2
        middle = (*mount.top[:2], mount.touch_height - half)
        place = _drawn(middle, (mount.reach, mount.reach, half), rng)
        if place[2] < middle[2] - half:
            return False
        state[self._hand][self._hand_place] = place
        button = self._objects[name]
        modes = button.decide_active(np.zeros(2), self._full(state), {self._hand: False}, None)
        active = {p: np.float64(on) for p, on in modes.items()}
        state[name] = button.settle(np.zeros(2), self._full(state), active)[button.state_space.observable_indices]  # type: ignore[arg-type]
        return True

    def _over_inlet(self, name: str, state: State, rng: np.random.Generator) -> bool:
        """A cup that is moved over the inlet, as high as it can be without going through the machine."""
        region = LAYOUT.pour_region()
        rim = _drawn(region.center, region.half, rng)
        height = self.scenario.cup_settings().height
        if rim[2] - height * max(np.cos(state[name][3]), 0.0) < LAYOUT.head.height:
            return False
        self._carry(name, rim, state)
        return True

    def _below_outlet(self, name: str, state: State, rng: np.random.Generator) -> bool:
        """A cup on the tray, or held upright a little above it."""
        height = self.scenario.cup_settings().height
        region, lowest = LAYOUT.catch_region(height), LAYOUT.tray.height + height
        rim = _drawn(region.center, region.half, rng)
        hand, cup = state[self._hand], state[name]
        held = bool(np.linalg.norm(hand[self._hand_place] - self.camera.to_robot(cup[:3])) < height and hand[-1])
        if not held:
            rim[2] = lowest
        if rim[2] < lowest or abs(cup[3]) > _UPRIGHT:
            return False
        if held:
            self._carry(name, rim, state)
        else:
            cup[:3] = self.camera.from_robot(rim)
        cup[3] = 0.0
        return True

    def _carry(self, name: str, rim: FloatArray, state: State) -> None:
        """Cup and hand move together."""
        moved = rim - self.camera.to_robot(state[name][:3])
        state[self._hand][self._hand_place] += moved
        state[name][:3] = self.camera.from_robot(rim)

    # What is true, and what is read.

    def _bases(self, edge: Interaction, pieces: Sequence[Demonstration]) -> list[State]:
        """Measured states of held-out rows in which the interaction acts."""
        out: list[State] = []
        for piece in pieces:
            rows = np.flatnonzero(piece.table[edge.name].to_numpy(dtype=float) > 0.5)  # noqa: PLR2004 - a flag
            states = {n: piece.states(n, s) for n, s in self.graph.objects.items()}
            out += [{n: s[r] for n, s in states.items()} for r in rows]
        return out

    def _full(self, state: State) -> State:
        """Full states; what is hidden is 0."""
        out = {}
        for name, value in state.items():
            system = self._objects.get(name)
            space = self.graph.objects[name] if system is None else system.state_space
            out[name] = np.zeros(len(space))
            out[name][space.observable_indices] = value
        return out

    def _truth(self, edge: Interaction, state: State) -> bool:
        """Whether the interaction begins in a state, by the world's own rules."""
        full, child = self._full(state), self._objects[edge.child]
        parents = self.graph.parents(edge.child)
        return bool(child.decide_active(full[edge.child], full, dict.fromkeys(parents, False), None)[edge.parent])

    def _read(self, edge: Interaction, state: State, rng: np.random.Generator) -> State:
        """What sensors give of what was moved; the rest was read in a piece already."""
        scale = self.scenario.config.noise.scale
        out = {n: v.copy() for n, v in state.items()}
        for name in (edge.child, *self.graph.parents(edge.child)):
            system = self._objects.get(name)
            if name == self._hand:
                place = self._hand_place
                out[name][place] += scale * self._hand_noise[place] * rng.standard_normal(3)
            elif isinstance(system, Cup):
                out[name][:3] += scale * POSITION_NOISE * rng.standard_normal(3)
            elif isinstance(system, Button):
                out[name] = system.measure(self._full(state)[name], scale * rng.standard_normal(1))
        return out

    def _place(self, name: str) -> list[int]:
        return [int(i) for i in self.graph.objects[name].observable.role_indices("position")]


def _drawn(middle: Sequence[float], half: Sequence[float], rng: np.random.Generator) -> FloatArray:
    """A point of a box blown up to `NEAR` half-widths, shape (3,)."""
    return np.asarray(middle) + NEAR * np.asarray(half) * rng.uniform(-1.0, 1.0, 3)


def _level(level: FloatArray, rng: np.random.Generator) -> bool:
    """A level that triggers, or the highest that does not: the only one within half a half-width of 4 to 6."""
    level[:] = rng.integers(LEVELS // 2, LEVELS + 1)
    return True
