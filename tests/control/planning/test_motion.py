"""A motion is followed from the demonstrated state that is nearest, and taken up where it drives fastest."""

import numpy as np
import pytest

from ichain_drake.control.planning.motion import Motion
from ichain_drake.control.settings import PLANNING
from ichain_drake.graph import Interaction


def motion(wraps: bool = True) -> Motion:
    """Five states of a wrist and a knob, of which the last two are much alike; a grip tells no states apart."""
    robot = np.array([[0.0, 1.0], [0.5, 1.0], [1.0, 1.0], [-1.0, 0.0], [-0.98, 0.0]])
    child = np.array([[0.0], [0.5], [3.1], [-1.0], [-0.98]])
    return Motion(
        Interaction("robot", "knob"), robot, child, np.arange(5), np.zeros(5, dtype=bool),
        np.array([5.0, 4.0, 3.0, 1.0, 2.0]), (np.array([0.1, np.inf]), np.array([0.2])), np.array([wraps]),
    )  # fmt: skip


def test_an_angle_is_away_the_short_way_round_and_a_length_is_not() -> None:
    place = np.array([[-3.1], [0.1]])
    turned = [[15.5, (2 * np.pi - 3.6) / 0.2, (2 * np.pi - 6.2) / 0.2, 10.5, 10.6], [0.5, 2.0, 15.0, 5.5, 5.4]]
    np.testing.assert_allclose(motion().away(place), turned)
    turned[0][1:3] = 18.0, 31.0
    np.testing.assert_allclose(motion(wraps=False).away(place), turned)


def test_of_states_that_are_about_as_near_that_is_taken_from_which_it_drives_fastest() -> None:
    assert 0.02 / 0.2 < PLANNING.alike < 0.5 / 0.2
    best, reachable = motion().grasp(np.array([[-1.0], [0.24], [0.26], [2.0], [0.8]]))
    assert best.tolist()[0] == 4, "though the other is nearer"
    assert best.tolist()[1:] == [0, 0, 2, 1], "of two that are as near, the one that lies ahead of more"
    assert reachable.tolist() == [True, False, False, False, False]


@pytest.mark.parametrize(("robot", "child", "node"), [(0.45, 0.5, 1), (0.3, 0.5, 1), (1.0, -3.1, 2), (0.2, 0.0, 0)])
def test_where_it_is_followed_both_robot_and_object_are_near(robot: float, child: float, node: int) -> None:
    assert motion().at(np.array([[robot, 0.0]]), np.array([[child]])).tolist() == [node]
