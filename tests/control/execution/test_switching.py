"""Switching an interaction: when it counts as done, when it is tried again, and when it is given up."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from moved_thing import EDGE
from moved_thing import model as moved_thing
from small_job import fresh, learned, readings
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


APPROACH = np.array([[0.3, y, 0.0] for y in (0.4, 0.3, 0.2, 0.1)] + [[0.3, 0.0, 1.0], [0.3, 0.0, 1.0]])
RETREAT = np.array([[0.3, y, 0.0] for y in (0.0, 0.1, 0.2, 0.3)])
ELSEWHERE = {"dimmer": np.array([0.9, 0.0, 1.0])}


class Shown:
    """Skills with an approach of five rows, the last of which closes, and a retreat that opens first."""

    def __init__(self) -> None:
        self.asked: list[tuple[bool, int]] = []

    def path(self, model, edge, activate, states, attempt, prefer, first):
        self.asked.append((activate, attempt))
        return APPROACH if activate else RETREAT


class Around:
    """A motion that notes what it is asked, goes to one side, and refuses ways that were shown, so many of them."""

    def __init__(self, refused: int = 0) -> None:
        self.asked: list[tuple[np.ndarray, np.ndarray, object, dict[str, np.ndarray], str | None]] = []
        self.refused = refused

    def path(self, query):
        now, goal, shown = query.now, query.goal, query.shown
        self.asked.append((now, goal, shown, dict(query.left), query.touched))
        if shown is not None and len(self.shown) <= self.refused:
            raise UnreachableError("the table is in the way")
        beside = 0.5 * (now + goal) + [0.05, 0.0, 0.0]
        beside[2] = now[2]
        return np.array([beside, goal])

    @property
    def shown(self) -> list[tuple[np.ndarray, np.ndarray, object, dict[str, np.ndarray], str | None]]:
        return [a for a in self.asked if a[2] is not None]


def test_the_approach_is_laid_out_up_to_where_the_hand_closes_around_what_is_there() -> None:
    motion, readings, command = Around(), [], np.array([0.3, 0.6, 0.0])
    task, gone = Switch(DIM, activate=True), []
    for _ in range(12):
        readings.append({**LAMP_START, "robot": command})
        view = View(lamp(), Shown(), readings, command, motion=motion, standing=lambda: ELSEWHERE)  # type: ignore[arg-type]
        answer = task.act(view)
        if not isinstance(answer, np.ndarray):
            break
        gone.append(command := answer)
    assert answer == DONE
    (far, near) = motion.asked
    assert far[2] is None
    np.testing.assert_array_equal(far[1], APPROACH[0])
    np.testing.assert_array_equal(near[2], APPROACH[1:5])
    np.testing.assert_array_equal(near[3]["dimmer"], APPROACH[4], "it lies in the hand as it is taken")
    assert near[4] == "dimmer"
    assert max(row[0] for row in gone) == pytest.approx(0.35), "the way that was laid out"


def test_the_retreat_is_laid_out_from_where_the_hand_has_opened_and_leaves_what_it_held() -> None:
    motion, paths = Around(), Shown()
    options = {"motion": motion, "standing": lambda: ELSEWHERE}
    assert run(Switch(DIM, activate=False), paths, HELD, **options)[0] == DONE  # type: ignore[arg-type]
    ((now, goal, shown, left, touched),) = motion.asked
    np.testing.assert_array_equal(now, RETREAT[0], "open, and where it was")
    np.testing.assert_array_equal(shown, RETREAT[1:])
    np.testing.assert_array_equal(goal, RETREAT[-1])
    assert (left, touched) == (ELSEWHERE, None)


@pytest.mark.parametrize("activate", [True, False])
def test_where_a_shown_way_hits_something_another_event_is_tried_and_at_last_it_is_said(activate: bool) -> None:
    command = np.array([0.3, 0.6, 0.0]) if activate else HELD
    motion, paths = Around(refused=2), Shown()
    assert run(Switch(DIM, activate=activate), paths, command, motion=motion)[0] == DONE
    assert paths.asked == [(activate, 0), (activate, 1), (activate, 2)]
    motion, paths = Around(refused=9), Shown()
    with pytest.raises(UnreachableError, match="the table is in the way"):
        run(Switch(DIM, activate=activate), paths, command, motion=motion, attempts=3)
    assert paths.asked == [(activate, 0), (activate, 1), (activate, 2)]


def test_a_retreat_between_two_attempts_that_hits_something_is_tried_as_another_retreat() -> None:
    motion, paths = Around(refused=1), Shown()
    task = Switch(DIM, activate=True, path=list(RETREAT[1:]), retreating=True)
    run(task, paths, RETREAT[0], ticks=2, motion=motion)
    assert paths.asked == [(False, 1)]


def test_what_it_goes_to_is_looked_for_anew_when_something_was_seen_elsewhere_until_it_is_there() -> None:
    paths, command, readings = Shown(), np.array([0.3, 1.5, 0.0]), []
    task = Switch(DIM, activate=True)
    for tick in range(40):
        readings.append({**LAMP_START, "robot": command})
        moved = 0 if tick < 2 else 1 if task.far else 2  # near, it does as was shown
        view = View(lamp(), paths, readings, command, moved=moved)  # type: ignore[arg-type]
        answer = task.act(view)
        if not isinstance(answer, np.ndarray):
            break
        command = answer
    assert answer == DONE
    assert paths.asked == [(True, 0), (True, 0)]


class NoWay:
    """A motion that finds no way the first few times."""

    def __init__(self, times: int) -> None:
        self.times, self.asked = times, 0

    def path(self, query):
        self.asked += 1
        if self.asked <= self.times:
            raise UnreachableError("there is a wall")
        return np.array([query.goal]) if query.shown is None else query.shown

    def __deepcopy__(self, memo: object) -> NoWay:
        return self


def test_where_the_robot_does_not_get_to_one_event_another_is_tried() -> None:
    paths, wall = Paths(), NoWay(2)
    answer, _ = run(Switch(DIM, activate=True), paths, FREE + [0.5, 0.0, 0.0], motion=wall, attempts=4)
    assert answer == DONE
    assert [n for _, n in paths.asked] == [0, 1, 2]
    with pytest.raises(UnreachableError, match="wall"):
        run(Switch(DIM, activate=True), Paths(), FREE + [0.5, 0.0, 0.0], motion=NoWay(9), attempts=3)


def test_it_travels_until_it_is_where_what_was_shown_begins_and_each_part_is_laid_out_once() -> None:
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
    assert seen[-1][1] == 2, "the approach"
    assert all(asked <= 2 for _, asked in seen)
    letting_go = Switch(DIM, activate=False, forced=True)
    letting_go.act(View(lamp(), paths, [{**LAMP_START, "robot": HELD}], HELD, motion=free))  # type: ignore[arg-type]
    assert free.asked == 2, "it opens where it is"
    assert not letting_go.far


class Near:
    """A motion that gets nowhere beyond a border, and goes straight before it."""

    def path(self, query):
        if query.goal[1] > 0.25:
            raise UnreachableError("the arm ends there")
        return np.array([query.goal]) if query.shown is None else query.shown


def test_an_approach_that_begins_out_of_reach_is_gone_from_where_the_robot_gets_to() -> None:
    paths, command, gone = Shown(), np.array([0.3, 0.2, 0.0]), []
    task, readings = Switch(DIM, activate=True), []
    for _ in range(12):
        readings.append({**LAMP_START, "robot": command})
        answer = task.act(View(lamp(), paths, readings, command, motion=Near()))  # type: ignore[arg-type]
        if not isinstance(answer, np.ndarray):
            break
        gone.append(command := answer)
    assert answer == DONE
    assert paths.asked == [(True, 0)], "by the same event"
    assert max(row[1] for row in gone) == pytest.approx(APPROACH[2, 1])


def test_a_retreat_that_ends_out_of_reach_ends_sooner_once_no_other_leads_away() -> None:
    class Short(Around):
        """Gets no farther along a retreat than to its last state but one."""

        def path(self, query):
            rows = super().path(query)
            if query.shown is not None and (query.goal == RETREAT[-1]).all():
                raise UnreachableError("the arm ends there")
            return rows

    motion, paths = Short(), Shown()
    assert run(Switch(DIM, activate=False), paths, HELD, motion=motion, attempts=3)[0] == DONE
    assert paths.asked == [(False, 0), (False, 1), (False, 2)], "others are tried before"
    np.testing.assert_array_equal(motion.shown[-1][1], RETREAT[-2])


@pytest.mark.parametrize(("slip", "follows", "lower"), [(0.1, "box", True), (0.002, "box", False), (0.1, "", False)])
def test_what_hangs_low_in_the_hand_is_let_go_of_where_a_usual_grasp_would_have_it(
    slip: float, follows: str, *, lower: bool
) -> None:
    model, skills, _ = learned()
    held = np.array([0.2, 0.1, 0.2, 1.0])
    usual = {"box": held - [0.05, 0.0, slip, 0.0]}
    rows = [readings(fresh()) | {"hand": held}]
    view = View(model, skills, rows, held, follows=follows, standing=lambda: usual)
    task = Switch(Interaction("hand", "box"), activate=False, forced=True)
    first = task.act(view)
    assert isinstance(first, np.ndarray)
    assert task.path
    assert (task.path[0] == [*held[:2], held[2] - slip, 1.0]).all() == lower, "lowered, and its hand still closed"
    opened = next(row for row in task.path if row[3] == 0.0)
    assert opened[2] == pytest.approx(held[2] - slip * lower, abs=0.01)
    assert (first[2] < held[2] - 0.01) == lower
