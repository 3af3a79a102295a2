"""Two robots in one execution: one keeps hold of a flap that a spring shuts, while the other fills a bucket."""

from collections.abc import Callable, Mapping
from functools import partial

import numpy as np
import pytest
from toy_models import TWO_HANDS_START, two_hands

from ichain_drake.control.execution.executor import Executor, ExecutorSettings, Memory
from ichain_drake.control.execution.keep import Keep
from ichain_drake.control.execution.laying_out import step_tasks
from ichain_drake.control.execution.switching import Switch
from ichain_drake.control.execution.tasks import DONE, Failed, Look, Mode, View
from ichain_drake.control.planning.goals import parse_goal
from ichain_drake.control.planning.plan import PlanStep
from ichain_drake.control.planning.planner import GraphPlanner
from ichain_drake.control.planning.skills import Skills
from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction
from ichain_drake.state import FloatArray

State = dict[str, FloatArray]
GOAL = ["bucket.filled >= 0.5"]
ROBOTS = ("one", "other")
FLAP = Interaction("one", "flap")


def switched(edge: Interaction, activate: bool, states: Mapping[str, FloatArray], attempt: int) -> FloatArray:
    """Close around a slider where it is, or open and go away from it."""
    x, y = float(states[edge.child][0]), 0.0 if edge.child == "flap" else 1.0
    if activate:
        return np.array([[x, y, 0.0], [x, y, 1.0]])
    return np.array([[*states[edge.parent][:2], 0.0], [0.5, 0.5, 0.0]])


def skills() -> Skills:
    own = {
        (edge, activate): partial(switched, edge, activate)
        for edge in (Interaction(r, n) for r in ROBOTS for n in ("flap", "valve"))
        for activate in (True, False)
    }
    return Skills({}, {}, own)


def advanced(state: State, sent: State) -> State:
    """A tick of the world: what was held goes along, however far, until the robot opens."""
    model = two_hands()
    ahead = {**state, **sent}
    on = {e: model.decide(e, ahead) >= 0 for e in model.graph.interactions}
    for e in model.graph.interactions:
        if e.parent in ROBOTS and model.decide(e, state) >= 0:
            on[e] = np.asarray(sent[e.parent][2] > 0.5)
    return model.step(state, sent, on)[0]  # type: ignore[no-any-return]


def execute(
    goal: list[str] = GOAL, mishap: Callable[[Memory, State], None] | None = None, ticks: int = 400
) -> tuple[Memory, list[State], list[FloatArray]]:
    """A run in a world that is as the model has it; states and commands of every tick."""
    model, rng = two_hands(), np.random.default_rng(3)
    run = Executor(
        model, skills(), GraphPlanner(model).plan, parse_goal(goal, model, TWO_HANDS_START),  # type: ignore[arg-type]
        ExecutorSettings(ticks=ticks),
    )  # fmt: skip
    state = {n: v.copy() for n, v in TWO_HANDS_START.items()}
    memory = run.start(np.concatenate([state[r] for r in ROBOTS]))
    states, commands = [state], []
    while not memory.stopped:
        read = {n: v + 1e-4 * rng.standard_normal(len(v)) * (n not in ROBOTS) for n, v in state.items()}
        command = run.decide(memory, read, dict.fromkeys(state, True))
        one, other = command[:3], command[3:]
        state = advanced(state, {"one": one, "other": other})
        if mishap is not None:
            mishap(memory, state)
        states.append(state)
        commands.append(command)
    return memory, states, commands


def test_one_keeps_hold_while_the_other_acts_and_all_is_let_go_of() -> None:
    memory, states, commands = execute()
    assert (memory.mode, memory.replans) == (Mode.REACHED, 0), (memory.reason, memory.log)
    last = states[-1]
    assert last["bucket"][0] >= 0.5
    assert last["flap"][0] == 0.0
    assert not memory.kept
    for robot in ROBOTS:
        assert last[robot][2] == 0.0
    moves = np.abs(np.diff(commands, axis=0)).reshape(len(commands) - 1, 2, 3).max(axis=2) > 0
    assert moves.any(axis=0).all()
    assert not moves.all(axis=1).any(), "one at a time"
    filling = [s for a, s in zip(states[:-1], states[1:], strict=True) if s["bucket"][0] > a["bucket"][0]]
    assert filling
    assert all(s["flap"][0] > 0.3 for s in filling)


def test_what_was_kept_and_is_lost_is_noticed_while_the_other_acts() -> None:
    done = []

    def lose(memory: Memory, state: State) -> None:
        holder = next((e.parent for e in memory.kept), "")
        if not done and holder and memory.robot != holder and state["bucket"][0] > 0.25:
            done.append(holder)
        if done and len(done) < 12:  # for as long its fingers are open, whatever it is told
            done.append(holder)
            state["flap"] = np.zeros(1)

    memory, states, _ = execute(mishap=lose)
    assert any(text.startswith("kept:") and "became inactive while" in text for _, text in memory.log), memory.log
    assert memory.mode == Mode.REACHED
    assert memory.replans >= 1
    assert states[-1]["bucket"][0] >= 0.5


def test_a_skill_belongs_to_some_robot() -> None:
    with pytest.raises(InputError, match="skill is given for flap->bucket"):
        Skills.of(two_hands(), {(Interaction("flap", "bucket"), True): lambda states, attempt: np.zeros((1, 3))})  # type: ignore[arg-type]


def view(flap: float, robot: tuple[float, float, float], command: tuple[float, float, float]) -> View:
    states = {**TWO_HANDS_START, "flap": np.array([flap]), "one": np.array(robot)}
    return View(two_hands(), skills(), [states] * 6, np.array(command))  # type: ignore[arg-type]


def test_keeping_goes_there_and_looks_whether_it_is_still_held() -> None:
    keep = Keep(FLAP, goal=np.array([0.15, 0.0, 1.0]))
    first = keep.act(view(0.0, (0.0, 0.0, 1.0), (0.0, 0.0, 1.0)))
    assert isinstance(first, np.ndarray)
    assert 0.0 < first[0] < 0.15
    keep.act(view(0.08, (0.08, 0.0, 1.0), (0.1, 0.0, 1.0)))
    assert keep.there
    there = view(0.15, (0.15, 0.0, 1.0), (0.15, 0.0, 1.0))
    answers = [keep.act(there) for _ in range(10)]
    assert any(isinstance(a, str) and a == DONE for a in answers)
    lost = Keep(FLAP, goal=np.array([0.15, 0.0, 1.0]), there=True)
    ends = [lost.act(view(0.0, (0.15, 0.0, 1.0), (0.15, 0.0, 1.0))) for _ in range(10)]
    failed = next(a for a in ends if isinstance(a, Failed))
    assert failed.cause == "lost"
    assert "one->flap became inactive before flap was in place" in failed.text


def test_a_step_that_keeps_hold_takes_and_stays_and_one_that_does_not_lets_go() -> None:
    model, hold = two_hands(), np.array([0.6, 0.0, 1.0])
    kept = step_tasks(model, PlanStep((FLAP,), hold=hold, release=False), TWO_HANDS_START)  # type: ignore[arg-type]
    assert [type(t) for t in kept] == [Switch, Keep, Look]
    assert isinstance(kept[0], Switch)
    assert kept[0].activate
    freed = step_tasks(model, PlanStep((FLAP,)), TWO_HANDS_START)  # type: ignore[arg-type]
    assert [type(t) for t in freed] == [Switch, Look]
