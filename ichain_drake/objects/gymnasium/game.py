"""The world object around a Gymnasium environment: the parents' states are its action."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, Unpack

import numpy as np
from pydrake.systems.framework import BasicVector, Context

from ichain_drake.objects.base import ObjectArguments, ObjectSettings, ParentStates, WorldObject
from ichain_drake.objects.gymnasium.actions import ActionMap
from ichain_drake.objects.gymnasium.environment import GameEnvironment
from ichain_drake.state import FloatArray, StateSpace

_ENDS = ("reward", "terminated", "truncated")


class GymnasiumGame(WorldObject):
    """An environment as an object: its whole state is in the Drake context, the environment itself only calculates.

    Contexts therefore clone and replay, and several objects may share one environment.

    Ports: those of `WorldObject`, and the outputs `reward` (of the last frame), `terminated` and `truncated` (0 or 1).

    Args:
        environment: an open environment.
        parents: one or more; the environment's action terms name their variables.
        name, initial, settings: see `WorldObject`; by default it starts as `reset` leaves it.

    Raises:
        InputError: if an action term reads something that the parents don't have.
    """

    state_space: ClassVar[StateSpace]

    def __init__(
        self,
        name: str,
        parents: Mapping[str, StateSpace],
        environment: GameEnvironment,
        **given: Unpack[ObjectArguments],
    ) -> None:
        self.environment = environment
        self.state_space = environment.space  # type: ignore[misc]
        self.process_noise_size = 1 if environment.spec.stochastic else 0  # type: ignore[misc]
        self._action = ActionMap(environment.spec.actions, parents, environment.action_space.size, name)
        self._seed = (given.get("settings") or ObjectSettings()).seed
        super().__init__(name, parents, **given)
        for port in _ENDS:
            index = environment.index(port)

            def calc(context: Context, output: BasicVector, index: int = index) -> None:
                output.SetAtIndex(0, self._value(context, self._state)[index])

            self.DeclareVectorOutputPort(port, 1, calc, {self.xd_ticket()})

    def default_state(self) -> FloatArray:
        """As `reset` leaves it, with the run's seed or the game's own."""
        return self.environment.start(self._seed)

    def step(
        self, state: FloatArray, parents: ParentStates, active: Mapping[str, FloatArray], noise: FloatArray, dt: float
    ) -> FloatArray:
        """One frame of the environment, row by row; an episode that has ended stays as it is."""
        action = self._action(parents, active)
        if state.ndim == 1:
            return self.environment.step(state, action, noise)
        after = np.empty_like(state)
        for row in np.ndindex(state.shape[:-1]):
            after[row] = self.environment.step(state[row], action[row], noise[row])
        return after

    def set_state(self, context: Context, state: FloatArray | Sequence[float]) -> None:
        """Put the object into a state; where only measured variables change, the environment's own state follows.

        Args:
            context: the object's own context.
            state: shape (n_variables,).

        Raises:
            InputError: on a wrong shape or a non-finite value, or if what is measured can't be set.
        """
        wanted, old = self.state_space.check(state, f"{self.get_name()}: state"), self.get_state(context)
        env, count = self.environment, self.environment.measured
        moved = not np.array_equal(wanted[:count], old[:count])
        if moved and np.array_equal(env.inner(wanted), env.inner(old)):
            wanted = env.with_measured(wanted, wanted[:count])
        super().set_state(context, wanted)

    def render(self, context: Context) -> Any:
        """A picture of the game, as its render mode gives it.

        Args:
            context: the object's own context.

        Raises:
            InputError: if no render mode was asked for.
        """
        return self.environment.render(self.get_state(context))
