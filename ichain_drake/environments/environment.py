"""A scenario's world as a `gymnasium.Env`. Imported only where Gymnasium is installed."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np
from pydrake.systems.framework import Context, State

from ichain_drake.control.ticks import TickSystem
from ichain_drake.control.tracking.path import TimedPath
from ichain_drake.demonstrations import COMMAND, Demonstration, column
from ichain_drake.environments.judges import GoalJudge, Judge, PathJudge
from ichain_drake.errors import InputError
from ichain_drake.scenarios.base import PathScenario, Scenario
from ichain_drake.scenarios.graph_scenario import GraphScenario
from ichain_drake.simulation.episode import Episode
from ichain_drake.simulation.wiring import start_command
from ichain_drake.state import FloatArray
from ichain_drake.timing import FRAME, FRAMES_PER_TICK, TICK
from ichain_drake.world.world import World

_SEEDS = 2**31  # an episode's seed is drawn below this


class SystemEnvironment(gymnasium.Env[FloatArray, FloatArray]):
    """A scenario's world, one tick (1/3 s) a step.

    An action is a hand command: the hand's exposed variables, in their units and bounds. An observation is what is
    measured of every object, the hand first, and where a path is followed, the wanted positions of the coming ticks
    relative to the measured one. Rewards and ends are those of `GoalJudge` or `PathJudge`, in truth; an episode that
    takes too long is truncated. `info` has the `seed` (`ichain run --seed` starts as this episode), the simulated
    `time` [s], `success`, and for each object in order whether its reading is `valid`.

    A seed given to `reset` decides about the episode and all that follow it.

    Args:
        scenario: a `PathScenario` or a `GraphScenario`; it is left as it was.
        path: name of the reference path; default: the first.
        goal: expressions in place of the scenario's goal.
        lookahead: of a path, the ticks of wanted positions.

    Attributes:
        scenario: this environment's own copy, with the seed of the running episode.
        command_names: of an action's entries, in order.
        observation_names: of an observation's entries, in order.

    Raises:
        InputError: on a bad path or goal, or a scenario that has neither.
    """

    metadata: dict[str, Any] = {"render_modes": []}

    def __init__(
        self, scenario: Scenario, *, path: str = "", goal: str | Sequence[str] = (), lookahead: int = 1
    ) -> None:
        self.scenario = copy.copy(scenario)
        graph = scenario.graph
        self._path, self._judge = _task(
            scenario, path, [goal] if isinstance(goal, str) and goal else list(goal), lookahead
        )
        hand = graph.command
        self._counts = np.array([v.kind in ("binary", "integer") for v in hand.variables])
        self.action_space = gymnasium.spaces.Box(hand.lower, hand.upper, dtype=np.float64)
        self.command_names = hand.names
        measured = [f"{name}.{v}" for name, space in graph.objects.items() for v in space.observable.names]
        self.observation_names = (*measured, *self._judge.names)
        # A reading may be beyond its variable's bounds, by its noise.
        size = (len(self.observation_names),)
        self.observation_space = gymnasium.spaces.Box(-np.inf, np.inf, size, dtype=np.float64)
        self._episode: Episode | None = None
        self._hand = _Held(np.zeros(len(hand)))
        self._tick = 0

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[FloatArray, dict[str, Any]]:
        """Begin an episode in a world of its own.

        Args:
            seed: decides about this episode and all that follow it.
            options: there are none.

        Returns:
            An observation, and `info`.
        """
        super().reset(seed=seed)
        self.scenario.seed = int(self.np_random.integers(_SEEDS))
        return self.begin(self._world())

    def begin(self, world: World) -> tuple[FloatArray, dict[str, Any]]:
        """Begin an episode in a world that the scenario made.

        Args:
            world: the world; its default context is where the episode starts.

        Returns:
            As `reset`.
        """
        self._hand = _Held(start_command(world))
        self._episode = Episode(world, self._hand, log=False)
        self._tick = 0
        self._judge.begin(self._all("state"), self._all("active"))
        return self._observe(self._all("measured")), self._info(success=False)

    @property
    def command(self) -> FloatArray:
        """The hand command that is in force, shape (n_hand,): the last action as it was taken."""
        return self._hand.command.copy()

    def step(self, action: FloatArray) -> tuple[FloatArray, float, bool, bool, dict[str, Any]]:
        """One tick under a hand command.

        Args:
            action: shape (n_hand,); what is out of bounds is taken to them, what counts is rounded.

        Returns:
            Observation, reward, whether the task is over, whether the time is, and `info`.

        Raises:
            InputError: on a wrong shape or a number that is not finite, or before `reset`.
        """
        if self._episode is None:
            raise InputError("step: no episode is running; call reset first")
        graph = self.scenario.graph
        command = graph.command.check(action, "action")
        command = np.clip(command, self.action_space.low, self.action_space.high)  # type: ignore[attr-defined]
        self._hand.command = np.where(self._counts, np.round(command), command)
        frames = [self._all("state")]
        for frame in range(self._tick * FRAMES_PER_TICK + 1, (self._tick + 1) * FRAMES_PER_TICK + 1):
            self._episode.simulator.AdvanceTo(frame * FRAME)
            frames.append(self._all("state"))
        self._tick += 1
        measured = self._all("measured")
        verdict = self._judge.see(measured, frames, self._all("active"))
        late = self._tick >= self._judge.limit and not verdict.terminated
        return self._observe(measured), verdict.reward, verdict.terminated, late, self._info(success=verdict.success)

    def close(self) -> None:
        """Let the world go."""
        self._episode = None

    def imitation(self, pieces: Sequence[Demonstration]) -> tuple[FloatArray, FloatArray]:
        """Observations and the commands that were given there, out of demonstrations.

        Where a path is followed, a demonstration is taken to have wanted to be where it was.

        Args:
            pieces: each with every object, and the hand's commands.

        Returns:
            Observations, shape (n, n_observation), and actions, shape (n, n_hand).

        Raises:
            InputError: if a column is missing; names the piece and the column.
        """
        objects = self.scenario.graph.objects
        ahead = len(self._judge.names) // 2
        observations, actions = [], []
        for piece in pieces:
            states = {name: piece.states(name, space) for name, space in objects.items()}
            missing = [n for n in self.command_names if column(COMMAND, n) not in piece.table]
            if missing:
                raise InputError(f"{piece.name}: column {column(COMMAND, missing[0])} is missing; record the hand too")
            commands = piece.table[[column(COMMAND, n) for n in self.command_names]].to_numpy(dtype=float)
            rows = len(piece) - max(ahead, 1)
            parts = [s[:rows] for s in states.values()]
            if isinstance(self.scenario, PathScenario):
                place = states[self.scenario.target][:, list(self.scenario.target_indices())]
                parts += [place[k : k + rows] - place[:rows] for k in range(1, ahead + 1)]
            observations.append(np.concatenate(parts, axis=1))
            actions.append(commands[:rows])
        if not observations:
            raise InputError("imitation: no piece is given; record some with the scenario")
        return np.concatenate(observations), np.concatenate(actions)

    def _world(self) -> World:
        """The world of run 0 of the episode's seed."""
        if self._path is not None:
            return self.scenario.make_world(self._path, 0)  # type: ignore[attr-defined, no-any-return]
        return self.scenario.make_world(0)  # type: ignore[attr-defined, no-any-return]

    def _all(self, port: str) -> dict[str, FloatArray]:
        """What a port of every object gives now."""
        assert self._episode is not None
        world = self._episode.world
        return {
            name: self._episode.value(name, port)
            for name in world.graph.objects
            if world.system(name).HasOutputPort(port)
        }

    def _observe(self, measured: dict[str, FloatArray]) -> FloatArray:
        return np.concatenate([*measured.values(), self._judge.observe(measured)])

    def _info(self, *, success: bool) -> dict[str, Any]:
        valid = np.concatenate(list(self._all("valid").values()))
        return {"seed": self.scenario.seed, "time": self._tick * TICK, "success": success, "valid": valid}


def _task(scenario: Scenario, path: str, goal: Sequence[str], lookahead: int) -> tuple[TimedPath | None, Judge]:
    """What an episode is for."""
    if isinstance(scenario, PathScenario):
        if goal:
            raise InputError(f"{scenario.name} follows paths; leave goal {goal[0]!r} out")
        paths = scenario.reference_paths()
        name = path or next(iter(paths))
        if name not in paths:
            raise InputError(f"{scenario.name} has no path {name!r}; it has {', '.join(paths)}")
        timed = TimedPath(paths[name], scenario.path_limits())
        return timed, PathJudge(scenario, timed, lookahead)
    if not isinstance(scenario, GraphScenario):
        raise InputError(f"{scenario.name} has neither paths nor a goal; an environment needs one of them")
    if path:
        raise InputError(f"{scenario.name} has no paths; leave path {path!r} out")
    return None, GoalJudge(goal or scenario.config.goal, scenario.graph)


class _Held(TickSystem):
    """Sends the command that it was handed, from the next tick on.

    Attributes:
        command: shape (n_hand,).
    """

    def __init__(self, command: FloatArray) -> None:
        super().__init__("commands")
        self.command = command
        self._sent = self.DeclareDiscreteState(command)
        self.DeclareStateOutputPort("hand_command", self._sent)

    def decide(self, context: Context, state: State, tick: int) -> None:
        """Send it."""
        state.get_mutable_discrete_state().set_value(self._sent, self.command)
