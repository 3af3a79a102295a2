"""Carrying under feedback: when it has arrived, and what tells that the child does not come along."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from moved_thing import EDGE, model

from ichain_drake.control.execution.carrying import CarryPartTask, CarryTask
from ichain_drake.control.execution.tasks import DONE, Answer, Failed, View
from ichain_drake.control.planning.skills import Skills
from ichain_drake.control.settings import PLANNING
from ichain_drake.state import FloatArray

SKILLS = Skills({}, {})
START = {"robot": np.array([0.1, 1.0]), "thing": np.array([0.3, 0.5])}


def carry(
    task: CarryTask,
    gain: Callable[[int], float] = lambda tick: 1.0,
    active: Callable[[int], float] = lambda tick: 1.0,
    before: tuple[float, ...] = (),
    ticks: int = 80,
    **options: object,
) -> tuple[Answer, dict[str, FloatArray], int]:
    """Carry a thing that follows by some share; the end, and ticks until then."""
    toy = model()
    state = {n: v.copy() for n, v in START.items()}
    readings = [{**state, "robot": np.array([x, 1.0])} for x in before] + [state]
    for tick in range(ticks):
        toy.gates[EDGE] = lambda s, tick=tick: np.full(len(s["thing"]), active(tick))
        answer = task.act(View(toy, SKILLS, readings, state["robot"], **options))  # type: ignore[arg-type]
        if not isinstance(answer, np.ndarray):
            return answer, state, tick
        moved = np.array([gain(tick) * (answer[0] - state["robot"][0]), 0.0])
        state = {"robot": answer, "thing": state["thing"] + moved}
        readings.append(state)
    return "no end", state, ticks


@pytest.mark.parametrize("gain", [1.0, 0.8, 1.15])
def test_it_brings_the_thing_there_whatever_its_model_lacks(gain: float) -> None:
    for target in (0.75, -0.2):
        answer, state, ticks = carry(CarryTask(EDGE, target={0: target}), lambda tick: gain)
        assert answer == DONE
        assert state["thing"][0] == pytest.approx(target, abs=3e-3)
        assert state["robot"][1] == 1.0
        assert 6 <= ticks < 40


def test_it_looks_before_it_says_that_it_is_there() -> None:
    answer, _, ticks = carry(CarryTask(EDGE, target={0: 0.3}))
    assert (answer, ticks) == (DONE, 3)


def test_a_thing_that_stays_is_told_by_its_pose_and_unwatched_it_is_gone_on_with() -> None:
    answer, _, ticks = carry(CarryTask(EDGE, target={0: 0.9}), lambda tick: 0.0)
    assert isinstance(answer, Failed)
    assert (answer.cause, answer.text) == ("lost", "robot->thing was taken for active, but thing did not go along")
    assert ticks == 5, "the way of two ticks is clear, and that for longer than noise lasts"
    answer, _, ticks = carry(CarryTask(EDGE, target={0: 0.9}), lambda tick: 0.0, monitors=False)
    assert answer == DONE
    assert ticks >= PLANNING.retake


def test_what_the_robot_did_before_says_nothing() -> None:
    task = CarryTask(EDGE, target={0: 0.3})
    carry(task, before=(0.0, 0.0), ticks=2)
    assert task.stays == 0
    task = CarryTask(EDGE, target={0: 0.9})
    carry(task, lambda tick: 0.0, ticks=3)
    assert task.stays == 1


def test_an_inactive_status_counts_unless_the_thing_is_seen_to_follow() -> None:
    task = CarryTask(EDGE, target={0: 0.9})
    answer, _, ticks = carry(task, active=lambda tick: -1.0 if tick >= 2 else 1.0)
    assert isinstance(answer, Failed)
    assert (answer.cause, answer.text) == ("lost", "robot->thing became inactive while thing was carried")
    assert ticks == 5
    now_and_then = carry(CarryTask(EDGE, target={0: 0.9}), active=lambda tick: -1.0 if tick % 4 else 1.0)
    assert now_and_then[0] == DONE
    assert carry(CarryTask(EDGE, target={0: 0.9}), active=lambda tick: -1.0, follows="thing")[0] == DONE


def test_what_comes_no_nearer_is_given_up_with_how_far_off_it_is() -> None:
    answer, _, ticks = carry(CarryTask(EDGE, target={0: 0.34, 1: 0.9}))  # its water does not follow at all
    assert isinstance(answer, Failed)
    assert (answer.cause, answer.edge) == ("carry", EDGE)
    assert answer.text == "robot->thing: thing.water stayed 0.4 1 off"
    assert PLANNING.retake < ticks < 2 * PLANNING.retake


def test_the_others_stay_as_they_are_when_it_begins() -> None:
    task = CarryPartTask(EDGE, target={0: 0.9}, every=(0, 1))
    carry(task, ticks=1)
    assert task.target == pytest.approx({0: 0.9, 1: 0.5})
    assert task.every == ()
