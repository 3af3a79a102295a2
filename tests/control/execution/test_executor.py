"""Execution on a second, small graph: no word of it is known to the controller."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from small_job import GRAPH, SmallWorld, drive, executor, fresh, readings

from ichain_drake.control.execution.carried import Carried
from ichain_drake.control.execution.executor import Executor, ExecutorSettings, Memory
from ichain_drake.control.execution.tasks import Mode

FILL = ["box.water >= 0.4", "not hand->box"]


def test_a_box_is_filled_and_brought_back() -> None:
    world = fresh()
    start = world.box.copy()
    run = executor([*FILL, "box.x == start", "box.y == start", "box.z == start"], world)
    modes: list[Mode] = []
    memory = drive(run, world, each=lambda m: modes.append(m.mode))
    assert (memory.mode, memory.reason, memory.cause) == (Mode.REACHED, "goal reached", "")
    assert world.water > 0.4
    assert not world.held
    assert np.abs(world.box - start).max() < 0.01
    assert set(modes) == {Mode.LOOK, Mode.ACTIVATE, Mode.DEACTIVATE, Mode.CARRY, Mode.DRIVE, Mode.REACHED}
    assert memory.replans == 0
    assert memory.tick < 250


def test_a_range_in_between_is_hit() -> None:
    world = fresh()
    memory = drive(executor(["0.25 <= box.water <= 0.4", "not hand->box"], world), world)
    assert memory.mode == Mode.REACHED
    assert 0.25 <= world.water <= 0.4


def test_what_holds_already_needs_nothing() -> None:
    world = fresh()
    memory = drive(executor(["box.water <= 0.5"], world), world)
    assert memory.mode == Mode.REACHED
    assert memory.plan is not None
    assert memory.plan.steps == ()
    assert memory.tick <= 12


def slip(tick: int, world: SmallWorld) -> None:
    if world.held and world.box[2] > 0.05 and not getattr(world, "slipped", False):
        world.held, world.slipped = False, True  # type: ignore[attr-defined]
        world.box = np.array([*world.box[:2], 0.0])


def test_a_lost_grasp_is_noticed_and_taken_again() -> None:
    world = fresh()
    memory = drive(executor(FILL, world), world, mishap=slip)
    assert world.slipped  # type: ignore[attr-defined]
    assert memory.mode == Mode.REACHED
    assert memory.replans >= 1
    assert memory.log[0][1].startswith(("lost", "carry", "deviation", "activation"))
    assert world.water > 0.4


def test_without_monitors_the_lost_grasp_goes_unnoticed() -> None:
    world = fresh()
    memory = drive(executor(FILL, world, ExecutorSettings(monitors=False)), world, mishap=slip)
    assert memory.mode == Mode.REACHED
    assert "not watched" in memory.reason
    assert memory.replans == 0
    assert world.water < 0.4


def test_a_box_that_cannot_be_held_is_given_up_with_the_reason() -> None:
    def greasy(tick: int, world: SmallWorld) -> None:
        world.held = False

    world = fresh()
    memory = drive(executor(FILL, world, ExecutorSettings(replans=1, attempts=2)), world, mishap=greasy)
    assert memory.mode == Mode.STOPPED
    assert memory.cause
    assert "given up after 1 new plans" in memory.reason
    assert memory.replans == 1


def test_a_box_that_fell_from_the_table_is_given_up_at_once() -> None:
    def knocked_over(tick: int, world: SmallWorld) -> None:
        if tick >= 20:
            world.held, world.box = False, np.array([*world.box[:2], -30.0])

    world = fresh()
    memory = drive(executor(FILL, world), world, mishap=knocked_over)
    assert (memory.mode, memory.cause) == (Mode.STOPPED, "gone")
    assert "box is gone: its z is -29" in memory.reason
    assert memory.tick <= 23


def test_time_is_limited() -> None:
    world = fresh()
    memory = drive(executor(FILL, world, ExecutorSettings(ticks=20)), world)
    assert (memory.mode, memory.cause, memory.tick) == (Mode.STOPPED, "time", 21)
    assert memory.reason == "not done after 20 control steps"


def test_it_holds_while_a_sensor_is_blind() -> None:
    world = fresh()
    blind = range(15, 25)
    commands: list[np.ndarray] = []
    modes: list[Mode] = []

    def note(memory: Memory) -> None:
        commands.append(memory.command.copy())
        modes.append(memory.mode)

    memory = drive(executor(FILL, world), world, valid=lambda t: {"box": t not in blind}, each=note)
    assert memory.mode == Mode.REACHED
    assert world.water > 0.4
    for t in blind:
        assert modes[t] == Mode.BLIND
        np.testing.assert_array_equal(commands[t], commands[14])


def test_what_cannot_be_is_refused_at_once() -> None:
    world = fresh()
    memory = drive(executor(["box.water >= 0.99", "tap.stock >= 0.9"], world), world)
    assert (memory.mode, memory.cause) == (Mode.STOPPED, "no plan")
    assert "box.water" in memory.reason or "tap.stock" in memory.reason
    assert memory.tick <= 20


@pytest.mark.parametrize("seed", [5, 6])
def test_the_same_readings_give_the_same_commands(seed: int) -> None:
    ends = []
    for _ in range(2):
        world = fresh(seed)
        memory = drive(executor(FILL, world), world, ticks=60)
        ends.append((memory.command, readings(world)))
    np.testing.assert_array_equal(ends[0][0], ends[1][0])
    for name in GRAPH.objects:
        np.testing.assert_array_equal(ends[0][1][name], ends[1][1][name])


def test_what_is_seen_to_follow_while_a_task_goes_on_is_held_from_then_on() -> None:
    run: Any = SimpleNamespace(_view=lambda memory: SimpleNamespace(averaged=lambda: {"box": np.arange(3.0)}))
    memory: Any = SimpleNamespace(carried=Carried())
    for followed, following in ((False, ""), (True, "box")):
        kept = Executor._kept(run, memory, SimpleNamespace(followed=followed), "box", done=False)  # type: ignore[arg-type]
        assert kept.following == following
