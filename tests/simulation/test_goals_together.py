"""Runs towards goals that are calculated together are, in every bit of every frame, what each is in its own Diagram."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

from ichain_drake.control.execution.controller import GraphController
from ichain_drake.control.execution.executor import Executor, Memory
from ichain_drake.control.planning.goals import parse_goal
from ichain_drake.learning import InteractionModel
from ichain_drake.objects.rows import NotTogetherError
from ichain_drake.simulation.episode import EpisodeLog
from ichain_drake.simulation.goal_episode import GraphEpisode
from ichain_drake.simulation.goals_together import act_together, look_together
from ichain_drake.simulation.wiring import goal_executor, look, start_command
from ichain_drake.systems.water_dispenser.scenario import WaterDispenser
from ichain_drake.world.world import World

GOALS = ("cup.water >= 0.6", "cup.temperature >= 0.9", "tank.amount >= 0.5")
"""Which take times of their own."""


def worlds(*settings: str) -> list[World]:
    scenario = WaterDispenser(settings, "ideal", 3)
    return [scenario.make_world(k) for k in range(len(GOALS))]


def executors(model: InteractionModel) -> list[Executor]:
    return [
        goal_executor(model, parse_goal([goal], model, look(world)))
        for goal, world in zip(GOALS, worlds(), strict=True)
    ]


def alone(world: World, executor: Executor, ticks: int) -> tuple[EpisodeLog, Memory]:
    episode = GraphEpisode(world, GraphController(executor, start_command(world)))
    episode.run(ticks, lambda e: episode.memory.stopped)
    return episode.log(), episode.memory


def check(found: tuple[EpisodeLog, Memory], own: tuple[EpisodeLog, Memory]) -> None:
    for ours, theirs in ((found[0].states, own[0].states), (found[0].active, own[0].active)):
        assert set(ours) == set(theirs)
        for name, rows in theirs.items():
            np.testing.assert_array_equal(ours[name], rows)
    np.testing.assert_array_equal(found[0].command, own[0].command)
    np.testing.assert_array_equal(found[0].times, own[0].times)
    assert (found[1].mode, found[1].tick, found[1].log) == (own[1].mode, own[1].tick, own[1].log)


def test_each_is_what_it_is_alone_whoever_stops_first(dispenser_model: InteractionModel) -> None:
    found = act_together(worlds(), executors(dispenser_model), 2000)
    assert len({one[1].tick for one in found if one is not None}) == len(GOALS)
    for one, world, executor in zip(found, worlds(), executors(dispenser_model), strict=True):
        assert one is not None
        check(one, alone(world, executor, 2000))
        assert one[1].stopped


def test_those_that_are_not_done_are_cut_off(dispenser_model: InteractionModel) -> None:
    _, one, _ = act_together(worlds(), executors(dispenser_model), 30)
    assert one is not None
    check(one, alone(worlds()[1], executors(dispenser_model)[1], 30))
    assert not one[1].stopped


def test_what_is_seen_at_the_start_is_the_same(dispenser_model: InteractionModel) -> None:
    for seen, world in zip(look_together(worlds()), worlds(), strict=True):
        own = look(world)
        assert list(seen) == list(own)
        for name, state in own.items():
            np.testing.assert_array_equal(seen[name], state)


def test_an_executor_that_raises_is_in_nobodys_way(
    dispenser_model: InteractionModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    broken, *others = executors(dispenser_model)

    def decide(memory: Memory, measured: Mapping[str, Any], valid: Mapping[str, bool]) -> Any:
        if memory.readings:
            raise ZeroDivisionError
        memory.readings.append(dict(measured))
        return memory.command

    monkeypatch.setattr(broken, "decide", decide)
    found = act_together(worlds(), [broken, *others], 60)
    assert found[0] is None
    assert found[1] is not None
    check(found[1], alone(worlds()[1], executors(dispenser_model)[1], 60))


def test_sensors_that_drop_out_are_not_calculated_together(dispenser_model: InteractionModel) -> None:
    with pytest.raises(NotTogetherError):
        act_together(worlds("fault.kind=dropout"), executors(dispenser_model), 60)
