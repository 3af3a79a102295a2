"""Hand commands laid out in straight lines."""

import numpy as np
import pytest

from ichain_drake.errors import InputError
from ichain_drake.scenarios.hand_commands import HandCommands, SeveralHands

NAMES = ("x", "y", "roll", "grip")


def hand() -> HandCommands:
    return HandCommands(NAMES, [0.4, 0.0, 0.0, 0.0])


def test_a_line_has_steps_of_one_length_and_ends_where_it_should() -> None:
    rows = hand().to(x=0.5, y=0.05, step=0.03).commands
    steps = np.diff(np.vstack([[0.4, 0.0, 0.0, 0.0], rows]), axis=0)
    assert len(rows) == 4
    np.testing.assert_allclose(np.linalg.norm(steps[:, :2], axis=1), np.hypot(0.1, 0.05) / 4)
    np.testing.assert_array_equal(rows[-1], [0.5, 0.05, 0.0, 0.0])


def test_a_turn_takes_its_time_too() -> None:
    rows = hand().to(x=0.41, roll=1.0).commands
    np.testing.assert_allclose(rows[:, 2], [0.25, 0.5, 0.75, 1.0])


def test_orders_follow_each_other() -> None:
    laid = hand().by(x=0.02).grip(True).by(y=-0.01).wait(3).grip(False)
    np.testing.assert_allclose(laid.commands[:, 3], [0, 1, 1, 1, 1, 1, 1, 0, 0])
    np.testing.assert_allclose(laid.now, [0.42, -0.01, 0.0, 0.0])
    assert laid.by().commands.shape == (10, 4), "a tick is a tick"


def test_what_the_hand_does_not_have_is_named() -> None:
    for order in (lambda: hand().to(z=0.1), lambda: hand().by(z=0.1)):
        with pytest.raises(InputError, match="the hand has no z; it has x, y, roll, grip"):
            order()
    with pytest.raises(InputError, match="the hand has no grip"):
        HandCommands(("x",), [0.0]).grip(True)
    with pytest.raises(InputError, match="4 values are needed, of x, y, roll, grip"):
        HandCommands(NAMES, [0.4, 0.0])


def test_of_several_hands_each_waits_while_another_one_moves() -> None:
    both = SeveralHands(("x", "grip"), {"one": (0.0, 0.0), "other": (1.0, 0.0)})
    both["one"].to(x=0.08).grip(True)
    both["other"].to(x=1.04)
    both["one"].wait(1)
    rows = both.commands
    assert rows.shape == (6, 4)
    np.testing.assert_allclose(rows[:, 0], [0.04, 0.08, 0.08, 0.08, 0.08, 0.08])
    np.testing.assert_allclose(rows[:, 1], [0.0, 0.0, 1.0, 1.0, 1.0, 1.0])
    np.testing.assert_allclose(rows[:, 2], [1.0, 1.0, 1.0, 1.0, 1.04, 1.04])
    np.testing.assert_array_equal(rows[:, 3], 0.0)


def test_a_start_that_does_not_fit_a_hand_is_refused() -> None:
    with pytest.raises(InputError, match="2 values are needed"):
        SeveralHands(("x", "grip"), {"one": (0.0, 0.0), "other": (1.0,)})
