"""Driving by motion under feedback: turn after turn, with new grasps, a slipping gear and a stop where it is wanted."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from winding import GEAR, SHADE_START, TURN, shade, shade_skills

from ichain_drake.control.execution.executor import Executor, Memory
from ichain_drake.control.execution.following import goes_along
from ichain_drake.control.execution.moving import Moving
from ichain_drake.control.execution.tasks import DONE, Answer, Failed, Mode, View
from ichain_drake.control.planning.goals import parse_goal
from ichain_drake.control.planning.plan import NoPlan, Plan
from ichain_drake.control.planning.planner import GraphPlanner
from ichain_drake.control.settings import PLANNING
from ichain_drake.learning.settings import LEARNING


def wind(goal: list[str], gear: float = GEAR, play: float = 0.0) -> tuple[Memory, dict[str, np.ndarray], int]:
    """A run on a shade whose gear isn't quite the model's; also how often the knob was taken."""
    model, rng = shade(), np.random.default_rng(3)
    run = Executor(model, shade_skills(), GraphPlanner(model).plan, parse_goal(goal, model, SHADE_START))
    state = {n: v.copy() for n, v in SHADE_START.items()}
    memory, slack, grasps = run.start(state["robot"]), 0.0, 0
    for _ in range(1500):
        read = {n: v + 1e-4 * rng.standard_normal(len(v)) * (n != "robot") for n, v in state.items()}
        command = run.decide(memory, read, dict.fromkeys(state, True))
        if memory.stopped:
            break
        grasps += command[1] > state["robot"][1]
        turn = command[0] - state["robot"][0] if command[1] > 0.5 and state["robot"][1] > 0.5 else 0.0
        push = slack + turn - np.clip(slack + turn, -play / 2, play / 2)
        slack += turn - push
        state = {"robot": command, "knob": state["knob"] + turn, "shade": np.clip(state["shade"] + gear * push, 0, 1)}
    return memory, state, grasps


def test_a_shade_is_wound_by_more_than_the_wrist_can_turn() -> None:
    memory, state, grasps = wind(["0.78 <= shade.height <= 0.82", "not robot->knob"])
    assert (memory.mode, memory.replans) == (Mode.REACHED, 0), memory.log
    assert 0.78 <= state["shade"][0] <= 0.82
    assert state["robot"][1] == 0.0
    assert grasps >= 3


def test_play_and_another_gear_are_made_up_for_under_feedback() -> None:
    memory, state, _ = wind(["0.63 <= shade.height <= 0.65", "not robot->knob"], gear=0.8 * GEAR, play=0.3)
    assert memory.mode == Mode.REACHED, memory.log
    assert 0.63 <= state["shade"][0] <= 0.65


def test_a_gear_that_is_broken_is_found_out_and_no_plan_is_made_twice() -> None:
    memory, state, _ = wind(["0.78 <= shade.height <= 0.82"], gear=0.0)
    assert memory.mode == Mode.STOPPED
    assert state["shade"][0] == SHADE_START["shade"][0]
    made = [tuple((s.chain, s.until and s.until[:3], s.variant) for s in p.steps) for p in memory.plans]
    assert len(made) == len(set(made)) >= 2


def test_what_has_a_value_of_its_own_goes_along_by_the_change_of_the_effect() -> None:
    # The knob springs back to 0: the effect says how far from there it is, not how far it goes in a tick.
    model = shade()
    model.passive["knob"].variables[0].kind = "constant"
    model.acts[TURN] = lambda p, q, c: q[..., :1]
    variable = model.graph.objects["knob"].observable.variables[0]
    object.__setattr__(variable, "role", type("Role", (), {"kind": "orientation"})())
    turns = np.linspace(0.5, 1.0, 8)
    held = [{"robot": np.array([t, 1.0]), "knob": np.array([t]), "shade": np.array([0.5])} for t in turns]
    stuck = [{**r, "knob": np.array([0.5])} for r in held]
    assert goes_along(model, TURN, held) is True
    assert goes_along(model, TURN, stuck) is False


def test_a_goal_that_holds_is_seen_before_anything_is_given_up() -> None:
    model = shade()
    goal = parse_goal(["shade.height <= 0.5"], model, SHADE_START)
    refused = NoPlan(goal.conditions[0], 0.3, None, "nothing was found")
    run = Executor(model, shade_skills(), lambda *asked: refused, goal)
    memory = run.start(SHADE_START["robot"])
    for _ in range(60):
        run.decide(memory, SHADE_START, dict.fromkeys(SHADE_START, True))
    assert memory.mode == Mode.REACHED
    assert memory.log[-1][1] == "no plan: the goal holds all the same"
    run.goal = parse_goal(["shade.height >= 0.5"], model, SHADE_START)
    memory = run.start(SHADE_START["robot"])
    for _ in range(60):
        run.decide(memory, SHADE_START, dict.fromkeys(SHADE_START, True))
    assert (memory.mode, memory.cause, memory.reason) == (Mode.STOPPED, "no plan", "nothing was found")


def turned(
    value: float,
    direction: int = 1,
    *,
    gear: float = GEAR,
    ticks: int = 30,
    held: Callable[[int], bool] = lambda tick: True,
    **options: Any,
) -> tuple[Answer, list[dict[str, np.ndarray]]]:
    """The last answer of a motion that begins in the middle of a stroke, and the states until then."""
    model: Any = shade()
    goal = parse_goal(["shade.height >= 0.8" if direction > 0 else "shade.height <= 0.15"], model, SHADE_START)
    found = GraphPlanner(model).plan(SHADE_START, goal)
    assert isinstance(found, Plan)
    step = replace(found.steps[-1], until=("shade", "height", direction, value), ticks=ticks)
    task, now = (
        Moving(TURN, step=step),
        {"robot": np.array([-0.5 * direction, 1.0]), "knob": np.array([1.0 - 0.5 * direction])},
    )
    readings = [{**now, "shade": np.array([0.5])}]
    for tick in range(300):
        sign = 1.0 if held(tick) else -1.0
        model.gates[TURN] = lambda s, sign=sign: sign * (s["robot"][:, -1] - 0.5)
        answer = task.act(View(model, shade_skills(), readings, readings[-1]["robot"], **options))
        if not isinstance(answer, np.ndarray):
            return answer, readings
        last = readings[-1]
        turn = (answer[0] - last["robot"][0]) * (answer[1] > 0.5 and last["robot"][1] > 0.5)
        readings.append({"robot": answer, "knob": last["knob"] + turn, "shade": last["shade"] + gear * turn})
    return "no end", readings


@pytest.mark.parametrize(("value", "direction"), [(0.53, 1), (0.47, -1)])
def test_the_last_step_is_as_long_as_the_rest_and_then_it_is_looked_at(value: float, direction: int) -> None:
    answer, states = turned(value, direction)
    assert answer == DONE
    heights = np.array([s["shade"][0] for s in states])
    there = int(np.argmax(np.abs(heights - value) < 1e-6))
    np.testing.assert_allclose(heights[there:], value, atol=1e-9)
    assert len(heights) - there - 1 == LEARNING.ticks, "it looks for some ticks"
    steps = np.diff(heights[: there + 1]) * direction
    assert (steps > 0).all()


def test_what_it_changes_more_than_was_learned_is_made_up_for() -> None:
    answer, states = turned(0.6, gear=1.25 * GEAR)
    assert answer == DONE
    assert states[-1]["shade"][0] == pytest.approx(0.6, abs=2e-3)
    assert max(s["shade"][0] for s in states) < 0.6 + 2e-3


def test_at_the_end_of_a_stroke_it_is_taken_anew() -> None:
    answer, states = turned(0.75, ticks=90)
    assert answer == DONE
    grips = np.array([s["robot"][1] for s in states])
    assert (np.diff(grips) == -1).sum() == (np.diff(grips) == 1).sum() >= 1
    still = np.diff([s["knob"][0] for s in states])[grips[:-1] < 0.5]
    np.testing.assert_allclose(still, 0.0)


def test_what_slipped_out_of_the_hand_is_lost_where_somebody_looks() -> None:
    answer, states = turned(0.75, held=lambda tick: tick < 3)
    assert isinstance(answer, Failed)
    assert (answer.edge, answer.cause) == (TURN, "lost")
    assert answer.text == "robot->knob became inactive while it drove shade.height"
    assert 3 + LEARNING.look - 1 <= len(states) <= 3 + LEARNING.look + 2
    assert turned(0.53, held=lambda tick: tick % 3 > 0)[0] == DONE, "a reading now and then is nothing"
    assert turned(0.53, held=lambda tick: False, monitors=False)[0] == DONE


def test_what_does_not_get_on_or_takes_too_long_is_said() -> None:
    answer, states = turned(0.55, gear=0.0)
    assert isinstance(answer, Failed)
    assert (answer.edge.name, answer.cause) == ("knob->shade", "drive")
    assert answer.text == "shade.height is at 0.5, not yet at 0.55"
    assert turned(0.55, gear=0.0, monitors=False)[0] == DONE
    slow, after = turned(0.9, ticks=1)
    assert isinstance(slow, Failed)
    assert slow.cause == "drive"
    assert after[-1]["shade"][0] - after[-3]["shade"][0] > 0.005, "though it got on to the last"
    assert 2 * (1 + PLANNING.retake) < len(after) < 4 * (1 + PLANNING.retake)
