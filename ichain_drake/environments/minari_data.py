"""A system's scripted demonstrations as a Minari data set, with the rewards of its environment (extra `minari`)."""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ichain_drake.demonstrations.checks import known_units
from ichain_drake.demonstrations.columns import COMMAND, column
from ichain_drake.demonstrations.exporting.columns import map_text
from ichain_drake.environments.environment import SystemEnvironment
from ichain_drake.errors import InputError
from ichain_drake.files import write_whole
from ichain_drake.scenarios.graph_scenario import FIRST_DEMONSTRATION, GraphScenario
from ichain_drake.state import FloatArray
from ichain_drake.timing import TICK


@dataclass(frozen=True)
class Played:
    """An episode of an environment.

    Attributes:
        name: of the piece.
        observations: shape (n_steps + 1, n_observation).
        actions: as they were taken, shape (n_steps, n_hand).
        rewards: shape (n_steps,).
        terminated, truncated: whether the last step ended it, and how.
    """

    name: str
    observations: FloatArray
    actions: FloatArray
    rewards: FloatArray
    terminated: bool
    truncated: bool


def played_script(env: SystemEnvironment) -> Iterator[Played]:
    """The pieces of a scenario's script, each played in its own start as an episode of the environment.

    They are short and show one thing each; few of them reach the goal.

    Args:
        env: of a scenario with a goal.

    Raises:
        InputError: if it follows paths: whoever demonstrates there follows none.
    """
    scenario = env.scenario
    if not isinstance(scenario, GraphScenario):
        raise InputError(f"{scenario.name}: its demonstrations follow no path, so they have no reward; use imitation()")
    rng = np.random.default_rng([scenario.seed, scenario.script_purpose])
    for number, piece in enumerate(scenario.script(rng)):
        piece.check(scenario.graph)
        seen, _ = env.begin(scenario.build_world(piece.start, FIRST_DEMONSTRATION + number))
        observations, actions, rewards = [seen], [], []
        terminated = truncated = False
        for command in piece.commands:
            seen, reward, terminated, truncated, _ = env.step(command)
            observations.append(seen)
            actions.append(env.command)
            rewards.append(reward)
            if terminated or truncated:
                break
        yield Played(piece.name, np.array(observations), np.array(actions), np.array(rewards), terminated, truncated)


def write_minari(env: Any, dataset: str, description: str = "") -> Any:
    """Write a system's scripted demonstrations as a Minari data set, where Minari keeps them.

    Beside its data stands `map.yaml`, by which `ichain import minari` makes demonstrations of it again.

    Args:
        env: of `make_env` or `gymnasium.make`; the latter's can be made again from the data set.
        dataset: its id, such as `ichain/kettle-v0`.
        description: what it shows; default: that these are the script's pieces.

    Returns:
        The `minari.MinariDataset`.

    Raises:
        InputError: if Minari is not installed, the id is bad or taken, or the scenario follows paths.
    """
    try:
        minari = importlib.import_module("minari")
        buffers = importlib.import_module("minari.data_collector")
    except ImportError as error:
        raise InputError(f"this needs {error.name}; install it with `pip install 'ichain_drake[minari]'`") from None
    inner: SystemEnvironment = env.unwrapped
    episodes = [
        buffers.EpisodeBuffer(
            id=number,
            seed=inner.scenario.seed,
            observations=played.observations,
            actions=played.actions,
            rewards=played.rewards.tolist(),
            terminations=[False] * (len(played.rewards) - 1) + [played.terminated],
            # An episode that merely stops is cut short.
            truncations=[False] * (len(played.rewards) - 1) + [not played.terminated],
        )
        for number, played in enumerate(played_script(inner))
    ]
    try:
        made = minari.create_dataset_from_buffers(
            dataset,
            episodes,
            env=env,
            algorithm_name="script",
            description=description or f"The pieces of {inner.scenario.name}'s script, one thing each.",
            requirements=["ichain_drake"],
        )
    except ValueError as error:
        raise InputError(f"data set {dataset!r:.80}: {' '.join(str(error).split())[:200]}") from None
    write_whole(minari.storage.get_dataset_path(dataset) / "map.yaml", _map_of(inner))
    return made


def _map_of(env: SystemEnvironment) -> bytes:
    """Which of an episode's numbers is which variable."""
    columns = {f"observations[{i}]": name for i, name in enumerate(env.observation_names)}
    columns |= {f"actions[{i}]": column(COMMAND, name) for i, name in enumerate(env.command_names)}
    return map_text(columns, known_units(env.scenario.graph), rate=round(1 / TICK, 9))
