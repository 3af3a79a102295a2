"""Execution on a second, small graph: no word of it is known to the controller."""

from contextlib import nullcontext
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from small_job import GRAPH, SmallWorld, drive, executor, fresh, readings
from toy_models import LAMP_START, lamp

from ichain_drake.control.execution.carried import Carried
from ichain_drake.control.execution.carrying import CarryTask
from ichain_drake.control.execution.detour import Blocked, Detour
from ichain_drake.control.execution.executor import Executor, ExecutorSettings, Memory
from ichain_drake.control.execution.switching import Switch
from ichain_drake.control.execution.taking_back import TakeBack
from ichain_drake.control.execution.tasks import DONE, Answer, Failed, Look, Mode, Task, View
from ichain_drake.control.planning.plan import Condition, Goal, NoPlan, Plan, PlanStep, States
from ichain_drake.control.planning.skills import Skills
from ichain_drake.control.settings import EXECUTION
from ichain_drake.errors import UnreachableError
from ichain_drake.graph import Interaction
from ichain_drake.learning.settings import LEARNING
from ichain_drake.rules import without

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


class Says(Task):
    """Answers as it is told, and notes what it saw."""

    def __init__(self, *answers: Any, edge: Interaction | None = None, travels: bool = False) -> None:
        self.edge, self.answers, self.saw = edge, list(answers), []
        self.travels = travels

    def act(self, view: View) -> Answer:
        self.saw.append(view.stopped)
        answer = self.answers.pop(0)
        if isinstance(answer, Exception):
            raise answer
        return answer


HOLD, THROW = Interaction("robot", "dimmer"), Interaction("robot", "switch")
COMMAND = np.array([0.3, 0.0, 1.0])
HELD = {**LAMP_START, "robot": COMMAND}
NONE = NoPlan(Condition("lamp", "light", 0.5, 1.0), 0.1, None, "nobody knows how")


def asked_for(
    *plans: Plan | NoPlan, goal: Goal | None = None, states: States = HELD, **settings: Any
) -> tuple[Executor, Memory, list[tuple[Any, ...]]]:
    """Over a lamp, by plans as they are handed in; after a reading, with nothing to do. Also what was asked for."""
    model: Any = lamp()
    model.customary = lambda edge: ("x",) if edge == HOLD else ()
    asked: list[tuple[Any, ...]] = []
    left = list(plans)

    def planner(*args: Any) -> Plan | NoPlan:
        asked.append(args)
        return left.pop(0)

    run = Executor(model, Skills({}, {}), planner, goal or Goal(()), ExecutorSettings(**settings))
    memory = run.start(states["robot"])
    run._sense(memory, states)
    memory.tasks = []
    return run, memory, asked


def decide(run: Executor, memory: Memory, states: States = HELD, **blind: bool) -> np.ndarray:
    return run.decide(memory, states, dict.fromkeys(states, True) | blind)


def test_it_looks_before_it_begins() -> None:
    run, _, _ = asked_for()
    memory = run.start(np.array([1, 2, 0]))
    assert [(type(t), t.ticks) for t in memory.tasks] == [(Look, LEARNING.look)]  # type: ignore[attr-defined]
    assert memory.command.dtype == float
    assert (memory.tick, memory.step, memory.mode) == (0, -1, Mode.LOOK)


def test_what_needs_no_time_takes_none_and_a_command_is_clipped() -> None:
    run, memory, _ = asked_for()
    first, second, third = Says(DONE), Says(DONE), Says(np.array([0.1, 0.2, 5.0]), DONE)
    memory.tasks = [first, second, third]
    np.testing.assert_array_equal(decide(run, memory), [0.1, 0.2, 1.0])
    assert (memory.tick, memory.tasks) == (1, [third])
    np.testing.assert_array_equal(memory.command, [0.1, 0.2, 1.0])


def test_that_it_was_stopped_is_told_to_the_task_that_was(monkeypatch: pytest.MonkeyPatch) -> None:
    run, memory, _ = asked_for()
    first, second = Says(DONE), Says(COMMAND)
    memory.tasks = [first, second]
    monkeypatch.setattr(run, "_stopped", lambda memory: True)
    decide(run, memory)
    assert (first.saw, second.saw) == ([True], [False])


def test_what_ends_at_once_over_and_over_again_is_stopped(monkeypatch: pytest.MonkeyPatch) -> None:
    run, memory, _ = asked_for()
    monkeypatch.setattr(run, "_next", lambda memory: None)
    np.testing.assert_array_equal(decide(run, memory), COMMAND)
    assert (memory.mode, memory.cause) == (Mode.STOPPED, "loop")
    decide(run, memory)
    assert memory.tick == 1, "nothing happens any more"


def test_where_it_cannot_get_to_the_interaction_is_named() -> None:
    run, memory, _ = asked_for(replans=0)
    with pytest.raises(UnreachableError):
        run._act(memory, Says(UnreachableError("there is a wall")), stopped=False)
    said = run._act(memory, Says(UnreachableError("there is a wall"), edge=THROW), stopped=False)
    assert said == Failed(THROW, "reach", "robot->switch: there is a wall")


def test_readings_are_kept_as_long_as_anything_looks_at_them_and_their_noise_is_read_now_and_then() -> None:
    run, memory, _ = asked_for()
    memory.readings, told = [], []
    memory.model, memory.noise = (
        None,
        SimpleNamespace(  # type: ignore[assignment]
            seen=lambda model, before, now: memory.noise, in_force=lambda model: told.append(memory.tick) or model
        ),
    )
    for tick in range(1, 3 * EXECUTION.readings + 1):
        memory.tick = tick
        run._sense(memory, {**HELD, "dimmer": np.array([float(tick)])})
        assert len(memory.readings) == min(tick, EXECUTION.readings)
        assert memory.readings[-1]["dimmer"][0] == tick
    assert told == [1, *(EXECUTION.readings * k for k in (1, 2, 3))]


@pytest.mark.parametrize("hindered", ["", "motion", "monitors", "rule", "task", "nothing to do"])
def test_it_is_seen_to_be_stopped_only_on_its_way_where_nobody_else_lays_it_out(hindered: str) -> None:
    run, memory, _ = asked_for(monitors=hindered != "monitors")
    run.motion = SimpleNamespace() if hindered == "motion" else None  # type: ignore[assignment]
    memory.tasks = [] if hindered == "nothing to do" else [Says(travels=hindered != "task")]
    memory.readings = [HELD] * LEARNING.ticks
    memory.command = np.array([1.0, 0.0, 0.0])
    with without(["detour"]) if hindered == "rule" else nullcontext():
        assert run._stopped(memory) is not bool(hindered)
    if hindered:
        assert memory.blocked is None
        return
    assert memory.blocked is not None
    np.testing.assert_allclose(memory.command, [0.3, 0.0, 0.0], err_msg="from where it is; what jumps stays as told")
    again = memory.blocked
    memory.command = np.array([0.3, 1.0, 0.0])
    memory.readings = [HELD] * LEARNING.ticks
    assert run._stopped(memory)
    assert len(memory.blocked.places) > len(again.places), "what was known stays known"


def test_without_a_plan_it_looks_once_more_and_longer() -> None:
    run, memory, asked = asked_for(NONE, NONE)
    run._next(memory)
    assert memory.looked_again
    assert [t.ticks for t in memory.tasks] == [EXECUTION.readings]  # type: ignore[attr-defined]
    memory.tasks = []
    run._next(memory)
    assert (memory.giving_up, len(asked)) == (("no plan", "nobody knows how"), 2)
    assert memory.refused is NONE
    assert memory.tasks == [], "it has looked long enough"
    run, memory, _ = asked_for(NONE, monitors=False)
    run._next(memory)
    assert (memory.mode, memory.cause, memory.reason) == (Mode.STOPPED, "no plan", "nobody knows how")


STEP = PlanStep((HOLD, Interaction("dimmer", "lamp")), until=("lamp", "light", 1, 0.5), predicted=HELD, ticks=5)
PLAN = Plan((STEP, replace(STEP, chain=(THROW,), until=None)), 10)


def test_a_plan_is_carried_out_step_by_step_and_what_it_lacks_in_the_end_is_planned_anew() -> None:
    wanted = Goal((Condition("lamp", "light", 0.5, 1.0),))
    run, memory, asked = asked_for(PLAN, PLAN, goal=wanted)
    run._next(memory)
    assert (memory.plan, memory.step, memory.plans, memory.tasks) == (PLAN, -1, [PLAN], [])
    for k in (0, 1):
        run._next(memory)
        assert (memory.step, memory.began["dimmer"][0]) == (k, 0.3)
        assert memory.tasks
        memory.tasks = []
    run._next(memory)
    assert (memory.replans, memory.plan, memory.step) == (1, None, -1)
    assert memory.log == [(0, "goal unmet: 0.5 <= lamp.light <= 1 does not hold: it is 0")]
    assert [c.step for c in memory.experience.contradictions] == [PLAN.steps[1]]
    assert [t.ticks for t in memory.tasks] == [LEARNING.look]  # type: ignore[attr-defined]
    memory.tasks = []
    run._next(memory)
    assert [len(a[2].contradictions) for a in asked] == [0, 1], "the next plan knows of it"
    assert memory.plans == [PLAN, PLAN]


def test_what_is_not_as_predicted_is_seen_before_the_next_step_begins() -> None:
    off = replace(STEP, predicted={**HELD, "dimmer": np.array([0.9])})
    run, memory, _ = asked_for(PLAN)
    memory.plan, memory.step, memory.began = replace(PLAN, steps=(off, STEP)), 0, HELD
    run._next(memory)
    assert memory.replans == 1
    assert memory.log[0][1].startswith("deviation: dimmer.x is 0.3 where 0.9 was predicted")
    assert [c.step for c in memory.experience.contradictions] == [off]
    run, memory, _ = asked_for(PLAN, monitors=False)
    memory.plan, memory.step, memory.began = replace(PLAN, steps=(off, STEP)), 0, HELD
    run._next(memory)
    assert (memory.step, memory.replans) == (1, 0), "nobody looks"


def test_so_many_new_plans_are_made_and_no_more() -> None:
    run, memory, _ = asked_for(replans=2)
    for k in (1, 2):
        run._replan(memory, "drive", "it stays dark")
        assert (memory.replans, memory.giving_up) == (k, None)
    memory.looked_again = True
    run._replan(memory, "drive", "it stays dark")
    assert (memory.replans, memory.giving_up) == (2, ("drive", "it stays dark; given up after 2 new plans"))
    assert len(memory.log) == 3


@pytest.mark.parametrize(
    ("cause", "more", "follows", "tasks"),
    [
        ("activation", {}, False, ["release"]),
        ("drive", {}, False, ["release"]),
        ("reach", {}, False, ["unforced"]),
        ("deactivation", {}, False, []),
        ("drive", {"before": {("dimmer", "x"): 0.1}}, True, ["carry"]),
        ("drive", {"before": {("dimmer", "x"): 0.1}}, False, ["release"]),
        ("carry", {"before": {("dimmer", "x"): 0.1}}, True, []),
        ("reach", {"after": {("dimmer", "x"): 0.1}}, True, ["carry", "put down"]),
        ("drive", {"after": {("dimmer", "x"): 0.1}}, True, []),
        ("lost", {"after": {("dimmer", "x"): 0.1}}, True, ["take back", "release"]),
        ("drive", {}, True, ["release"]),  # what it touches is not carried
    ],
)
def test_after_a_failure_what_is_held_is_put_back_and_what_is_touched_is_let_go_of(
    cause: str, more: dict[str, Any], *, follows: bool, tasks: list[str]
) -> None:
    run, memory, _ = asked_for()
    memory.plan, memory.step, memory.began = Plan((replace(STEP, **more),), 5), 0, HELD
    memory.readings = [{**HELD, "robot": np.array([0.5, 0.5, 0.0])}]  # no classifier says that it is held
    if follows:
        memory.carried = Carried().taken("dimmer", np.array([0.2])).watched(True)
    memory.blocked = Blocked(held="something else")
    run._failed(memory, Failed(HOLD, cause, "it failed"))

    def named(task: Task) -> str:
        if isinstance(task, Switch):
            assert (task.edge, task.activate) == (HOLD, False)
            return "release" if task.forced else "put down" if follows else "unforced"
        return {CarryTask: "carry", TakeBack: "take back"}.get(type(task), "look")  # type: ignore[arg-type]

    assert [named(t) for t in memory.tasks] == [*tasks, "look"]
    assert (memory.blocked is None) == (cause == "reach"), "what was in the way may be narrower than it was taken for"
    if cause == "lost":
        assert (memory.carried.held, memory.carried.following) == (None, "")
    if "carry" in tasks:
        (carry,) = [t for t in memory.tasks if isinstance(t, CarryTask)]
        assert carry.target == {0: 0.2 if cause == "reach" else 0.1}, "where it was taken, or where it was brought"
    assert [c.step.chain for c in memory.experience.contradictions] == [STEP.chain]


def test_what_nobody_saw_coming_makes_it_cautious_once_where_more_was_shown() -> None:
    run, memory, _ = asked_for()
    run._failed(memory, Failed(HOLD, "drive", "too slow"))
    assert memory.experience.cautious == ()
    for edge in (THROW, HOLD, HOLD):
        run._failed(memory, Failed(edge, "activation", "it does not begin"))
    assert memory.experience.cautious == (HOLD,)
    assert [text for _, text in memory.log if text.startswith("cautious")] == [
        "cautious: robot->dimmer only as it was shown, by x"
    ]


def test_what_failed_before_anything_was_planned_contradicts_nothing() -> None:
    run, memory, _ = asked_for()
    run._contradicted(memory)
    memory.plan = Plan((), 0)
    memory.began = HELD
    run._contradicted(memory)
    assert memory.experience.contradictions == ()
    memory.plan, memory.step = PLAN, -1
    run._contradicted(memory)
    memory.step = 5
    run._contradicted(memory)
    assert [c.step for c in memory.experience.contradictions] == [PLAN.steps[0], PLAN.steps[1]]


def test_given_up_it_lets_go_of_what_must_not_be_held_and_looks_whether_the_goal_holds_all_the_same() -> None:
    free = {**HELD, "robot": np.array([0.5, 0.5, 0.0])}
    goal = Goal((Condition("dimmer", "x", 0.2, 0.4),), inactive=(HOLD, THROW))
    run, memory, _ = asked_for(goal=goal)
    run._give_up(memory, "drive", "too slow")
    let_go, look = memory.tasks
    assert isinstance(let_go, Switch)
    assert (let_go.edge, let_go.activate, let_go.forced) == (HOLD, False, False)
    assert isinstance(look, Look)
    assert look.ticks == EXECUTION.readings
    for cause, step, switched in (("drive", 1, [THROW]), ("drive", 0, [HOLD]), ("reach", 0, []), ("drive", -1, [])):
        run, memory, _ = asked_for(goal=goal, states=free)
        memory.plan, memory.step = PLAN, step
        run._give_up(memory, cause, "too slow")
        assert [(t.edge, t.forced) for t in memory.tasks if isinstance(t, Switch)] == [(e, True) for e in switched]
    memory.readings = [free] * 3
    run._last_look(memory)
    assert (memory.mode, memory.reason) == (Mode.REACHED, "goal reached")
    assert memory.log[-1][1] == "drive: the goal holds all the same"
    run, memory, _ = asked_for(goal=goal)
    memory.giving_up = ("drive", "too slow")
    run._last_look(memory)
    assert (memory.mode, memory.cause, memory.reason) == (Mode.STOPPED, "drive", "too slow")


def test_ways_lead_around_where_it_was_stopped_with_as_much_in_hand() -> None:
    run, memory, _ = asked_for()
    assert (run._view(memory).motion, run._view(memory).news) == (None, 0)
    memory.blocked = Blocked(np.array([[0.5], [0.6]]), held="dimmer")
    assert (run._view(memory).motion, run._view(memory).news) == (None, 2), "with nothing in hand it may pass"
    memory.carried = Carried().taken("dimmer", np.array([0.3]))
    around = run._view(memory).motion
    assert isinstance(around, Detour)
    assert around.blocked is memory.blocked
    memory.blocked = Blocked(np.array([[0.5]]))
    assert run._view(memory).motion is None
    memory.carried = Carried()
    assert isinstance(run._view(memory).motion, Detour)
    given: Any = SimpleNamespace()
    run.motion = given
    assert run._view(memory).motion is given, "who knows what stands there lays them out"


def test_a_planner_is_asked_for_more_than_holds_by_less_than_readings_can_tell_where_somebody_looks() -> None:
    model = lamp()
    goal = Goal((Condition("dimmer", "x", 0.3 - 0.5 * model.noise["dimmer"][0], 1.0),))
    for monitors in (True, False):
        run, memory, asked = asked_for(PLAN, goal=goal, monitors=monitors)
        run._next(memory)
        wanted = asked[0][1].conditions[0]
        assert bool(wanted.lower > goal.conditions[0].lower) is monitors
        assert asked[0][0]["dimmer"][0] == 0.3


def test_what_is_in_hand_follows_from_what_was_switched() -> None:
    run, memory, _ = asked_for()
    let_go, take = Switch(HOLD, activate=False), Switch(HOLD, activate=True)
    held = Carried().taken("dimmer", np.array([0.3]))
    memory.carried = held
    after = run._kept(memory, let_go, "dimmer", done=False)
    assert (after.held, dict(after.seen)) == (None, {})
    np.testing.assert_array_equal(after.left["dimmer"], COMMAND)
    memory.carried = after
    assert run._kept(memory, let_go, "dimmer", done=False) is after
    assert run._kept(memory, let_go, "dimmer", done=True).seen["dimmer"].tolist() == [0.3]
    memory.carried = Carried()
    assert run._kept(memory, take, "dimmer", done=True).held is None, "a button is not carried"
    take.onward = Says()
    assert run._kept(memory, take, "dimmer", done=True).held is None
    take.taken = np.array([0.7])
    assert run._kept(memory, take, "dimmer", done=False).held is None
    taken = run._kept(memory, take, "dimmer", done=True)
    assert (taken.held, taken.origin) == ("dimmer", (0.7,)), "where it was as the hand closed"


def test_once_it_gives_up_whatever_fails_ends_in_a_last_look() -> None:
    run, memory, _ = asked_for(goal=Goal((Condition("lamp", "light", 0.5, 1.0),)))
    memory.giving_up = ("drive", "too slow")
    run._failed(memory, Failed(HOLD, "reach", "no way"))
    assert (memory.mode, memory.cause, memory.reason, memory.replans) == (Mode.STOPPED, "drive", "too slow", 0)
    memory.mode, memory.tasks = Mode.LOOK, []
    run._next(memory)
    assert memory.mode == Mode.STOPPED
