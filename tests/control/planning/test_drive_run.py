"""Which of many predicted drives go on, and what those that never began were waiting for."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ichain_drake.control.planning.drive_run import Run
from ichain_drake.control.planning.motion_run import MotionRun
from ichain_drake.graph import Interaction

PRESS, FLOW = Interaction("robot", "tap"), Interaction("tap", "tank")
BEGIN = 4


def asked(**more: Any) -> Any:
    """Three drives after three steps and the next: the last of them ended before."""
    return SimpleNamespace(n=3, lost=[None] * 3, last=np.array([BEGIN, BEGIN, 1]), **more)


@pytest.mark.parametrize(("step", "noted"), [(BEGIN - 2, False), (BEGIN - 1, True), (BEGIN, False)])
def test_a_drive_whose_chain_is_not_active_ends_and_the_first_that_is_missing_is_noted_where_it_begins(
    step: int, noted: bool
) -> None:
    run = asked(drives=[SimpleNamespace(chain=(PRESS, FLOW))] * 3)
    status = {PRESS: np.array([True, True, False]), FLOW: np.array([True, False, False])}
    assert Run.check(run, status, step, BEGIN).tolist() == [True, False, False]
    assert run.lost == [None, FLOW if noted else None, None], "one that drove before has not lost what it drove by"


@pytest.mark.parametrize(("step", "noted"), [(BEGIN - 2, False), (BEGIN - 1, True), (BEGIN, False)])
def test_a_motion_ends_where_its_object_is_lost_but_while_it_is_taken_anew(step: int, noted: bool) -> None:
    run = asked(motions=[SimpleNamespace(edge=PRESS)] * 3, away=np.array([True, False, False]))
    assert MotionRun.check(run, {PRESS: np.zeros(3, dtype=bool)}, step, BEGIN).tolist() == [True, False, False]
    assert run.lost == [None, PRESS if noted else None, None]
    run = asked(motions=[SimpleNamespace(edge=PRESS)] * 3, away=np.zeros(3, dtype=bool))
    run.lost[1] = PRESS  # it was out of reach from the first
    assert MotionRun.check(run, {PRESS: np.ones(3, dtype=bool)}, step, BEGIN).tolist() == [True, False, True]


def test_the_robot_is_where_it_holds_after_its_ramp() -> None:
    run: Any = SimpleNamespace(ramp=np.array([0, 1, 2, 4]), first=np.zeros((4, 1)), hold=np.ones((4, 1)))
    np.testing.assert_allclose(Run.robot(run, 0)[:, 0], [1.0, 1.0, 0.5, 0.25])
    np.testing.assert_allclose(Run.robot(run, 3)[:, 0], 1.0)
