"""A classifier that is wrong about what the robot holds: it goes by what is seen to go along."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields

import numpy as np
import pytest
from small_job import SmallWorld, drive, fresh, learned, readings

from ichain_drake.control.execution.carried import Carried
from ichain_drake.control.execution.carrying import CarryTask
from ichain_drake.control.execution.executor import Executor, ExecutorSettings, Memory
from ichain_drake.control.execution.laying_out import step_tasks
from ichain_drake.control.execution.switching import Switch
from ichain_drake.control.execution.tasks import Mode
from ichain_drake.control.planning.goals import parse_goal
from ichain_drake.control.planning.plan import PlanStep
from ichain_drake.graph import Interaction
from ichain_drake.learning import InteractionModel
from ichain_drake.state import FloatArray

HELD = Interaction("hand", "box")
FILL = ["box.water >= 0.4", "not hand->box"]
Says = Callable[[Mapping[str, FloatArray], FloatArray], FloatArray]


class Mistaken(InteractionModel):
    """What was learned, but for the decisions about one interaction."""

    says: Says

    def decide(self, edge: Interaction, states: Mapping[str, FloatArray]) -> FloatArray:
        right = super().decide(edge, states)
        return self.says(states, right) if edge == HELD else right

    def with_noise(self, noise: dict[str, FloatArray]) -> Mistaken:
        return self


def mistaken(says: Says, goal: list[str], world: SmallWorld, settings: ExecutorSettings | None = None) -> Executor:
    """An executor whose classifier is wrong; what it plans with is not."""
    model, skills, planner = learned()
    wrong = Mistaken(**{f.name: getattr(model, f.name) for f in fields(model)})
    wrong.__dict__["says"] = says
    return Executor(wrong, skills, planner.plan, parse_goal(goal, model, readings(world)), settings)


def denies(states: Mapping[str, FloatArray], right: FloatArray) -> FloatArray:
    return np.full_like(right, -1.0)


def denies_in_the_air(states: Mapping[str, FloatArray], right: FloatArray) -> FloatArray:
    return np.where(np.asarray(states["box"])[..., 2] > 0.35, -1.0, right)


def trusts_the_grip(states: Mapping[str, FloatArray], right: FloatArray) -> FloatArray:
    """A closed hand that is not at the valve is taken for holding what stands on the ground."""
    hand, box = np.asarray(states["hand"]), np.asarray(states["box"])
    closed = (hand[..., 3] > 0.5) & (hand[..., 1] < 0.2) & (box[..., 2] < 0.35)
    return np.where(closed, 1.0, right)


@pytest.mark.parametrize("says", [denies, denies_in_the_air])
def test_what_goes_along_is_carried_on_whatever_the_classifier_says(says: Says) -> None:
    world = fresh()
    held: list[bool] = [False]

    def watch(tick: int, now: SmallWorld) -> None:
        if now.held != held[-1]:
            held.append(now.held)

    memory = drive(mistaken(says, FILL, world), world, mishap=watch)
    assert memory.mode == Mode.REACHED
    assert memory.log == []
    assert held == [False, True, False]
    assert world.water > 0.4
    assert not world.held


def test_a_real_slip_is_seen_although_the_classifier_does_not() -> None:
    world = fresh()
    slips: list[int] = []

    def slip(tick: int, now: SmallWorld) -> None:
        if now.held and now.box[2] > 0.05 and not slips:
            slips.append(tick)
            now.held, now.box = False, np.array([*now.box[:2], 0.0])

    memory = drive(mistaken(trusts_the_grip, FILL, world), world, mishap=slip)
    assert memory.mode == Mode.REACHED
    assert world.water > 0.4
    tick, text = memory.log[0]
    assert text == "lost: hand->box was taken for active, but box did not go along"
    assert tick <= slips[0] + 10


def test_what_never_goes_along_is_not_taken_for_held() -> None:
    def greasy(tick: int, now: SmallWorld) -> None:
        now.held = False

    world = fresh()
    memory = drive(mistaken(denies, FILL, world, ExecutorSettings(replans=0, attempts=2)), world, mishap=greasy)
    assert (memory.mode, memory.cause) == (Mode.STOPPED, "activation")
    assert memory.carried.following == ""


def test_what_got_caught_is_taken_back_before_the_hand_opens() -> None:
    """It does not follow for some ticks, and hangs where it is; then it is free again."""
    world = fresh()
    caught: list[int] = []
    hung: list[np.ndarray] = []

    def catch(tick: int, now: SmallWorld) -> None:
        if now.held and now.box[2] > 0.05 and not caught:
            hung.append(now.box.copy())
        if hung and len(caught) < 7:
            caught.append(tick)
            now.box = hung[0].copy()

    opened: list[float] = []

    def watch(memory: Memory) -> None:
        if memory.mode == Mode.DEACTIVATE and world.held:
            opened.append(float(world.box[2]))

    run = mistaken(lambda s, right: right, FILL, world)
    memory = drive(run, world, mishap=catch, each=watch)
    assert memory.log[0][1].startswith("lost")
    assert memory.mode == Mode.REACHED
    assert opened[0] < 0.01


def test_what_is_held_in_the_air_is_put_back_before_something_else_begins() -> None:
    world = fresh()
    model, _, _ = learned()
    now = readings(world)
    assert float(model.decide(HELD, now)) < 0
    press = PlanStep((Interaction("hand", "valve"),), until=("valve", "level", 1, 6.0), hold=now["hand"])

    assert HELD not in [t.edge for t in step_tasks(model, press, now, Carried())]
    held = Carried().taken("box", now["box"])
    assert HELD not in [t.edge for t in step_tasks(model, press, now, held)]
    held = held.watched(True)
    let_go = step_tasks(model, press, now, held)[0]
    assert isinstance(let_go, Switch)
    assert (let_go.edge, let_go.activate) == (HELD, False)
    lifted = now | {"box": now["box"] + [0.0, 0.0, 0.3, 0.0, 0.0, 0.0]}
    carry, let_go, *_ = step_tasks(model, press, lifted, held)
    assert isinstance(carry, CarryTask)
    assert carry.target == {i: now["box"][i] for i in range(3)}
    assert isinstance(let_go, Switch)
    assert let_go.edge == HELD
