"""Which of many predicted drives go on, and what those that never began were waiting for."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from toy_models import tap

from ichain_drake.control.planning.drive_run import Run
from ichain_drake.control.planning.model import conserved
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


def test_no_drive_makes_more_water_than_there_was() -> None:
    """What was gained is cut back by as much as there is too much; what flowed, or was lost, stays as it is."""
    start = {"tank": np.array([[0.8, 0.0]] * 4), "cup": np.array([[0.0, 0.1]] * 4)}
    water = [(0.5, 0.4), (0.5, 0.5), (0.9, 0.3), (0.2, 0.1)]
    after = {
        "tank": np.array([[tank, 0.0] for tank, _ in water]),
        "cup": np.array([[0.0, cup] for _, cup in water]),
    }
    run: Any = SimpleNamespace(amounts=conserved(tap()), start=start)
    Run._conserve(run, after)
    np.testing.assert_allclose(after["cup"][:, 1], [0.4, 0.4, 0.1, 0.1])
    np.testing.assert_allclose(after["tank"][:, 0], [0.5, 0.5, 0.8, 0.2])
    np.testing.assert_array_equal(after["cup"][:, 0], 0.0)
