"""All that is special to Gymnasium's CarRacing: its track, what to read of the car, and its state as numbers.

Import this only where the extra `games` is installed.
"""

from __future__ import annotations

import itertools
import math
from fractions import Fraction
from typing import Any

import gymnasium
import numpy as np
from gymnasium.envs.box2d.car_racing import PLAYFIELD, CarRacing

from ichain_drake.objects.gymnasium import ActionTerm, GameEnvironment, GameSpec
from ichain_drake.state import FloatArray, Role, Variable

MIDDLE = np.array([PLAYFIELD, PLAYFIELD])
"""The game's origin in coordinates that start at the playfield's lower left corner."""

_FRAME = "playfield"
VARIABLES = (
    Variable("x", "unit", role=Role("position", frame=_FRAME, axis="x")),
    Variable("y", "unit", role=Role("position", frame=_FRAME, axis="y")),
    Variable("heading", "rad", -math.pi, math.pi, "angle", role=Role("orientation", frame=_FRAME, axis="z")),
    Variable("speed", "unit/s"),
    Variable("drift", "unit/s"),
    Variable("yaw_rate", "rad/s"),
)
"""What is measured: the hull's pose on the playfield, and its velocity forward, to the left, and turning."""

_BODY = ("x", "y", "angle", "vx", "vy", "turn")
_WHEEL = ("omega", "gas", "brake", "steer", "phase")
_PROGRESS = ("t", "reward", "prev_reward", "new_lap")
_BITS = 48  # tiles that one number holds; 53 would fit


class RacingWithoutPixels(CarRacing):
    """CarRacing as it is, but a step draws no picture where none was asked for, and all of its state shows.

    The original renders its observation of 96 x 96 pixels in every step, whatever the render mode.
    """

    def __init__(self, render_mode: str | None = None) -> None:
        super().__init__(render_mode=render_mode)
        self.spec = gymnasium.spec("CarRacing-v3")
        # Between two steps the solver would keep impulses, and bodies the time since they last moved, where nobody can
        # read them. Without them a step depends on what can be read alone.
        self.world.warmStarting = False
        self.world.allowSleeping = False

    def _render(self, mode: str) -> Any:
        return None if mode == "state_pixels" else super()._render(mode)

    @property
    def bodies(self) -> list[Any]:
        """Hull and wheels."""
        car: Any = self.car  # None before the first reset
        return [car.hull, *car.wheels]

    @property
    def tiles(self) -> list[Any]:
        """Of the road."""
        return list(self.road or [])

    def find_contacts(self) -> None:
        """Let the wheels know which tiles they are on now: a step of no duration moves nothing."""
        self.world.Step(0.0, 1, 1)

    @property
    def visited(self) -> FloatArray:
        """Which tiles of the road were visited, 48 to a number."""
        flags = [tile.road_visited for tile in self.tiles]
        flags += [False] * (-len(flags) % _BITS)
        return np.array(flags, dtype=float).reshape(-1, _BITS) @ 2.0 ** np.arange(_BITS)

    @visited.setter
    def visited(self, numbers: FloatArray) -> None:
        bits = (numbers.astype(np.int64)[:, None] >> np.arange(_BITS)) & 1
        tiles = self.tiles
        flags = bits.ravel()[: len(tiles)].astype(bool).tolist()
        for tile, flag in zip(tiles, flags, strict=True):
            tile.road_visited = flag
        self.tile_visited_count = sum(flags)


class RacingSnapshot:
    """Everything that CarRacing goes on from; see `Snapshot`."""

    def names(self, env: Any) -> tuple[str, ...]:
        """Five bodies, four wheels, and how far the lap is."""
        bodies = ("hull", *(f"wheel{k}" for k in range(4)))
        out = [f"{body}_{value}" for body in bodies for value in _BODY]
        out += [f"wheel{k}_{value}" for k in range(4) for value in _WHEEL]
        return (*out, *_PROGRESS, *(f"visited_{k}" for k in range(len(env.unwrapped.visited))))

    def get(self, env: Any) -> FloatArray:
        """All numbers, in order."""
        game = env.unwrapped
        game.find_contacts()  # a tile counts as visited in the state in which a wheel is on it
        out: list[float] = []
        for body in game.bodies:
            (x, y), (vx, vy) = body.position, body.linearVelocity
            out += (x, y, body.angle, vx, vy, body.angularVelocity)
        for wheel in game.car.wheels:
            out += (getattr(wheel, name) for name in _WHEEL)
        out += (getattr(game, name) for name in _PROGRESS)
        return np.concatenate([np.array(out, dtype=float), game.visited])

    def put(self, env: Any, values: FloatArray) -> None:
        """Move the bodies, let them find their tiles, and only then set what tiles count for."""
        game, numbers = env.unwrapped, iter(values.tolist())
        for body in game.bodies:
            x, y, angle, vx, vy, turn = itertools.islice(numbers, len(_BODY))
            body.transform = ((x, y), angle)
            body.linearVelocity = (vx, vy)
            body.angularVelocity = turn
        for wheel in game.car.wheels:
            for name in _WHEEL:
                setattr(wheel, name, next(numbers))
        game.find_contacts()
        for name in _PROGRESS:
            setattr(game, name, next(numbers))
        game.new_lap = bool(game.new_lap)
        game.visited = np.array(list(numbers))


def read_car(game: Any, observation: Any) -> FloatArray:
    """Values of `VARIABLES`; the game's pixels are not needed."""
    hull = game.car.hull
    heading = hull.angle + math.pi / 2  # the game's car points along its y
    c, s = math.cos(heading), math.sin(heading)
    vx, vy = hull.linearVelocity
    x, y = hull.position
    return np.array(
        [
            x + PLAYFIELD,
            y + PLAYFIELD,
            math.remainder(heading, 2 * math.pi),
            c * vx + s * vy,
            c * vy - s * vx,
            hull.angularVelocity,
        ]
    )


def write_car(game: Any, values: FloatArray) -> None:
    """Move the car as a whole: the inverse of `read_car`; wheels keep their steering, their spin and the pedals."""
    x, y, heading, speed, drift, turn = values.tolist()
    hull, angle = game.car.hull, heading - math.pi / 2
    parts = [(w, hull.GetLocalPoint(w.joint.anchorA), w.angle - hull.angle) for w in game.car.wheels]
    c, s = math.cos(heading), math.sin(heading)
    vx, vy = speed * c - drift * s, speed * s + drift * c
    hull.transform = ((x - PLAYFIELD, y - PLAYFIELD), angle)
    hull.linearVelocity, hull.angularVelocity = (vx, vy), turn
    for wheel, anchor, steered in parts:
        place = hull.GetWorldPoint(anchor)
        rx, ry = place - hull.worldCenter
        wheel.transform = (place, angle + steered)
        wheel.linearVelocity, wheel.angularVelocity = (vx - turn * ry, vy + turn * rx), turn


def open_game(
    stick: tuple[str, str], steer: float, gas: float, brake: float, track: int, steps_per_frame: Fraction
) -> GameEnvironment:
    """CarRacing, driven by a stick with two axes.

    Args:
        stick: the parent's variables: steering (positive to the right), then throttle (negative brakes).
        steer, gas, brake: share of the game's action at the end of an axis.
        track: seed of the game's track.
        steps_per_frame: see `GameSpec`.
    """
    actions = (ActionTerm(stick[0], steer), ActionTerm(stick[1], gas), ActionTerm(stick[1], -brake))
    spec = GameSpec(
        RacingWithoutPixels,
        actions,
        "racing_car",
        VARIABLES,
        read_car,
        write_car,
        RacingSnapshot(),
        steps_per_frame,
        math.inf,
        reset_seed=track,
    )
    return GameEnvironment(spec)


def place_car(environment: GameEnvironment, position: FloatArray, heading: float, speed: float) -> FloatArray:
    """A state with the car somewhere else: straight, its wheels rolling.

    Args:
        environment: see `open_game`.
        position: of the hull on the playfield [unit], shape (2,).
        heading: where it points [rad].
        speed: forward [unit/s].

    Returns:
        shape (n_variables,).
    """
    space, state = environment.space, environment.start(0)
    rolling = speed / environment.env.unwrapped.car.wheels[0].wheel_rad
    state[[k for k, name in enumerate(space.names) if name.startswith("visited_")]] = 0.0
    state[space.indices([f"wheel{k}_omega" for k in range(4)])] = rolling
    return environment.with_measured(state, np.array([*position, heading, speed, 0.0, 0.0]))


def centre_line(environment: GameEnvironment) -> FloatArray:
    """The middle of the road, from the start once round, shape (n_tiles, 2) [unit]."""
    environment.start(0)
    return np.array([[x, y] for _, _, x, y in environment.env.unwrapped.track]) + MIDDLE


def road(environment: GameEnvironment) -> list[list[tuple[float, float]]]:
    """The road's tiles and kerbs as polygons on the playfield [unit]."""
    environment.start(0)
    polygons = [corners for corners, _ in environment.env.unwrapped.road_poly]
    return [[(x + PLAYFIELD, y + PLAYFIELD) for x, y in corners] for corners in polygons]
