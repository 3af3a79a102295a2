"""An environment as a calculator for a whole world: from a state and a wanted root to the state a tick later."""

from __future__ import annotations

import numpy as np

from ichain_drake.errors import InputError
from ichain_drake.objects.gymnasium.snapshot import check_snapshot, describe, find_snapshot, reset_once, step_once
from ichain_drake.objects.gymnasium.spaces import FlatSpace
from ichain_drake.state import FloatArray
from ichain_drake.world.environment_spec import EnvironmentSpec

_TRIED = 4  # steps with which its snapshot is tried


class OpenEnvironment:
    """An open environment. It keeps nothing from one call to the next: a state holds all of it.

    A state is: the state of every object of `spec.graph`, in its order, then the environment's own.

    Args:
        spec: see `EnvironmentSpec`.

    Raises:
        InputError: if what is declared doesn't fit the environment, or its state can't be read and put back: a context
            could then be neither cloned nor replayed.
    """

    def __init__(self, spec: EnvironmentSpec) -> None:
        self.spec = spec
        self.env = spec.make()
        self.where = describe(self.env)
        self._actions = FlatSpace(self.env.action_space)
        if len(spec.actions) != self._actions.size:
            raise InputError(
                f"{self.where}: an action has {self._actions.size} number(s), {len(spec.actions)} term(s) are declared"
            )
        self._last_seed = 0
        self._reset(0)
        self._snapshot = spec.snapshot or find_snapshot(self.env)
        tried = [self._actions.value(np.full(self._actions.size, 0.3 * np.sin(k))) for k in range(_TRIED)]
        check_snapshot(self.env, self._snapshot, tried, stochastic=spec.stochastic)
        self._ended = True
        sizes = [len(s) for s in spec.graph.objects.values()]
        ends = np.cumsum(sizes)
        self.places = {n: slice(int(b - a), int(b)) for n, a, b in zip(spec.graph.objects, sizes, ends, strict=True)}
        self._seen = int(ends[-1])

    def start(self, seed: int) -> FloatArray:
        """The state after a reset, shape (n,).

        Args:
            seed: of the reset.
        """
        self._reset(seed)
        return self._state(0.0, terminated=False, truncated=False)

    def tick(self, state: FloatArray, wanted: FloatArray, noise: FloatArray) -> FloatArray:
        """The state a tick later, shape (n,); the same if the episode is over.

        Args:
            state: shape (n,).
            wanted: of the root, shape (n_root,).
            noise: standard normal, shape (1,); seeds what a stochastic environment draws.
        """
        spec, root = self.spec, self.spec.declared.root
        if state[self.places[root]][-2:].any():
            return state
        if self._ended:  # many environments refuse to go on, and note the end where no snapshot looks
            self._reset(self._last_seed)
        self._snapshot.put(self.env, state[self._seen :])
        if spec.stochastic:
            self.env.unwrapped.np_random = np.random.default_rng(np.frombuffer(noise.tobytes(), dtype=np.uint32))
        total, terminated, truncated = 0.0, False, False
        for _ in range(spec.steps_per_tick):
            action = self._actions.value(spec.action(wanted, self._values(root)))
            _, reward, terminated, truncated = step_once(self.env, action)
            total += reward
            if terminated or truncated:
                self._ended = True
                break
        return self._state(total, terminated=terminated, truncated=truncated)

    def _reset(self, seed: int) -> None:
        self._ended, self._last_seed = False, seed
        reset_once(self.env, seed, self.spec.reset_options)

    def _values(self, name: str) -> FloatArray:
        """What is read of an object, shape (n_variables,).

        Raises:
            InputError: if it is missing, or no finite numbers of the declared count.
        """
        read = self.spec.read(self.env.unwrapped)
        if name not in read:
            raise InputError(f"{self.where}: `read` gives no {name}; it gives {', '.join(map(str, read))}")
        return self.spec.objects[name].check(read[name], f"{self.where}: {name}")

    def _state(self, reward: float, *, terminated: bool, truncated: bool) -> FloatArray:
        graph = self.spec.graph
        flags = self.spec.active(self.env.unwrapped)
        missing = [e.name for e in graph.interactions if e.name not in flags]
        if missing:
            raise InputError(f"{self.where}: `active` does not tell about {missing[0]}")
        parts = []
        for name in graph.objects:
            parts.append(self._values(name))
            if name == graph.root:
                parts.append(np.array([reward, terminated, truncated], dtype=float))
            else:
                parts.append(np.array([bool(flags[f"{p}->{name}"]) for p in graph.parents(name)], dtype=float))
        return np.concatenate([*parts, self._snapshot.get(self.env)])
