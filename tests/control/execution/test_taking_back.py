"""On the way back with what seems lost: it is let go of only when it clearly stays behind."""

from __future__ import annotations

import numpy as np
from moved_thing import EDGE, model

from ichain_drake.control.execution.taking_back import TakeBack
from ichain_drake.control.execution.tasks import DONE, Answer, Task, View
from ichain_drake.control.planning.skills import Skills
from ichain_drake.errors import UnreachableError

GOAL = np.array([0.5, 1.0])


class Step(Task):
    """Answers one thing, and keeps how often it was asked and whether it was watched."""

    def __init__(self, *answers: Answer | Exception) -> None:
        super().__init__(EDGE)
        self.answers, self.watched = list(answers), set[bool]()

    def act(self, view: View) -> Answer:
        self.watched.add(view.monitors)
        answer = self.answers.pop(0) if len(self.answers) > 1 else self.answers[0]
        if isinstance(answer, Exception):
            raise answer
        return answer


def ticks(task: TakeBack, robot: list[float], thing: list[float]) -> list[Answer]:
    """Answers along the way of a robot and of what it should carry; the first two rows are from before."""
    rows = [{"robot": np.array([a, 1.0]), "thing": np.array([b, 0.5])} for a, b in zip(robot, thing, strict=True)]
    return [task.act(View(model(), Skills({}, {}), rows[: k + 1], GOAL)) for k in range(1, len(rows))]


WAY = [0.0, 0.0, *(0.03 * np.arange(1, 9))]


def test_what_stays_behind_is_given_up_as_soon_as_that_is_clear_and_not_by_what_was_before() -> None:
    step = Step(GOAL)
    answers = ticks(TakeBack(EDGE, steps=[step]), WAY, [0.3] * len(WAY))
    assert answers[-1] == DONE
    assert isinstance(answers[0], np.ndarray), "the robot has not gone anywhere yet"
    late = ticks(TakeBack(EDGE, steps=[Step(GOAL)]), [*WAY, *WAY[-1:] * 3], [0.3] * (len(WAY) + 3))
    assert [isinstance(a, np.ndarray) for a in late[:2]] == [True, True]
    assert step.watched == {False}


def test_what_comes_along_is_taken_back_step_by_step() -> None:
    task = TakeBack(EDGE, steps=[Step(GOAL, GOAL, DONE), Step(GOAL, GOAL, DONE)])
    answers = ticks(task, WAY, list(WAY))
    assert [isinstance(a, np.ndarray) for a in answers[:5]] == [True, True, True, True, False]
    assert answers[4] == DONE
    assert task.followed


def test_where_it_can_not_go_on_it_is_over() -> None:
    for step in (Step(UnreachableError("no way")), Step("again")):
        task = TakeBack(EDGE, steps=[step, Step(GOAL)])
        assert ticks(task, WAY[:2], WAY[:2]) == [DONE]
