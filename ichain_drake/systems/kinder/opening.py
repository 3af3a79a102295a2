"""What the adapter has to be told of KinDER's kinematic worlds: how they open, and where their state lies."""

from __future__ import annotations

import importlib
import os
from types import ModuleType
from typing import Any

import numpy as np

from ichain_drake.errors import InputError
from ichain_drake.objects.gymnasium.extra import require_gymnasium
from ichain_drake.state import FloatArray, Role, StateSpace, Variable

HINT = (
    "pip install 'ichain_drake[kinder]', and then the benchmark without its heavy backends: "
    "pip install --no-deps kindergarden"
)
RADIUS = 0.1
"""Of the robot's round base [m]."""

_PRESSED = 0.5  # a button's green is .9 once it is pressed, and 0 before


def require_kinder(part: str = "") -> ModuleType:
    """The benchmark, or one of its modules.

    Args:
        part: such as `envs.utils`; empty for the package.

    Raises:
        InputError: if it is not installed; says how to install it.
    """
    os.environ.setdefault("SDL_VIDEODRIVER", "dummy")  # it opens windows nowhere
    try:
        return importlib.import_module(f"kinder.{part}" if part else "kinder")
    except ImportError as error:
        raise InputError(f"this needs KinDER ({error.name or error} is missing): {HINT}") from None


def open_kinder(name: str) -> Any:
    """An environment that goes on after it is solved: whoever teaches, or puts a stick down, isn't done by then.

    Args:
        name: such as `StickButton2D-b1`.

    Raises:
        InputError: if the benchmark is not installed.
    """
    require_gymnasium()
    kinder = require_kinder()
    kinder.register_all_environments()
    return _goes_on(kinder.make(f"kinder/{name}-v0"))


def _goes_on(env: Any) -> Any:
    gymnasium = require_gymnasium()

    class GoesOn(gymnasium.Wrapper):  # type: ignore[misc, name-defined]
        def step(self, action: Any) -> Any:
            seen, reward, _, truncated, info = self.env.step(action)
            return seen, reward, False, truncated, info

    return GoesOn(env)


def place(frame: str = "room") -> tuple[Variable, Variable]:
    """Variables of a position in the room [m]."""
    return tuple(Variable(a, "m", role=Role("position", frame, a)) for a in "xy")  # type: ignore[return-value]


def turn(frame: str = "room") -> Variable:
    """Variable of an orientation in the room [rad]."""
    return Variable("theta", "rad", kind="angle", role=Role("orientation", frame, "z"))


class ObjectState:
    """All features of all objects that can change, read and put back in full precision: an environment's whole state.

    The colour of a button is in them, which is all that is remembered of its having been pressed.
    """

    def names(self, env: Any) -> tuple[str, ...]:
        """A name for each feature."""
        return tuple(f"{thing.name}_{feature}" for thing, feature in _features(env))

    def get(self, env: Any) -> FloatArray:
        """Their values."""
        state = inner(env)._current_state
        return np.array([state.get(thing, feature) for thing, feature in _features(env)], dtype=float)

    def put(self, env: Any, values: FloatArray) -> None:
        """Set them."""
        state = inner(env)._current_state.copy()
        for (thing, feature), value in zip(_features(env), values, strict=True):
            state.set(thing, feature, float(value))
        inner(env)._set_state(state)


def inner(env: Any) -> Any:
    """The object-centric environment inside."""
    return env.unwrapped._object_centric_env


def _features(env: Any) -> list[tuple[Any, str]]:
    state = inner(env)._current_state
    return [(thing, feature) for thing in sorted(state) for feature in state.type_features[thing.type]]


def values_of(env: Any, name: str, features: tuple[str, ...]) -> FloatArray:
    """Values of some features of an object, shape (n_features,).

    Args:
        env: the environment.
        name: of the object.
        features: their names; `pressed` is read from a button's colour.
    """
    state = inner(env)._current_state
    thing = state.get_object_from_name(name)
    return np.array(
        [
            float(state.get(thing, "color_g") > _PRESSED) if f == "pressed" else float(state.get(thing, f))
            for f in features
        ]
    )


def touches(env: Any, one: str, other: str) -> bool:
    """Whether two objects overlap, at whatever height: what presses a button."""
    state = inner(env)._current_state
    of = state.get_object_from_name
    return bool(
        require_kinder("envs.utils").state_2d_has_collision(state, {of(one)}, {of(other)}, {}, ignore_z_orders=True)
    )


def holds(env: Any, robot: str, name: str) -> bool:
    """Whether the robot's vacuum holds an object."""
    state = inner(env)._current_state
    held = require_kinder("envs.kinematic2d.utils").get_suctioned_objects(state, state.get_object_from_name(robot))
    return any(thing.name == name for thing, _ in held)


def robot_space(low: tuple[float, float], high: tuple[float, float]) -> StateSpace:
    """The robot: a round base with an arm and a vacuum.

    Args:
        low, high: corners of where its base can be [m].
    """
    x, y = (Variable(a, "m", low[k], high[k], role=Role("position", "room", a)) for k, a in enumerate("xy"))
    return StateSpace(
        "crv_robot",
        (x, y, turn(), Variable("arm", "m", RADIUS, 2 * RADIUS), Variable("vacuum", "1", 0, 1, kind="binary")),
    )
