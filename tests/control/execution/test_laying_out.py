"""The tasks of a step, in order, and those of the way back."""

from __future__ import annotations

import numpy as np
import pytest
from toy_models import TAP_START, ToyModel, tap

from ichain_drake.control.execution.carried import Carried
from ichain_drake.control.execution.carrying import CarryPartTask, CarryTask
from ichain_drake.control.execution.driving import Approach, DriveTask
from ichain_drake.control.execution.executor import Executor
from ichain_drake.control.execution.laying_out import carry_tasks, indices, step_tasks, way_back
from ichain_drake.control.execution.memory import Memory
from ichain_drake.control.execution.switching import Switch
from ichain_drake.control.execution.tasks import Failed, Look, Task
from ichain_drake.control.planning.plan import Condition, Goal, NoPlan, Plan, PlanStep
from ichain_drake.control.planning.skills import Skills
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.state import Role, StateSpace, Variable

TAKE, PRESS, RUN, FALL = (Interaction.parse(e) for e in ("robot->cup", "robot->tap", "tap->tank", "tank->cup"))
POUR = Interaction("jug", "glass")
PICK = Interaction("robot", "jug")
PLACE, TURN = ("jug", "x"), ("jug", "turn")


def pouring() -> ToyModel:
    """A jug that is moved and turned, each by itself, and pours into a glass."""
    x = Variable("x", "m", role=Role("position", "base", "x"))
    turn = Variable("turn", "rad", role=Role("orientation", "base", "y"))
    spaces = {n: StateSpace(n, (x, turn)) for n in ("robot", "jug")}
    spaces["glass"] = StateSpace("glass", (Variable("water", lower=0.0, upper=1.0),))
    rows = [{"robot": [v, t], "jug": [v, t], "glass": [0.2]} for v, t in ((0.0, 0.0), (0.5, 1.0), (1.0, 0.5))]
    return ToyModel(
        InteractionGraph(spaces, [PICK.name, POUR.name]),
        {e.name: lambda s: np.ones(len(s["jug"])) for e in (PICK, POUR)},
        {PICK.name: lambda p, q, c: q - p, POUR.name: lambda p, q, c: 0.1 * q[..., 1:]},
        {"jug": ["hold", "hold"], "glass": ["hold"]},
        {PICK.name: rows, POUR.name: rows},
        {},
    )


NOW = {"robot": np.array([0.2, 0.0]), "jug": np.array([0.2, 0.0]), "glass": np.array([0.2])}
STEP = PlanStep(
    (PICK, POUR), {PLACE: 0.8, TURN: 1.0}, ("glass", "water", 1, 0.6), before={PLACE: 0.7, TURN: 0.1},
    after={PLACE: 0.3, TURN: 0.0}, predicted=NOW, ticks=5,
)  # fmt: skip


def said(tasks: list[Task]) -> list[object]:
    """What each task is, and its target."""
    out: list[object] = []
    for t in tasks:
        if isinstance(t, Switch):
            out.append(f"{'+' if t.activate else '-'}{t.edge and t.edge.child}{'!' * t.forced}")
        elif isinstance(t, CarryPartTask):
            assert t.every == (0, 1)
            out.append(("part", dict(t.target)))
        elif isinstance(t, CarryTask):
            out.append(dict(t.target))
        elif isinstance(t, Approach):
            assert t.carry is not None
            out.append(("approach", *said([t.carry])))
        else:
            out.append(type(t).__name__)
    return out


def test_a_pour_is_brought_turned_back_and_put_away_and_turned_only_where_it_is_to_be() -> None:
    tasks = step_tasks(pouring(), STEP, NOW)
    assert said(tasks) == [
        "+jug",
        ("part", {0: 0.7}), {0: 0.7, 1: 0.1},
        ("approach", ("part", {0: 0.8})), ("approach", {0: 0.8, 1: 1.0}), "DriveTask",
        ("part", {1: 0.1}), {0: 0.7, 1: 0.1},
        ("part", {1: 0.0}), {0: 0.3, 1: 0.0},
        "-jug", "Look",
    ]  # fmt: skip
    drive = next(t for t in tasks if isinstance(t, DriveTask))
    assert all(t.drive is drive for t in tasks if isinstance(t, Approach))
    assert drive.goal is None, "where what is carried is says where the robot is"
    assert isinstance(tasks[0], Switch) and tasks[0].onward is tasks[1]


def test_what_is_turned_alone_or_moved_alone_has_no_parts() -> None:
    model = pouring()
    for target in ({0: 0.3}, {1: 0.3}):
        assert said(carry_tasks(model, PICK, target, place_first=True)) == [target]
    model.acts[PICK] = lambda p, q, c: np.repeat((q - p)[..., :1], 2, axis=-1)  # one motion changes both
    assert said(carry_tasks(model, PICK, {0: 0.3, 1: 0.5}, place_first=True)) == [{0: 0.3, 1: 0.5}]


def test_what_the_robot_presses_is_held_where_it_was_predicted() -> None:
    hold = np.array([2.0, 0.0])
    step = PlanStep((PRESS, RUN, FALL), {("cup", "water"): 0.4}, ("cup", "water", 1, 0.4), hold, ticks=8, variant=2)
    tasks = step_tasks(tap(), step, TAP_START)
    assert said(tasks) == ["+tap", "DriveTask", "-tap", "Look"]
    assert isinstance(tasks[0], Switch) and (tasks[0].first, tasks[0].onward) == (2, None)
    assert isinstance(tasks[1], DriveTask) and tasks[1].goal is hold
    held = {**TAP_START, "robot": np.array([0.2, 1.0])}
    assert said(step_tasks(tap(), step, held))[:2] == ["-cup", "+tap"], "what is held is let go of first"
    following = Carried().taken("cup", held["cup"]).watched(True)
    assert said(step_tasks(tap(), step, TAP_START, following))[:2] == ["-cup", "+tap"], "by either witness"


def test_carrying_and_letting_go() -> None:
    x = ("cup", "x")
    assert said(step_tasks(tap(), PlanStep((TAKE,), {x: 0.5}), TAP_START)) == ["+cup", {0: 0.5}, "-cup", "Look"]
    kept = PlanStep((TAKE,), {x: 0.5}, after={x: 0.9}, release=False)
    assert said(step_tasks(tap(), kept, TAP_START)) == ["+cup", {0: 0.5}, {0: 0.9}, "Look"]
    same = PlanStep((TAKE,), {x: 0.5}, after={x: 0.5})
    assert said(step_tasks(tap(), same, TAP_START)) == ["+cup", {0: 0.5}, "-cup", "Look"]
    assert said(step_tasks(tap(), PlanStep((TAKE,)), TAP_START)) == ["-cup", "Look"]
    assert isinstance(step_tasks(tap(), PlanStep((TAKE,)), TAP_START)[-1], Look)


def test_wanted_values_by_index() -> None:
    values = {("cup", "x"): 0.5, ("cup", "water"): 0.3, ("tank", "water"): 0.1}
    assert indices(tap(), values, TAKE) == {0: 0.5, 1: 0.3}
    assert indices(tap(), values, TAKE, but=("cup", "water", 1, 0.3)) == {0: 0.5}
    assert indices(tap(), values, RUN) == {0: 0.1}


def test_the_way_back_is_where_it_was_taken() -> None:
    model = pouring()
    assert said(way_back(model, STEP, {0: 0.2, 1: 0.0})) == [("part", {1: 0.0}), {0: 0.2, 1: 0.0}, "-jug"]
    assert said(way_back(model, STEP, {})) == ["-jug"]
    assert said(way_back(model, PlanStep((PICK,), {PLACE: 0.8}), {0: 0.2, 1: 0.0})) == [{0: 0.2}, "-jug"]


def executor(model: ToyModel, edge: Interaction, step: PlanStep) -> tuple[Executor, Memory]:
    """In the midst of a step; no further plan is found."""
    model.customary = lambda edge: ("daylight",)  # type: ignore[attr-defined]
    goal = Goal((Condition(step.chain[-1].child, "water", 0.9, 1.0),), (edge,))
    none = NoPlan(goal.conditions[0], 0.0, None, "no more")
    run = Executor(model, Skills({}, {}), lambda *asked: none, goal)  # type: ignore[arg-type]
    memory = run.start(NOW["robot"])
    memory.plan, memory.step, memory.tasks = Plan((step,), 5), 0, []
    return run, memory


@pytest.mark.parametrize(
    ("cause", "back"),
    [
        ("drive", [("part", {1: 0.1}), {0: 0.7, 1: 0.1}]),
        ("reach", [("part", {1: 0.0}), {0: 0.2, 1: 0.0}, "-jug"]),
        ("carry", []),
        ("lost", ["-jug!"]),
    ],
)
def test_what_can_not_be_gone_on_with_is_first_brought_where_it_is_safe(cause: str, back: list[object]) -> None:
    """A jug that did not pour is turned up where it is, before anything else; of one that is lost the hand lets go."""
    run, memory = executor(pouring(), PICK, STEP)
    memory.readings, memory.began = [NOW] * 3, NOW
    if cause != "lost":
        memory.carried = Carried().taken("jug", NOW["jug"])
    run._failed(memory, Failed(PICK, cause, "it did not"))
    assert said(memory.tasks) == [*back, "Look"]
    assert (memory.replans, memory.plan, len(memory.experience.contradictions)) == (1, None, 1)
    assert memory.log[0] == (0, f"{cause}: it did not")


def test_the_last_interaction_of_a_chain_that_drove_nothing_is_not_trusted_again() -> None:
    predicted = {**TAP_START, "cup": np.array([0.2, 0.45])}
    step = PlanStep((PRESS, RUN, FALL), {}, ("cup", "water", 1, 0.45), predicted=predicted, ticks=5)
    run, memory = executor(tap(), TAKE, step)
    memory.began = TAP_START
    run.decide(memory, TAP_START, dict.fromkeys(TAP_START, True))
    assert memory.experience.cautious == (FALL,)
    assert {text for _, text in memory.log} == {
        "deviation: cup.water is 0.05 where 0.45 was predicted after tank->cup",
        "cautious: tank->cup only as it was shown, by daylight",
    }
