"""Ways of the hand around things: laid out, and gone by the arm in its own plant."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

import numpy as np
import pytest
from motion_scene import CUP, door, executed, longest_step, walls
from other_arm import other_arm
from pydrake.math import RigidTransform

from ichain_drake.errors import InputError, UnreachableError
from ichain_drake.motion_query import MotionQuery
from ichain_drake.robot import HandSpec, MotionPlanner, RobotSpec, hand_pose
from ichain_drake.robot.hand_lines import MARGIN

DOWN, FORWARD = 0.0, np.pi / 2
WALL = ((0.5, 0.0, 0.09), (0.02, 0.16, 0.18))
LEFT, RIGHT = np.array([0.42, 0.0, 0.08, DOWN, 1.0]), np.array([0.58, 0.0, 0.08, DOWN, 1.0])
UPRIGHT = RigidTransform([0.0, 0.0, 0.05]) @ hand_pose(np.array([0, 0, 0, 0, DOWN, 0, 0])).inverse()


def test_a_free_way_is_straight(tmp_path: Path) -> None:
    spec = walls(tmp_path)
    start, goal = np.array([0.45, -0.1, 0.2, DOWN, 0.0]), np.array([0.5, 0.1, 0.3, DOWN, 1.0])
    path = MotionPlanner(spec).path(MotionQuery(start, goal))
    np.testing.assert_array_equal(path[-1], goal)
    share = np.arange(1, len(path) + 1)[:, None] / len(path)
    np.testing.assert_allclose(path[:, :4], (start + share * (goal - start))[:, :4], atol=1e-12)
    assert path[:-1, 4].tolist() == [0.0] * (len(path) - 1)
    assert longest_step(spec, start, path)[0] <= 0.04 + 1e-9


def test_the_arm_goes_around_a_wall_and_touches_nothing(tmp_path: Path) -> None:
    spec = walls(tmp_path, wall=WALL)
    path = MotionPlanner(spec).path(MotionQuery(LEFT, RIGHT))
    runner, least = executed(spec, LEFT, path)
    assert least > 0.003
    np.testing.assert_allclose(runner.read("state"), RIGHT, atol=2e-3)
    place, turn = longest_step(spec, LEFT, path)
    assert place <= 0.04 + 1e-9
    assert turn < 1e-9  # what is the same at both ends stays
    straight = LEFT + np.linspace(0.25, 1.0, 4)[:, None] * (RIGHT - LEFT)
    assert executed(spec, LEFT, straight)[1] < 0.0


def test_a_hand_that_turns_in_place_stays_there_however_near_something_is(tmp_path: Path) -> None:
    """As at a knob on a panel: what it holds can't go around anything."""
    spec = walls(tmp_path, panel=((0.66, 0.0, 0.25), (0.02, 0.4, 0.5)))
    spec = replace(spec, hand=HandSpec(["x", "y", "z", "roll", "grip"], held={"yaw": 0.0, "pitch": FORWARD}))
    start = np.array([0.63, 0.0, 0.25, 0.0, 1.0])
    path = MotionPlanner(spec).path(MotionQuery(start, start - [0.0, 0.0, 0.0, 1.6, 0.0]))
    np.testing.assert_allclose(path[:, :3], np.tile(start[:3], (len(path), 1)), atol=1e-12)
    runner, least = executed(spec, start, path)
    assert 0.004 < least < MARGIN
    assert runner.read("state")[3] == pytest.approx(-1.6, abs=0.02)


def test_what_is_held_goes_around_too_and_what_was_put_down_is_in_the_way(tmp_path: Path) -> None:
    spec = walls(tmp_path)
    planner = MotionPlanner(spec, {"cup": CUP}, {"cup": UPRIGHT.inverse()})
    start, goal = np.array([0.40, -0.12, 0.05, DOWN, 1.0]), np.array([0.40, 0.12, 0.05, DOWN, 1.0])
    middle = np.array([0.40, 0.0, 0.05, DOWN, 1.0])
    free = planner.path(MotionQuery(start, goal))
    assert np.ptp(free[:, [0, 2]], axis=0).max() < 1e-9
    around = planner.path(MotionQuery(start, goal, left={"cup": middle}))
    assert np.abs(around[:, [0, 2]] - [0.40, 0.05]).max() > 0.03
    np.testing.assert_array_equal(planner.path(MotionQuery(start, goal)), free)  # it remembers nothing

    spec = walls(tmp_path, sill=((0.40, 0.0, 0.02), (0.3, 0.02, 0.04)))
    bare, carrying = MotionPlanner(spec), MotionPlanner(spec, {"cup": CUP}, {"cup": UPRIGHT.inverse()})
    start, goal = (v + [0, 0, 0.025, 0, 0] for v in (start, goal))  # the hand passes over the sill, the cup does not
    assert np.ptp(bare.path(MotionQuery(start, goal))[:, 2]) < 1e-9
    path = carrying.path(MotionQuery(start, goal, "cup"))
    crossing = np.abs(path[:, 1]) < 0.03
    assert path[crossing, 2].min() > 0.09


def test_a_body_that_slipped_in_the_hand_is_carried_as_it_hangs_there(tmp_path: Path) -> None:
    spec = walls(tmp_path, sill=((0.40, 0.0, 0.02), (0.3, 0.02, 0.04)))
    planner = MotionPlanner(spec, {"cup": CUP}, {"cup": UPRIGHT.inverse()})
    start, goal = np.array([0.40, -0.12, 0.11, DOWN, 1.0]), np.array([0.40, 0.12, 0.11, DOWN, 1.0])
    for slip in (0.0, 0.03, 0.06):
        hangs = start - [0.0, 0.0, slip, 0.0, 0.0]
        path = planner.path(MotionQuery(start, goal, "cup", {"cup": hangs}))
        assert path[np.abs(path[:, 1]) < 0.03, 2].min() - slip > 0.09, "as high above the sill"
    np.testing.assert_array_equal(
        planner.path(MotionQuery(start, goal, "cup")), planner.path(MotionQuery(start, goal, "cup", {"cup": start}))
    )


def test_fingers_open_first_where_they_would_strike_something_at_the_goal(tmp_path: Path) -> None:
    spec = walls(tmp_path)
    planner = MotionPlanner(spec, {"cup": CUP}, {"cup": UPRIGHT.inverse()})
    start, goal = np.array([0.40, -0.12, 0.15, DOWN, 1.0]), np.array([0.40, 0.0, 0.06, DOWN, 0.0])
    assert planner.path(MotionQuery(start, goal))[:, 4].tolist() == [1.0] * 3 + [0.0]  # nothing is there: last
    around = planner.path(MotionQuery(start, goal, left={"cup": goal}))
    assert set(around[:, 4]) == {0.0}
    np.testing.assert_array_equal(around[-1], goal)
    holding = planner.path(MotionQuery(start, goal, "cup"))
    assert set(holding[:-1, 4]) == {1.0}, "what it holds it holds to the end"


def test_pointing_changes_where_the_arm_can_follow() -> None:
    spec = RobotSpec(hand=walls(Path()).hand)
    start, goal = np.array([0.55, 0.1, 0.35, FORWARD, 0.0]), np.array([0.5, 0.2, 0.12, DOWN, 0.0])
    path = MotionPlanner(spec).path(MotionQuery(start, goal))
    runner, _ = executed(spec, start, path)
    np.testing.assert_allclose(runner.read("state"), goal, atol=2e-3)
    assert longest_step(spec, start, path)[1] <= 0.2 + 1e-9


def test_an_arm_with_other_joints_and_no_gripper() -> None:
    spec = other_arm()
    start, goal = np.array([0.3, -0.1, 0.25, 0.0]), np.array([0.33, 0.1, 0.2, 0.4])
    path = MotionPlanner(spec).path(MotionQuery(start, goal))
    np.testing.assert_array_equal(path[-1], goal)
    assert len(path) == 6


def test_where_there_is_no_way_it_says_what_collides(tmp_path: Path) -> None:
    planner = MotionPlanner(walls(tmp_path, block=((0.5, 0.0, 0.15), (0.2, 0.2, 0.3))))
    with pytest.raises(UnreachableError, match=r"can't be at x 0\.500.*gripper\.palm - block\.body.*choose another"):
        planner.path(MotionQuery([0.5, -0.2, 0.3, DOWN, 0.0], [0.5, 0.0, 0.2, DOWN, 0.0]))
    # Between two shelves, with no room for the palm on any way.
    shelf = walls(tmp_path, roof=((0.5, 0.0, 0.3), (1.2, 1.2, 0.02)))
    with pytest.raises(UnreachableError, match=r"no way for the hand to .* - roof\.body are in the way"):
        MotionPlanner(shelf).path(MotionQuery([0.45, 0.0, 0.1, DOWN, 0.0], [0.45, 0.0, 0.5, DOWN, 0.0]))


def test_what_is_out_of_reach_is_refused() -> None:
    spec = RobotSpec(hand=walls(Path()).hand)
    with pytest.raises(UnreachableError, match="the arm can't bring its hand to"):
        MotionPlanner(spec).path(MotionQuery([0.5, 0.0, 0.25, DOWN, 0.0], [0.9, 0.9, 0.0, DOWN, 0.0]))


@pytest.mark.parametrize(
    ("now", "match"), [([0.5, 0.0, 0.2], "hand state"), ([0.5, 0.0, np.nan, 0.0, 0.0], "hand state")]
)
def test_a_hand_state_that_can_not_be_is_refused(now: list[float], match: str) -> None:
    planner = MotionPlanner(RobotSpec(hand=walls(Path()).hand))
    with pytest.raises(InputError, match=match):
        planner.path(MotionQuery(now, [0.5, 0.0, 0.2, 0.0, 0.0]))


def test_a_door_is_as_far_open_as_the_hand_left_it(tmp_path: Path) -> None:
    spec = walls(tmp_path)
    gate = door(tmp_path)  # slides along y, closed across the way from x 0.42 to 0.58
    planner = MotionPlanner(spec, {"gate": gate}, {"gate": RigidTransform([0.0, 0.0, 0.09]).inverse()})
    straight = planner.path(MotionQuery(LEFT, RIGHT, left={"gate": np.array([0.5, 0.35, 0.18, DOWN, 1.0])}))
    assert np.ptp(straight[:, [1, 2]], axis=0).max() < 1e-9
    closed = planner.path(MotionQuery(LEFT, RIGHT))
    assert np.ptp(closed[:, [1, 2]], axis=0).max() > 0.03
    np.testing.assert_array_equal(
        planner.path(MotionQuery(LEFT, RIGHT, left={"gate": np.array([0.5, 0.0, 0.18, DOWN, 1.0])})), closed
    )
    handle = np.array([0.5, 0.0, 0.15, DOWN, 1.0])  # in the hand it gives way
    assert np.ptp(planner.path(MotionQuery(handle, handle + [0, 0.2, 0, 0, 0], "gate"))[:, [0, 2]], axis=0).max() < 1e-9


def test_only_what_can_be_moved_is_held(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="in_hand: there is no body 'mug'"):
        MotionPlanner(RobotSpec(), {"cup": CUP}, {"mug": RigidTransform()})
    fixed = replace(CUP, fixed=True)
    with pytest.raises(InputError, match="in_hand: cup is fixed and has 0 joints"):
        MotionPlanner(RobotSpec(), {"cup": fixed}, {"cup": RigidTransform()})


def test_what_was_shown_is_gone_as_it_was_however_near_it_is_unless_it_hits_something(tmp_path: Path) -> None:
    """Along a wall a few millimetres beside the palm: no way that anybody would lay out, but free."""
    beside = np.array([0.0, 0.06, 0.0, 0.0, 0.0])
    start = np.array([0.42, 0.0, 0.08, DOWN, 0.0]) + beside
    rows = start + np.linspace(0.2, 1.0, 5)[:, None] * np.array([0.16, 0.0, 0.0, 0.0, 0.0])
    for gap, free in ((0.004, True), (-0.004, False)):
        middle = start[1] + 0.055 + gap + 0.01  # half the width of the palm, and of the wall
        planner = MotionPlanner(walls(tmp_path, wall=((0.5, middle, 0.09), (0.04, 0.02, 0.18))))
        shown = planner.path(MotionQuery(start, rows[-1], shown=rows))
        assert np.array_equal(shown, rows) == free
        unseen = planner.path(MotionQuery(start, rows[-1]))
        assert np.ptp(unseen[:, [1, 2]], axis=0).max() > 0.004, "with room to spare"
        np.testing.assert_array_equal(shown[-1], rows[-1])


def test_the_fingers_slide_out_along_what_they_held_a_little_off_their_middle(tmp_path: Path) -> None:
    """Its place in the hand is not known so well: 4 mm of it lie in a finger, and of nothing else more than that."""
    start = np.array([0.5, 0.0, 0.06, DOWN, 0.0])
    rows = start + np.linspace(0.25, 1.0, 4)[:, None] * np.array([0.15, 0.0, 0.0, 0.0, 0.0])
    for further, free in ((0.0, True), (0.01, False)):
        block, bar = ((0.5, 0.063, 0.05), (0.04, 0.03, 0.05)), ((0.575, 0.063 - further, 0.05), (0.03, 0.03, 0.05))
        held = {"block": block, "bar": bar}
        planner = MotionPlanner(walls(tmp_path, **held))
        try:
            out = np.array_equal(planner.path(MotionQuery(start, rows[-1], shown=rows)), rows)
        except UnreachableError:
            out = False
        assert out == free


def test_what_it_leaves_it_does_not_lean_on_in_the_end(tmp_path: Path) -> None:
    """A finger's depth into a block: as far as a button is pressed, but no place to be once it was let go of."""
    planner = MotionPlanner(walls(tmp_path, block=((0.5, 0.0, 0.05), (0.1, 0.1, 0.1))))
    above = np.array([0.5, 0.0, 0.2, DOWN, 1.0])
    depths = {touched: next(z for z in np.arange(0.2, 0.05, -0.002) if _refused(planner, above, z, touched))
              for touched in (None, "button")}  # fmt: skip
    assert depths[None] - depths["button"] == pytest.approx(0.015, abs=0.0041)


def test_on_its_way_to_something_it_pushes_nothing_else_that_stands_free(tmp_path: Path) -> None:
    """Though it may press what it goes to, or lean on what is fixed, as deep as a button goes in."""
    spec = walls(tmp_path)
    planner = MotionPlanner(spec, {"cup": CUP}, {"cup": UPRIGHT.inverse()})
    start = np.array([0.5, 0.0, 0.3, DOWN, 1.0])
    on_top = next(z for z in np.arange(0.2, 0.05, -0.001) if _cup_under(planner, start, z, "mug"))
    pressed = next(z for z in np.arange(0.2, 0.05, -0.001) if _cup_under(planner, start, z, "cup"))
    assert on_top - pressed == pytest.approx(0.015, abs=0.003)


def _cup_under(planner: MotionPlanner, start: np.ndarray, z: float, touched: str) -> bool:
    return _refused(planner, start, z, touched, {"cup": np.array([0.5, 0.0, 0.05, DOWN, 1.0])})


def _refused(
    planner: MotionPlanner,
    start: np.ndarray,
    z: float,
    touched: str | None,
    left: Mapping[str, np.ndarray] = MappingProxyType({}),
) -> bool:
    goal = start.copy()
    goal[2] = z
    shown = np.linspace(start, goal, 6)[1:]
    try:
        planner.path(MotionQuery(start, goal, left=left, shown=shown, touched=touched))
    except UnreachableError:
        return True
    return False
