"""How fast a game that nobody here wrote runs inside the library: steps of its own a second, rendering off."""

from __future__ import annotations

import importlib.util
from typing import Any

import numpy as np
from pydrake.systems.analysis import Simulator

from ichain_drake.benchmarks.measure import processor_seconds
from ichain_drake.systems.car_racing.scenario import CarRacing
from ichain_drake.timing import FRAME

_STICK = (0.1, 0.02)  # a long bend at a steady speed


def games_installed() -> bool:
    """Whether the extra `games` is there."""
    return all(importlib.util.find_spec(name) is not None for name in ("gymnasium", "Box2D"))


def benchmark_games(seconds: float, repeats: int) -> dict[str, Any] | None:
    """Steps of CarRacing a second of processor time, as medians.

    Args:
        seconds: simulated time of each run [s].
        repeats: rounds.

    Returns:
        `bare_steps` for the game alone, without pictures; `steps` through the adapter, with its state put back and read
        in every frame; `diagram_steps` for the object in a Simulator; None without the extra `games`.
    """
    if not games_installed():
        return None
    scenario = CarRacing(physics="ideal")
    environment, state = scenario.environment, scenario.car_at(np.array(scenario.size) / 2, 0.0, 15.0)
    world = scenario.build_world(state, list(_STICK), 0)
    game = world.objects[scenario.target]
    frames = round(seconds / FRAME)
    (stick,) = game.parents
    values = np.zeros(game.GetInputPort(stick).size())
    values[game.parents[stick].observable_indices] = _STICK
    parents, active = {stick: values}, {stick: np.ones(())}
    action = game._action(parents, active)
    steps = round(frames * float(environment.spec.steps_per_frame))

    def alone() -> None:
        command = environment.action_space.value(action)
        environment.step(state, action, np.zeros(0))
        for _ in range(steps):
            environment.env.step(command)

    def through_the_adapter() -> None:
        current = state
        for _ in range(frames):
            current = game.step(current, parents, active, np.zeros(0), FRAME)

    context = game.CreateDefaultContext()
    game.GetInputPort(stick).FixValue(context, values)

    def in_a_diagram() -> None:
        Simulator(game, context.Clone()).AdvanceTo(frames * FRAME)

    out: dict[str, Any] = {"game": environment.where.removeprefix("environment "), "counted_steps": steps}
    runs = {"bare_steps": alone, "steps": through_the_adapter, "diagram_steps": in_a_diagram}
    for name, run in runs.items():
        run()
        out[name] = steps / float(np.median([processor_seconds(run) for _ in range(repeats)]))
    return out
