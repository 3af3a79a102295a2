"""A second graph executed: what is learned from the small world of the learning tests, and a loop that closes it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache

import numpy as np
from small_world import GRAPH, SmallWorld, pieces

from ichain_drake.control.execution.carried import Carried
from ichain_drake.control.execution.executor import Executor, ExecutorSettings, Memory
from ichain_drake.control.planning.goals import parse_goal
from ichain_drake.control.planning.planner import GraphPlanner
from ichain_drake.control.planning.skills import Skills
from ichain_drake.learning import InteractionModel, InteractionSpec, learn_interactions
from ichain_drake.learning.chain.link import EstimatorSpec
from ichain_drake.state import FloatArray

QUICK = InteractionSpec(
    effect_estimators=(EstimatorSpec.parse("polynomial(degree=1, clip=None)"),),
    status_estimators=(EstimatorSpec.parse("box(reach=0.15)"),),
)
Mishap = Callable[[int, SmallWorld], None]


@cache
def learned() -> tuple[InteractionModel, Skills, GraphPlanner]:
    shown = pieces()
    model = learn_interactions(shown, GRAPH, QUICK)
    return model, Skills.of(model), GraphPlanner(model)


def readings(world: SmallWorld) -> dict[str, FloatArray]:
    row = world.rows[-1]
    return {n: np.array([row[f"{n}.{v}"] for v in s.observable.names]) for n, s in GRAPH.objects.items()}


def executor(expressions: list[str], world: SmallWorld, settings: ExecutorSettings | None = None) -> Executor:
    model, skills, planner = learned()
    return Executor(model, skills, planner.plan, parse_goal(expressions, model, readings(world)), settings)


def fresh(seed: int = 77) -> SmallWorld:
    world = SmallWorld(seed)
    world.box, world.water, world.heat = np.array([0.35, 0.1, 0.0]), 0.1, 0.2
    world.stock, world.tap_heat = 0.9, 0.8
    world.rows.clear()
    world.record()
    return world


def drive(
    run: Executor,
    world: SmallWorld,
    ticks: int = 400,
    mishap: Mishap | None = None,
    valid: Callable[[int], Mapping[str, bool]] = lambda t: {},
    each: Callable[[Memory], None] = lambda m: None,
) -> Memory:
    memory = run.start(readings(world)["hand"])
    for tick in range(ticks):
        command = run.decide(memory, readings(world), dict.fromkeys(GRAPH.objects, True) | dict(valid(tick)))
        each(memory)
        if memory.stopped:
            break
        world.tick(command[:3], round(command[3]))
        if mishap is not None:
            mishap(tick, world)
    return memory


def where(carried: Carried, model: InteractionModel, now: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
    """Where things are, by one reading."""
    return carried.where(model, [now], now, now["hand"])
