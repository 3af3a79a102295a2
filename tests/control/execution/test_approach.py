"""A drive that is over before what is carried has arrived: a fast pour stops on its way."""

from __future__ import annotations

import numpy as np
import pytest
from toy_models import TAP_START, tap

from ichain_drake.control.execution.carrying import CarryTask
from ichain_drake.control.execution.driving import Approach, DriveTask
from ichain_drake.control.execution.tasks import DONE, View
from ichain_drake.control.planning.plan import PlanStep
from ichain_drake.control.planning.skills import Skills
from ichain_drake.graph import Interaction

MODEL = tap()
HELD = {**TAP_START, "robot": np.array([0.2, 1.0])}
CARRY, POUR = Interaction("robot", "cup"), Interaction("tap", "tank")


def poured(levels: list[float], end: float, until: float) -> list[bool]:
    """Whether an approach is over as the tank's readings come in, and at last whether the drive behind it is."""
    predicted = {**HELD, "cup": np.array([0.9, 0.05]), "tank": np.array([end, 0.0])}
    step = PlanStep((CARRY, POUR), until=("tank", "water", -1, until), predicted=predicted, ticks=5)
    drive = DriveTask(CARRY, step=step)
    approach = Approach(CARRY, carry=CarryTask(CARRY, target={0: 0.9}), drive=drive)
    answers: list[object] = []
    readings = []
    for level in levels:
        readings.append({**HELD, "cup": np.array([0.2, 0.05]), "tank": np.array([level, 0.0])})
        answers.append(approach.act(View(MODEL, Skills({}, {}), readings, HELD["robot"])))
    answers.append(drive.act(View(MODEL, Skills({}, {}), readings, HELD["robot"])))
    return [isinstance(a, str) and a == DONE for a in answers]


def test_it_goes_on_until_the_water_is_there_and_the_drive_is_then_over() -> None:
    answers = poured([0.8, 0.8, 0.65, 0.5, 0.35], 0.35, 0.35)
    assert not any(answers[:3])
    assert answers[4:] == [True, True]


def test_fast_water_is_stopped_a_tick_early() -> None:
    """0.15 more flow while it is stopped."""
    assert poured([0.8, 0.8, 0.65, 0.5], 0.35, 0.35)[3]


@pytest.mark.parametrize("levels", [[0.8] * 5, [0.8, 0.8002, 0.7999, 0.8001, 0.7998]])
def test_noise_stops_nothing(levels: list[float]) -> None:
    answers = poured(levels, 0.35, 0.35)
    assert not any(answers)
