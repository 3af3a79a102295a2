"""Driving by motion under feedback: turn after turn, with new grasps, a slipping gear and a stop where it is wanted."""

import numpy as np
from winding import GEAR, SHADE_START, TURN, shade, shade_skills

from ichain_drake.control.execution.executor import Executor, Memory
from ichain_drake.control.execution.following import goes_along
from ichain_drake.control.execution.tasks import Mode
from ichain_drake.control.planning.goals import parse_goal
from ichain_drake.control.planning.plan import NoPlan
from ichain_drake.control.planning.planner import GraphPlanner


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
