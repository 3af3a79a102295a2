"""The whole state of an environment as numbers, so that it can live in a Drake context: cloned, replayed, set."""

from __future__ import annotations

from dataclasses import dataclass
from numbers import Real
from typing import Any, Protocol

import numpy as np

from ichain_drake.errors import InputError
from ichain_drake.state import FloatArray

_USUAL = ("state", "s")
"""What Gymnasium's own environments call the attribute that holds all of their state."""


class Snapshot(Protocol):
    """Reads an environment's whole state, and puts it back."""

    def names(self, env: Any) -> tuple[str, ...]:
        """A name for each number, known after the environment was reset."""

    def get(self, env: Any) -> FloatArray:
        """The state, shape (len(names),); everything that what comes next depends on."""

    def put(self, env: Any, values: FloatArray) -> None:
        """Put the environment into a state, whatever it was in before."""


@dataclass(frozen=True)
class AttributeSnapshot:
    """A state that lies in attributes of the environment: numbers, or arrays, lists or tuples of them.

    Attributes:
        attributes: their names.
    """

    attributes: tuple[str, ...]

    def names(self, env: Any) -> tuple[str, ...]:
        """The attributes' names, numbered where they hold several numbers."""
        out: list[str] = []
        for attribute in self.attributes:
            values = np.asarray(self._read(env, attribute))
            out += [attribute] if values.ndim == 0 else [f"{attribute}_{k}" for k in range(values.size)]
        return tuple(out)

    def get(self, env: Any) -> FloatArray:
        """All numbers, in order."""
        return np.concatenate([np.ravel(np.asarray(self._read(env, a), dtype=float)) for a in self.attributes])

    def put(self, env: Any, values: FloatArray) -> None:
        """Set the attributes, each in the kind and shape that it has."""
        inner, start = env.unwrapped, 0
        for attribute in self.attributes:
            old = self._read(env, attribute)
            shape = np.shape(old)
            count = int(np.prod(shape, dtype=int))
            part = values[start : start + count]
            start += count
            if isinstance(old, np.ndarray):
                # Always in full precision: some environments start with it and lose it at their first step.
                kind = float if np.issubdtype(old.dtype, np.floating) else old.dtype
                new: Any = part.astype(kind).reshape(shape)
            elif shape == ():
                new = type(old)(part[0])
            else:
                new = type(old)(part.tolist())
            setattr(inner, attribute, new)

    def _read(self, env: Any, attribute: str) -> Any:
        value = getattr(env.unwrapped, attribute, None)
        if not is_numeric(value):
            raise InputError(f"{describe(env)}: its attribute {attribute!r} does not hold numbers; name another")
        return value


def is_numeric(value: Any) -> bool:
    """Whether something is a number, or an array, list or tuple of numbers."""
    if isinstance(value, Real):
        return True
    if isinstance(value, np.ndarray | list | tuple) and len(value):
        kind = np.asarray(value).dtype.kind
        return kind in "fiub"
    return False


def describe(env: Any) -> str:
    """What to call an environment in an error."""
    spec = getattr(env, "spec", None)
    return f"environment {spec.id if spec is not None else type(env.unwrapped).__name__}"


def step_once(env: Any, action: Any) -> tuple[Any, float, bool, bool]:
    """One step of an environment.

    Returns:
        Observation, reward, whether it has terminated, whether it was truncated.

    Raises:
        InputError: if it gives anything else than Gymnasium's five values.
    """
    result = env.step(action)
    if not isinstance(result, tuple) or len(result) != 5:
        got = f"{len(result)} values" if isinstance(result, tuple) else type(result).__name__
        raise InputError(
            f"{describe(env)}: its step gives {got}, not (observation, reward, terminated, truncated, info); it "
            "follows an older interface: wrap it"
        )
    observation, reward, terminated, truncated, _ = result
    return observation, float(reward), bool(terminated), bool(truncated)


def reset_once(env: Any, seed: int, options: Any) -> Any:
    """Reset an environment; gives the observation.

    Raises:
        InputError: if it takes no seed, or gives anything else than (observation, info).
    """
    try:
        result = env.reset(seed=seed, options=options)
    except TypeError as error:
        raise InputError(
            f"{describe(env)}: its reset takes no seed and options ({error}); it follows an older interface: wrap it"
        ) from None
    if not isinstance(result, tuple) or len(result) != 2 or not isinstance(result[1], dict):
        raise InputError(
            f"{describe(env)}: its reset gives no (observation, info); it follows an older interface: wrap it"
        )
    return result[0]


def find_snapshot(env: Any) -> Snapshot:
    """Where an environment, already reset, keeps its state in one attribute, as Gymnasium's classic and toy ones do.

    Raises:
        InputError: where it does not; says what to give instead.
    """
    for attribute in _USUAL:
        if is_numeric(getattr(env.unwrapped, attribute, None)):
            return AttributeSnapshot((attribute,))
    raise InputError(
        f"{describe(env)}: nothing says how to read its whole state and put it back, so a context could be neither "
        "cloned nor replayed; give GameSpec a snapshot"
    )


def check_snapshot(env: Any, snapshot: Snapshot, actions: list[Any], *, stochastic: bool) -> None:
    """Try whether a snapshot holds everything: from one state, after a detour, the same actions must lead to the same.

    Args:
        env: already reset; it is left in some state.
        snapshot: what is tried.
        actions: a few actions.
        stochastic: whether the environment may draw random numbers while it steps.

    Raises:
        InputError: if the two ways differ, or random numbers are drawn that were not declared.
    """
    try:
        generator = env.unwrapped.np_random.bit_generator
    except AttributeError:
        raise InputError(
            f"{describe(env)}: its np_random is no NumPy Generator, so its random numbers can't be put back; let it "
            "call super().reset(seed=seed)"
        ) from None
    start = snapshot.get(env)
    random = generator.state
    first = _follow(env, snapshot, start, actions)
    if not stochastic and generator.state != random:
        raise InputError(f"{describe(env)}: it draws random numbers while it steps; say so with stochastic=True")
    _follow(env, snapshot, snapshot.get(env), actions[::-1])  # the detour
    generator.state = random
    second = _follow(env, snapshot, start, actions)
    for a, b in zip(first, second, strict=True):
        if a.shape != b.shape or not np.array_equal(a, b):
            raise InputError(
                f"{describe(env)}: put back into one state it goes on in another way, so its snapshot does not hold "
                "all of its state, or it draws from a random generator of its own; give GameSpec a snapshot that does, "
                "and let it draw from self.np_random"
            )


def _follow(env: Any, snapshot: Snapshot, start: FloatArray, actions: list[Any]) -> list[FloatArray]:
    snapshot.put(env, start)
    seen = []
    for action in actions:
        _, reward, terminated, truncated = step_once(env, action)
        seen.append(np.append(snapshot.get(env), [float(reward), terminated, truncated]))
        if terminated or truncated:
            break
    return seen
