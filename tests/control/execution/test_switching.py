"""Switching an interaction: when it counts as done, when it is tried again, and when it is given up."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from moved_thing import EDGE
from moved_thing import model as moved_thing
from toy_models import LAMP_START, lamp

from ichain_drake.control.execution.switching import Switch
from ichain_drake.control.execution.tasks import DONE, Answer, Failed, Mode, Task, View
from ichain_drake.errors import UnreachableError
from ichain_drake.graph import Interaction
from ichain_drake.learning.settings import LEARNING

DIM = Interaction("robot", "dimmer")
HELD, FREE = np.array([0.3, 0.0, 1.0]), np.array([0.3, 0.0, 0.0])


class Paths:
    """Skills that note what was asked of them; their path is a state beside the dimmer, and there the new grip."""

    def __init__(self, grips: bool = True) -> None:
        self.asked: list[tuple[bool, int]] = []
        self.grips = grips

    def path(self, model, edge, activate, states, attempt, prefer, first):
        self.asked.append((activate, attempt))
        grip = float(activate == self.grips)
        return np.array([[0.3, 0.0, 1.0 - grip], [0.3, 0.0, grip]])


def run(task: Switch, paths: Paths, command: np.ndarray, ticks: int = 40, **options: object) -> tuple[object, int]:
    """The last answer and the number of ticks, in a world that does as it is told."""
    readings: list[dict[str, np.ndarray]] = []
    for tick in range(ticks):
        readings.append({**LAMP_START, "robot": command})
        answer = task.act(View(lamp(), paths, readings, command, **options))  # type: ignore[arg-type]
        if not isinstance(answer, np.ndarray):
            return answer, tick
        command = answer
    return "no end", ticks


@pytest.mark.parametrize(("activate", "command"), [(True, HELD), (False, FREE)])
def test_what_is_so_already_takes_no_time_unless_forced(activate: bool, command: np.ndarray) -> None:
    paths = Paths()
    assert run(Switch(DIM, activate=activate), paths, command) == (DONE, 0)
    assert paths.asked == []
    answer, ticks = run(Switch(DIM, activate=activate, forced=True), paths, command)
    assert (answer, paths.asked) == (DONE, [(activate, 0)])
    assert ticks > 2


@pytest.mark.parametrize(("activate", "command"), [(True, FREE), (False, HELD)])
def test_it_goes_the_skills_path_and_waits_before_it_looks(activate: bool, command: np.ndarray) -> None:
    task, paths = Switch(DIM, activate=activate), Paths()
    assert task.mode == (Mode.ACTIVATE if activate else Mode.DEACTIVATE)
    assert run(task, paths, command) == (DONE, 3)
    assert (paths.asked, task.attempt) == ([(activate, 0)], 0)


@pytest.mark.parametrize("attempts", [1, 2, 4])
@pytest.mark.parametrize(("activate", "command"), [(True, FREE), (False, HELD)])
def test_after_so_many_attempts_it_failed(activate: bool, command: np.ndarray, attempts: int) -> None:
    """Between two attempts to activate the robot lets go; each asks for another event."""
    paths = Paths(grips=False)
    answer, _ = run(Switch(DIM, activate=activate), paths, command, 80, attempts=attempts)
    assert isinstance(answer, Failed)
    assert answer.cause == ("activation" if activate else "deactivation")
    word = "active" if activate else "inactive"
    assert f"robot->dimmer did not become {word} in {attempts} attempts; decision value " in answer.text
    assert [n for on, n in paths.asked if on == activate] == list(range(attempts))
    assert [n for on, n in paths.asked if on != activate] == (list(range(1, attempts)) if activate else [])


@pytest.mark.parametrize("forced", [False, True])
def test_unwatched_it_is_done_once_whatever_came_of_it(forced: bool) -> None:
    paths = Paths(grips=False)
    answer, _ = run(Switch(DIM, activate=False, forced=forced), paths, HELD, monitors=False)
    assert (answer, paths.asked) == (DONE, [(False, 0)])


def test_watched_and_forced_it_has_to_be_so_in_the_end() -> None:
    paths = Paths(grips=False)
    answer, _ = run(Switch(DIM, activate=False, forced=True), paths, HELD, 80, attempts=3)
    assert isinstance(answer, Failed)
    assert len(paths.asked) == 3


def test_a_skill_without_a_way_is_over_when_it_is_so() -> None:
    here = SimpleNamespace(path=lambda *asked: np.zeros((0, 3)))
    for command, done in ((FREE, True), (HELD, False)):
        for monitors in (True, False):
            view = View(lamp(), here, [{**LAMP_START, "robot": command}] * 2, command, monitors)  # type: ignore[arg-type]
            answer = Switch(DIM, activate=False, forced=True).act(view)
            assert (isinstance(answer, str) and answer == DONE) == (done or not monitors)


class Onward(Task):
    """What the plan goes on with: sends the robot somewhere, or finds no way."""

    def __init__(self, command: np.ndarray | None) -> None:
        super().__init__(EDGE)
        self.command = command

    def act(self, view: View) -> Answer:
        if self.command is None:
            raise UnreachableError("no way")
        return self.command


def tried(robot: list[float], thing: list[float], onward: Onward, calls: int = 1) -> tuple[list[object], Switch]:
    """What comes of going on with the plan for a while, after a robot and a thing went so."""
    rows = [{"robot": np.array([a, 1.0]), "thing": np.array([b, 0.5])} for a, b in zip(robot, thing, strict=True)]
    task = Switch(EDGE, activate=True, onward=onward, since=len(rows))
    view = View(moved_thing(), Paths(), rows, rows[-1]["robot"])  # type: ignore[arg-type]
    return [task._try(view) for _ in range(calls)], task


def test_whether_a_thing_comes_along_is_tried_for_some_ticks_with_what_the_plan_goes_on_with() -> None:
    far, way, still = np.array([0.9, 1.0]), [0.0, 0.0, 0.03, 0.06, 0.09], [0.0] * 5
    (seen,), task = tried(way, way, Onward(far))
    assert (seen, task.followed) == (DONE, True)
    (stays,), task = tried(way, [0.3] * 5, Onward(far))
    assert (stays, task.followed) == (None, False)
    answers, task = tried(still, still, Onward(far), LEARNING.look + 1)
    assert all(np.array_equal(a, far) for a in answers[:-1])
    assert (answers[-1], task.followed) == (None, False), "no longer than that"
    assert tried(still, still, Onward(None))[0] == [None]


class NoWay:
    """A motion that finds no way the first few times."""

    def __init__(self, times: int) -> None:
        self.times, self.asked = times, 0

    def path(self, now: np.ndarray, goal: np.ndarray, held: str | None = None, left: object = None) -> np.ndarray:
        self.asked += 1
        if self.asked <= self.times:
            raise UnreachableError("there is a wall")
        return np.array([goal])

    def __deepcopy__(self, memo: object) -> NoWay:
        return self


def test_where_the_robot_does_not_get_to_one_event_another_is_tried() -> None:
    paths, wall = Paths(), NoWay(2)
    answer, _ = run(Switch(DIM, activate=True), paths, FREE + [0.5, 0.0, 0.0], motion=wall, attempts=4)
    assert answer == DONE
    assert [n for _, n in paths.asked] == [0, 1, 2]
    with pytest.raises(UnreachableError, match="wall"):
        run(Switch(DIM, activate=True), Paths(), FREE + [0.5, 0.0, 0.0], motion=NoWay(9), attempts=3)


def test_only_the_way_to_where_it_begins_is_laid_out_and_what_was_shown_is_gone_as_it_was() -> None:
    task, paths, free = Switch(DIM, activate=True), Paths(), NoWay(0)
    assert not task.travels
    command = FREE + [0.5, 0.0, 0.0]
    seen = []
    for _ in range(6):
        answer = task.act(View(lamp(), paths, [{**LAMP_START, "robot": command}], command, motion=free))  # type: ignore[arg-type]
        seen.append((task.travels, free.asked))
        if not isinstance(answer, np.ndarray):
            break
        command = answer
    assert seen[0] == (False, 1), "in one step it is there"
    assert all(asked == 1 for _, asked in seen)
    letting_go = Switch(DIM, activate=False, forced=True)
    letting_go.act(View(lamp(), paths, [{**LAMP_START, "robot": HELD}], HELD, motion=free))  # type: ignore[arg-type]
    assert free.asked == 1, "where it is it is"
    assert not letting_go.far
