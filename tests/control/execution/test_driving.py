"""Driving a variable: where the robot goes first, when it is over, and what tells that nothing is driven."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from toy_models import TAP_START, ToyModel, tap

from ichain_drake.control.execution.driving import DriveTask
from ichain_drake.control.execution.tasks import DONE, Answer, Failed, View
from ichain_drake.control.planning.plan import PlanStep
from ichain_drake.control.planning.skills import Skills
from ichain_drake.control.settings import EXECUTION, PLANNING
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.settings import LEARNING
from ichain_drake.rules import without
from ichain_drake.state import Role, StateSpace, Variable

SKILLS = Skills({}, {})
CHAIN = tuple(Interaction.parse(e) for e in ("robot->tap", "tap->tank", "tank->cup"))
PRESSED = {**TAP_START, "robot": np.array([2.0, 0.0]), "tap": np.ones(1), "cup": np.array([1.0, 0.1])}


def fill(until: float = 0.5) -> PlanStep:
    predicted = {**PRESSED, "cup": np.array([1.0, until]), "tank": np.array([0.9 - until, 0.0])}
    return PlanStep(CHAIN, until=("cup", "water", 1, until), predicted=predicted, ticks=10)


def drive(task: DriveTask, waters: Sequence[float], off: int | None = None, **options: object) -> tuple[Answer, int]:
    """Answers to readings of the cup's water, while the robot stays; `off` is a link of the chain that is inactive."""
    model, readings = tap(), []
    if off is not None:
        model.gates[CHAIN[off]] = lambda s: np.full(len(s["robot"]), -1.0)
    for tick, water in enumerate(waters):
        readings.append({**PRESSED, "cup": np.array([1.0, water])})
        answer = task.act(View(model, SKILLS, readings, PRESSED["robot"], **options))  # type: ignore[arg-type]
        if not isinstance(answer, np.ndarray):
            return answer, tick
        np.testing.assert_array_equal(answer, PRESSED["robot"])
    return "no end", len(waters)


def test_it_goes_where_the_drive_was_predicted_first() -> None:
    task, model, now = DriveTask(CHAIN[0], step=fill(), goal=np.array([2.25, 0.0])), tap(), PRESSED["robot"]
    way = []
    for _ in range(5):
        now = task.act(View(model, SKILLS, [PRESSED], now))
        way.append(now[0])
    np.testing.assert_allclose(way, [2.0 + 0.25 / 3, 2.0 + 0.5 / 3, 2.25, 2.25, 2.25])
    assert task.arrived
    assert len(task.history) == 2, "what counts begins there"


def test_it_ends_a_tick_before_the_water_would_be_there() -> None:
    """0.04 a tick: what is decided now begins to act in one."""
    answer, tick = drive(DriveTask(CHAIN[0], step=fill()), 0.1 + 0.04 * np.arange(30))
    assert (answer, tick) == (DONE, 9)
    assert drive(DriveTask(CHAIN[0], step=fill(0.3)), 0.1 + 0.04 * np.arange(30))[1] == 5


@pytest.mark.parametrize("link", [0, 1, 2])
def test_a_link_that_is_inactive_fails_it(link: int) -> None:
    answer, tick = drive(DriveTask(CHAIN[0], step=fill()), [0.1] * 30, off=link)
    assert isinstance(answer, Failed)
    assert answer.edge == CHAIN[link]
    if link == 0:
        assert (answer.cause, tick) == ("lost", 4)
        assert answer.text == "robot->tap became inactive while it drove cup.water"
    else:
        assert (answer.cause, tick) == ("chain", 5)
        assert answer.text == f"{CHAIN[link].name} is not active, so that cup.water is not driven"
    unwatched, _ = drive(DriveTask(CHAIN[0], step=fill()), [0.1] * 80, off=link, monitors=False)
    assert unwatched == DONE


def test_where_the_water_rises_the_chain_is_at_work_whatever_its_status_says() -> None:
    answer, tick = drive(DriveTask(CHAIN[0], step=fill()), 0.1 + 0.04 * np.arange(30), off=2)
    assert (answer, tick) == (DONE, 9)
    falls, _ = drive(DriveTask(CHAIN[0], step=fill()), 0.1 - 0.004 * np.arange(30), off=2)
    assert isinstance(falls, Failed), "the wrong way is no way"


def test_what_has_stopped_is_over() -> None:
    """Water that rises to .3 and stays: the tap has run dry, though .5 was predicted."""
    waters = np.minimum(0.1 + 0.04 * np.arange(60), 0.3)
    answer, tick = drive(DriveTask(CHAIN[0], step=fill()), waters)
    assert (answer, tick) == (DONE, 13)


@pytest.mark.parametrize(("direction", "value"), [(1, 0.5), (-1, -0.3)])
def test_either_way(direction: int, value: float) -> None:
    step = fill()
    step = replace(step, until=("cup", "water", direction, value))
    answer, tick = drive(DriveTask(CHAIN[0], step=step), 0.1 + direction * 0.04 * np.arange(30))
    assert (answer, tick) == (DONE, 9)


def test_what_does_not_come_there_in_time_is_said() -> None:
    """A third of the speed that was predicted: it has not stopped, but twice the time and more is over."""
    step = replace(fill(), ticks=40)
    answer, tick = drive(DriveTask(CHAIN[0], step=step), 0.1 + 0.0032 * np.arange(140))
    assert isinstance(answer, Failed)
    assert (answer.cause, answer.edge, tick) == ("drive", CHAIN[-1], 120)
    assert answer.text == "cup.water is at 0.482, not yet at 0.5"
    assert drive(DriveTask(CHAIN[0], step=step), 0.1 + 0.0032 * np.arange(140), monitors=False) == (DONE, 120)


def jug() -> tuple[ToyModel, PlanStep, dict[str, np.ndarray]]:
    """A jug over a stove that is warmed the more the higher it is held beside it; learned with the stove at 0."""
    x = Variable("x", "m", role=Role("position", "base", "x"))
    heat = Variable("heat", lower=0.0, upper=1.0)
    spaces = {
        "robot": StateSpace("robot", (x,)),
        "jug": StateSpace("jug", (x,)),
        "stove": StateSpace("stove", (x, heat)),
    }
    take, warm = Interaction("robot", "jug"), Interaction("jug", "stove")
    rows = [{"robot": [v], "jug": [v], "stove": [0.0, 0.2]} for v in (0.0, 0.1, 0.2, 0.3)]
    model = ToyModel(
        InteractionGraph(spaces, [take.name, warm.name]),
        {e.name: lambda s: np.ones(len(s["jug"])) for e in (take, warm)},
        {
            take.name: lambda p, q, c: q - p,
            warm.name: lambda p, q, c: np.concatenate([0 * q, 0.01 + 0 * q], axis=-1),
        },
        {"jug": ["hold"], "stove": ["hold", "hold"]},
        {take.name: rows, warm.name: rows},
        {},
    )
    model.high["stove"][1] = 1.0
    model.edges[warm].relative = True
    now = {"robot": np.array([0.6]), "jug": np.array([0.6]), "stove": np.array([0.5, 0.2])}
    position = ("jug", "x")
    predicted = {**now, "stove": np.array([0.5, 0.8])}
    step = PlanStep((take, warm), {position: 0.6}, ("stove", "heat", 1, 0.8), before={position: 0.5}, ticks=5)
    return model, SimpleNamespace(**{**vars(step), "predicted": predicted}), now  # type: ignore[return-value]


def test_where_the_first_thing_does_not_follow_it_is_pressed_as_far_as_anybody_did_once() -> None:
    """A stiff stove: the jug over it is inactive until the robot is further than it was sent."""
    model, step, now = jug()
    take, warm = step.chain
    model.gates[warm] = lambda s: np.where(s["jug"][..., 0] > 9.0, 1.0, -1.0)
    model.gates[take] = lambda s: np.ones(len(s["jug"]))
    shown = {n: np.array([[v] if n != "stove" else [0.0, 0.2 + v] for v in (0.0, 0.1, 0.3)]) for n in now}
    model.edges[warm].examples.active = shown
    model.edges[take].relative = False
    task = DriveTask(take, step=step, goal=np.array([0.6]), arrived=True)
    readings: list[dict[str, np.ndarray]] = []
    answers = []
    robot = np.array([0.6])
    for _ in range(40):
        readings.append({**now, "robot": robot})
        answers.append(task.act(View(model, SKILLS, readings, robot)))
        if isinstance(answers[-1], Failed):
            break
        robot = np.asarray(answers[-1])
    assert task.pushed
    assert isinstance(answers[-1], Failed), "once, and no more"
    assert answers[-1].edge == warm
    kept = [k for k, a in enumerate(answers) if isinstance(a, np.ndarray)]
    assert len(kept) > 6, "it did not give up at the first"


@pytest.mark.parametrize(("lacks", "further"), [("", True), ("active", False), ("effect", False)])
def test_only_where_somebody_did_it_and_it_does_something_it_is_pressed_further(lacks: str, further: bool) -> None:
    model, step, now = jug()
    take, warm = step.chain
    model.gates[warm] = lambda s: np.full(len(s["jug"]), -1.0)
    if lacks == "active":
        model.gates[take] = lambda s: np.full(np.shape(s["jug"])[:-1], -1.0)
    if lacks == "effect":
        model.edges[take].effects = []
    task = DriveTask(take, step=step, goal=np.array([0.6]), arrived=True)
    readings = [now] * 3
    assert task._further(View(model, SKILLS, readings, now["robot"])) == further
    assert task.pushed == further
    assert not task._further(View(model, SKILLS, readings, now["robot"])), "and once at most"


@pytest.mark.parametrize(("stands", "most"), [(-0.5, 0.3), (0.6, 0.0)])
def test_it_is_pressed_on_in_the_direction_in_which_it_has_to_go(stands: float, most: float) -> None:
    """What stands before all that was shown goes to its far end, and what stands behind to the near one."""
    model, step, now = jug()
    take, warm = step.chain
    model.edges[take].relative = False
    model.edges[warm].examples.active = {
        n: np.array([[v] if n != "stove" else [0.0, 0.2] for v in (0.0, 0.1, 0.3)]) for n in now
    }
    task = DriveTask(take, step=step, goal=np.array([stands]), arrived=True)
    assert task._further(View(model, SKILLS, [{**now, "jug": np.array([stands])}] * 3, np.array([stands])))
    np.testing.assert_allclose(task.goal, [most])


def over_on_the_way(waters: Sequence[float]) -> list[bool]:
    """After each reading, of water that should come to .5 from .1."""
    task, model, readings, out = DriveTask(CHAIN[0], step=fill()), tap(), [], []
    for water in waters:
        readings.append({**PRESSED, "cup": np.array([1.0, water])})
        out.append(task.over_on_the_way(View(model, SKILLS, readings, PRESSED["robot"])))
    return out


def test_on_the_way_it_is_over_a_tick_before_what_flows_fast_would_be_there() -> None:
    assert over_on_the_way([0.1, 0.1, 0.2, 0.3, 0.4]) == [False, False, False, False, True]
    assert over_on_the_way([0.1, 0.1, 0.2, 0.3, 0.3]) == [False] * 5
    model = tap()
    width, noise = (model.high["cup"] - model.low["cup"])[1], model.noise["cup"][1]
    there = 0.5 - max(EXECUTION.slack_noises * noise, EXECUTION.slack * width)
    # What changes within noise does not flow: the mean of two readings has to be there.
    assert not over_on_the_way([0.1, 0.3, there - 1.5 * noise, there + noise])[-1]
    assert over_on_the_way([0.1, 0.3, there - 0.5 * noise, there + noise])[-1]


def test_what_does_not_move_at_all_has_stopped_when_that_would_be_seen() -> None:
    """The predicted rate is .04 a tick; windows are as long as the rule that looks for what is inactive."""
    task = DriveTask(CHAIN[0], step=fill())
    values, w = np.full(80, 0.3), PLANNING.probe
    assert not task._stalled(values[: 2 * w + 1], 1e-4, 1.0, 0.4)
    assert task._stalled(values[: 2 * w + 2], 1e-4, 1.0, 0.4)
    rises = 0.1 + 0.04 * np.arange(80)
    assert not task._stalled(rises, 1e-4, 1.0, 0.4)
    assert task._stalled(rises, 1e-4, -1.0, 0.4), "the wrong way"
    assert task._stalled(0.1 + 0.2 * LEARNING.slight * 0.04 * np.arange(80), 1e-4, 1.0, 0.4)
    assert not task._stalled(0.1 + 1.2 * LEARNING.slight * 0.04 * np.arange(80), 1e-4, 1.0, 0.4)
    loud = 0.04 * 40.0  # noise in which windows have to be longer
    assert not task._stalled(values[: 2 * w + 2], loud, 1.0, 0.4)


def test_how_fast_it_goes_is_told_by_two_means_that_do_not_share_a_reading() -> None:
    """After four readings there is no second mean yet: .26 would be reached in a tick, but nothing tells how fast."""
    assert drive(DriveTask(CHAIN[0], step=fill(0.26)), 0.1 + 0.05 * np.arange(30)) == (DONE, 5)


def test_with_a_rule_switched_off_it_is_as_without_it() -> None:
    model, step, now = jug()
    task = DriveTask(step.chain[0], step=step, goal=np.array([0.6]), arrived=True)
    view = View(model, SKILLS, [now] * 3, now["robot"])
    with without(["push_further", "over_on_the_way", "stalled"]):
        assert not task._further(view)
        assert not task._stalled(np.full(80, 0.3), 1e-4, 1.0, 0.4)
        assert over_on_the_way([0.1, 0.5, 0.6, 0.6]) == [False] * 4
        assert not task.pushed
    assert over_on_the_way([0.1, 0.5, 0.6, 0.6])[-1]
