"""What tasks see: means of readings, and what classifiers say of them."""

from __future__ import annotations

import numpy as np
import pytest
from toy_models import LAMP_START, TAP_START, lamp, tap

from ichain_drake.control.execution.course import Course
from ichain_drake.control.execution.tasks import DONE, Look, Mode, View
from ichain_drake.control.planning.skills import Skills
from ichain_drake.graph import Interaction

DIM = Interaction("robot", "dimmer")
COMMAND = np.array([0.5, 0.0, 1.0])


def view(dimmers: list[float], follows: str = "") -> View:
    readings = [{**LAMP_START, "robot": COMMAND + 0.01, "dimmer": np.array([d])} for d in dimmers]
    return View(lamp(), Skills({}, {}), readings, COMMAND, follows=follows)


@pytest.mark.parametrize(("ticks", "mean"), [(1, 0.6), (2, 0.5), (3, 0.4), (9, 0.4)])
def test_readings_are_averaged_and_the_robot_is_where_it_was_sent(ticks: int, mean: float) -> None:
    seen = view([0.2, 0.4, 0.6])
    averaged = seen.averaged(ticks)
    assert averaged["dimmer"] == pytest.approx([mean])
    np.testing.assert_array_equal(averaged["robot"], COMMAND)
    assert averaged["robot"] is not seen.command
    assert seen.averaged()["dimmer"] == pytest.approx([0.4])


def test_the_mean_of_what_is_bounded_is_within_its_bounds() -> None:
    readings = [{**TAP_START, "cup": np.array([0.2, water])} for water in (1.2, 1.0, 1.1)]
    assert View(tap(), Skills({}, {}), readings, TAP_START["robot"]).averaged()["cup"] == pytest.approx([0.2, 1.0])


def test_a_status_is_that_of_the_mean_decision_or_of_what_is_seen_to_follow() -> None:
    """0.03 off the robot's place is the border; the robot's readings are at .51."""
    seen = view([0.0, 0.48, 0.55])
    each = [0.03 - 0.03, 0.03 - 0.04]
    assert seen.decision(DIM) == pytest.approx(np.mean(each))
    assert seen.decision(DIM, 1) == pytest.approx(each[1])
    assert not seen.is_active(DIM) and not seen.holds(DIM)
    assert view([0.0, 0.51, 0.51]).is_active(DIM)
    assert view([0.0, 0.0, 0.0], follows="dimmer").holds(DIM)
    assert not view([0.0, 0.0, 0.0], follows="switch").holds(DIM)
    assert not view([0.0, 0.0, 0.0], follows="lamp").holds(Interaction("dimmer", "lamp")), "not the robot's"


def test_it_travels_in_demonstrated_steps() -> None:
    seen, goal = view([0.5]), np.array([0.75, 0.0, 0.0])
    command, there = seen.towards(goal)
    np.testing.assert_allclose(command, [0.5 + 0.25 / 3, 0.0, 1.0])
    assert not there
    np.testing.assert_array_equal(seen.travel(Course(), goal)[0], command)
    command, there = seen.towards(np.array([0.6, 0.0, 0.0]))
    np.testing.assert_array_equal(command, [0.6, 0.0, 0.0])
    assert there


def test_looking_takes_so_many_ticks() -> None:
    look, seen = Look(None, 2), view([0.5])
    for _ in range(2):
        np.testing.assert_array_equal(look.act(seen), COMMAND)
    assert look.act(seen) == DONE
    assert Look(None).ticks == 3
    assert look.mode == Mode.LOOK


def test_each_mode_is_told_by_a_number_of_its_own() -> None:
    """They are what the port says, and what a recording of it holds."""
    assert [int(Mode[name]) for name in Mode.__members__] == list(range(8))
