"""A Gymnasium environment as a calculator: from a state, an action and noise to the state one frame later."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

import numpy as np

from ichain_drake.errors import InputError
from ichain_drake.objects.gymnasium.actions import ActionTerm
from ichain_drake.objects.gymnasium.extra import require_gymnasium
from ichain_drake.objects.gymnasium.snapshot import (
    Snapshot,
    check_snapshot,
    describe,
    find_snapshot,
    reset_once,
    step_once,
)
from ichain_drake.objects.gymnasium.spaces import FlatSpace, flat_values, space_size, space_variables
from ichain_drake.state import FloatArray, StateSpace, Variable

_MOST_VARIABLES = 256
_SLACK = 1e-5  # of a bound, that observations may be beyond it: they are rounded to single precision
_TRIED_STEPS = 4

MakeEnvironment = Callable[[str | None], Any]
Read = Callable[[Any, Any], FloatArray]
Write = Callable[[Any, FloatArray], None]


@dataclass(frozen=True)
class GameSpec:
    """An environment and how its spaces, time and state are to be understood.

    Attributes:
        environment: a registered id such as `Pendulum-v1`, or a function that makes the environment, given the render
            mode. It must not be wrapped in a time limit: `max_steps` is one.
        actions: one term for each number of an action.
        type: object type; an interaction library is keyed by it. By default the id.
        variables: what is measured, in order; by default one variable for each number of the observation.
        read: (unwrapped environment, observation) -> values of `variables`; by default the observation itself.
        write: (unwrapped environment, values of `variables`): the inverse of `read`, which then must do without an
            observation (None); only needed where somebody else is to set what is measured.
        snapshot: how to read the whole state and put it back; by default looked for in the environment.
        steps_per_frame: steps of the environment in one 30 Hz frame; a fraction such as 5/3 gives 1, 2 and 2 in turn.
        max_steps: steps after which an episode is truncated; None for the number that an id is registered with (a
            function's environment has none), `math.inf` for no limit.
        reset_seed: seed of the start; None for the run's seed.
        reset_options: passed to `reset`.
        stochastic: whether the environment draws random numbers while it steps. They then come from a generator that
            is seeded in every frame by that frame's noise of the world.
        render_mode: such as `rgb_array`, if pictures will be asked for; None draws nothing.
        keywords: passed to `gymnasium.make`.
    """

    environment: str | MakeEnvironment
    actions: tuple[ActionTerm, ...]
    type: str = ""
    variables: tuple[Variable, ...] = ()
    read: Read | None = None
    write: Write | None = None
    snapshot: Snapshot | None = None
    steps_per_frame: Fraction | int = 1
    max_steps: float | None = None
    reset_seed: int | None = None
    reset_options: Mapping[str, Any] | None = None
    stochastic: bool = False
    render_mode: str | None = None
    keywords: Mapping[str, Any] = field(default_factory=dict)


class GameEnvironment:
    """An open environment. It keeps nothing from one call to the next: all of its state is in the arrays.

    A state is: the measured variables, then hidden ones: `reward` of the last frame, `terminated`, `truncated`,
    `steps` since the start, `phase` where frames hold a fraction of steps, and the environment's own state.

    An episode that has ended stays as it is.

    Args:
        spec: see `GameSpec`.

    Raises:
        InputError: if Gymnasium is missing, the environment can't be made, its spaces don't fit the declaration, or its
            state can't be read and put back.
    """

    def __init__(self, spec: GameSpec) -> None:
        self.spec = spec
        self._rate = Fraction(spec.steps_per_frame)
        if self._rate <= 0:
            raise InputError(f"steps_per_frame is {spec.steps_per_frame}; give a number above 0")
        self.env = _make(spec)
        self.where = describe(self.env)
        self.action_space = FlatSpace(self.env.action_space)
        if len(spec.actions) != self.action_space.size:
            raise InputError(
                f"{self.where}: an action has {self.action_space.size} number(s), {len(spec.actions)} term(s) are "
                "declared"
            )
        self._read, variables = _reading(self.env, spec, self.where)
        observation = self._reset(0)
        self.snapshot = spec.snapshot or find_snapshot(self.env)
        inner = self.snapshot.names(self.env)
        self._check_state()
        given = self._values(observation)
        if given.shape != (len(variables),):
            raise InputError(f"{self.where}: {given.size} values are read for {len(variables)} variables")

        limit = spec.max_steps if spec.max_steps is not None else _registered_limit(spec.environment)
        self._max_steps = math.inf if limit is None else limit
        extra = ["reward", "terminated", "truncated", "steps", *(["phase"] if self._rate.denominator > 1 else [])]
        kinds = {"terminated": "binary", "truncated": "binary", "steps": "integer", "phase": "integer"}
        taken = {v.name for v in variables}
        names = [f"game_{n}" if n in taken or n in extra else n for n in inner]
        hidden = [Variable(n, kind=kinds.get(n, "real"), hidden=True) for n in extra]  # type: ignore[arg-type]
        hidden += [Variable(n, hidden=True) for n in names]
        self.space = StateSpace(spec.type or _type_name(self.where), (*variables, *hidden))
        self._measured = len(variables)
        self._at = {n: self._measured + k for k, n in enumerate(extra)}
        self._inner = slice(self._measured + len(extra), len(self.space))

    def index(self, name: str) -> int:
        """Position of `reward`, `terminated`, `truncated` or `steps` in a state."""
        return self._at[name]

    @property
    def measured(self) -> int:
        """How many variables of a state are measured: the first ones."""
        return self._measured

    def inner(self, state: FloatArray) -> FloatArray:
        """The environment's own state within a state, shape (..., n)."""
        return state[..., self._inner]

    def start(self, seed: int) -> FloatArray:
        """The state after a reset, shape (n_variables,).

        Args:
            seed: of the run; not used where the game declares a seed of its own.
        """
        observation = self._reset(seed)
        state = np.zeros(len(self.space))
        state[: self._measured] = self._checked(self._values(observation), "at its start")
        state[self._inner] = self.snapshot.get(self.env)
        return state

    def with_measured(self, state: FloatArray, values: FloatArray) -> FloatArray:
        """A state with other values of what is measured, and the environment's own state to match.

        Args:
            state: shape (n_variables,).
            values: shape (n_measured,).

        Raises:
            InputError: if nothing says how to write them into the environment.
        """
        if self.spec.write is None or self.spec.read is None:
            raise InputError(f"{self.where}: what it shows can't be set; declare `read` and `write`")
        self._put(state[self._inner])
        self.spec.write(self.env.unwrapped, np.asarray(values, dtype=float))
        out = np.array(state, dtype=float)
        out[: self._measured] = self._values(None)
        out[self._inner] = self.snapshot.get(self.env)
        return out

    def step(self, state: FloatArray, action: FloatArray, noise: FloatArray) -> FloatArray:
        """One frame.

        Args:
            state: shape (n_variables,).
            action: numbers of the action, clipped to the action space, shape (n_terms,).
            noise: standard normal, shape (1,) for a stochastic environment, else (0,).

        Returns:
            The state a frame later, shape (n_variables,).
        """
        at = self._at
        after = np.array(state, dtype=float)
        after[at["reward"]] = 0.0
        if state[at["terminated"]] > 0.5 or state[at["truncated"]] > 0.5:
            return after
        steps = self._rate.numerator
        if "phase" in at:
            phase, (count, frames) = int(state[at["phase"]]), self._rate.as_integer_ratio()
            steps = (phase + 1) * count // frames - phase * count // frames
            after[at["phase"]] = (phase + 1) % frames
        if steps == 0:
            return after
        self._put(state[self._inner])
        if self.spec.stochastic:
            self.env.unwrapped.np_random = np.random.default_rng(np.frombuffer(noise.tobytes(), dtype=np.uint32))
        command = self.action_space.value(action)
        total, observation, terminated, truncated = 0.0, None, False, False
        for _ in range(steps):
            observation, reward, terminated, truncated = step_once(self.env, command)
            total += reward
            after[at["steps"]] += 1.0
            truncated = truncated or after[at["steps"]] >= self._max_steps
            if terminated or truncated:
                self._ended = True
                break
        after[: self._measured] = self._checked(self._values(observation), f"after {after[at['steps']]:.0f} steps")
        after[at["reward"]] = total
        after[at["terminated"]], after[at["truncated"]] = float(terminated), float(truncated)
        after[self._inner] = self.snapshot.get(self.env)
        return after

    def render(self, state: FloatArray) -> Any:
        """A picture of a state.

        Raises:
            InputError: if no render mode was asked for.
        """
        if self.spec.render_mode is None:
            raise InputError(f"{self.where}: rendering is off; declare a render_mode such as rgb_array")
        self._put(state[self._inner])
        return self.env.render()

    def _values(self, observation: Any) -> FloatArray:
        return np.asarray(self._read(self.env.unwrapped, observation), dtype=float)

    def _checked(self, values: FloatArray, when: str) -> FloatArray:
        """Measured values, none of which may be infinite or leave the bounds that are declared for it.

        Raises:
            InputError: naming the variable and the time.
        """
        for variable, value in zip(self.space.variables, values, strict=False):
            slack = _SLACK * max(1.0, *(abs(b) for b in (variable.lower, variable.upper) if math.isfinite(b)), 0.0)
            if variable.kind == "angle":
                slack = math.inf
            if not (math.isfinite(value) and variable.lower - slack <= value <= variable.upper + slack):
                raise InputError(
                    f"{self.where}: {variable.name} is {value:g} {when}; its space declares {variable.lower:g} to "
                    f"{variable.upper:g}: correct that, or declare `variables`"
                )
        return values

    def _reset(self, seed: int) -> Any:
        self._ended = False
        self._last_seed = seed if self.spec.reset_seed is None else self.spec.reset_seed
        return reset_once(self.env, self._last_seed, self.spec.reset_options)

    def _put(self, inner: FloatArray) -> None:
        if self._ended:  # many environments refuse to go on, and note the end where no snapshot looks
            self._reset(self._last_seed)
        self.snapshot.put(self.env, inner)

    def _check_state(self) -> None:
        middle = np.array([t.offset for t in self.spec.actions])
        tried = [self.action_space.value(middle + 0.3 * math.sin(k)) for k in range(_TRIED_STEPS)]
        check_snapshot(self.env, self.snapshot, tried, stochastic=self.spec.stochastic)
        self._ended = True


def _make(spec: GameSpec) -> Any:
    gymnasium = require_gymnasium()
    if callable(spec.environment):
        env = spec.environment(spec.render_mode)
    else:
        try:
            env = gymnasium.make(
                spec.environment,
                max_episode_steps=-1,  # `max_steps` counts them, in the state
                disable_env_checker=True,
                render_mode=spec.render_mode,
                **spec.keywords,
            )
        except (gymnasium.error.Error, ImportError, TypeError) as error:
            raise InputError(f"environment {spec.environment!r}: {' '.join(str(error).split())}") from None
    layer = env
    while layer is not env.unwrapped:
        if isinstance(layer, gymnasium.wrappers.TimeLimit):
            raise InputError(f"{describe(env)}: it is wrapped in a time limit, which counts for itself; use max_steps")
        layer = layer.env
    return env


def _registered_limit(environment: str | MakeEnvironment) -> int | None:
    """Steps after which a registered environment truncates an episode."""
    return None if callable(environment) else require_gymnasium().spec(environment).max_episode_steps


def _reading(env: Any, spec: GameSpec, where: str) -> tuple[Read, tuple[Variable, ...]]:
    """How to read the measured variables, and which they are."""
    if spec.read is not None:
        if not spec.variables:
            raise InputError(f"{where}: `read` is given without `variables`; declare what it reads")
        return spec.read, spec.variables
    space = env.observation_space
    size = space_size(space)
    if spec.variables and len(spec.variables) != size:
        raise InputError(f"{where}: an observation has {size} numbers, {len(spec.variables)} variables are declared")
    if size > _MOST_VARIABLES:
        raise InputError(f"{where}: an observation has {size} numbers; declare `variables` and how to `read` them")
    return lambda _, observation: flat_values(space, observation), spec.variables or space_variables(
        space, "observation"
    )


def _type_name(where: str) -> str:
    return "".join(c if c.isalnum() else "_" for c in where.removeprefix("environment ").lower())
