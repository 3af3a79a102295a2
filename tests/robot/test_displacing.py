"""A body that somebody else displaces while the hand is away: how far it comes, and when nobody touches it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from motion_scene import CUP, walls
from pydrake.common.schema import Transform
from pydrake.systems.analysis import Simulator

from ichain_drake.errors import InputError
from ichain_drake.robot import ArmRobot, BodySpec, Displacement, build_robot
from ichain_drake.timing import FRAME

HAND = np.array([0.5, 0.0, 0.3, 0.0, 0.0])
AT = Transform(translation=[0.5, 0.2, 0.0])
BODY = BodySpec(CUP.file, AT, fixed=False)
FLOOR = ((0.5, 0.0, -0.01), (1.0, 1.0, 0.02))


def displaced(robot: ArmRobot, seconds: float = 4.0) -> np.ndarray:
    """[q; v] of the cup at each frame under a hand that stays."""
    simulator = Simulator(robot)
    context = simulator.get_mutable_context()
    robot.GetInputPort("hand_command").FixValue(context, HAND)
    port, rows = robot.GetOutputPort("cup_body"), []
    simulator.Initialize()
    for frame in range(round(seconds / FRAME)):
        rows.append(port.Eval(context).copy())
        simulator.AdvanceTo((frame + 1) * FRAME)
    return np.array(rows)


def arm(folder: Path, *moves: Displacement, body: BodySpec = BODY, **boxes: object) -> ArmRobot:
    spec = walls(folder, floor=FLOOR, **boxes)  # type: ignore[arg-type]
    robot = build_robot(spec, "contact", {"cup": body}, displacements={"cup": moves})
    assert isinstance(robot, ArmRobot)
    return robot


def test_it_comes_as_far_as_it_should_upright_and_stands_there(tmp_path: Path) -> None:
    rows = displaced(arm(tmp_path, Displacement(0.5, -0.08, 0.05)))
    assert np.ptp(rows[:15, 4:7], axis=0).max() < 1e-4, "not before it is due"
    np.testing.assert_allclose(rows[-1, 4:7] - rows[0, 4:7], [-0.08, 0.05, 0.0], atol=1e-3)
    np.testing.assert_allclose(rows[-1, :4], rows[0, :4], atol=1e-3)
    assert np.abs(rows[-10:, 7:]).max() < 1e-3, "nothing holds or pushes it any more"
    assert 0.02 < rows[:, 6].max() < 0.04


def test_from_a_step_it_is_set_down_beside_it_and_one_displacement_follows_the_other(tmp_path: Path) -> None:
    high = BodySpec(CUP.file, Transform(translation=[0.5, 0.2, 0.021]), fixed=False)
    step = ((0.5, 0.2, 0.01), (0.09, 0.09, 0.02))
    moves = Displacement(2.5, 0.0, -0.03), Displacement(0.2, -0.12, 0.0)
    rows = displaced(arm(tmp_path, *moves, body=high, step=step), 5.0)
    np.testing.assert_allclose(rows[60, 4:7], [0.38, 0.2, 0.0], atol=1.5e-3)
    np.testing.assert_allclose(rows[-1, 4:7], [0.38, 0.17, 0.0], atol=1.5e-3)
    np.testing.assert_allclose(np.abs(rows[-1, :4]), [1.0, 0.0, 0.0, 0.0], atol=2e-3)


def test_not_while_the_hand_is_near_nor_where_nobody_gets_at_it(tmp_path: Path) -> None:
    near = displaced(arm(tmp_path, Displacement(0.2, -0.08, 0.0, away=0.6)), 1.5)
    assert np.ptp(near[:, 4:7], axis=0).max() < 1e-3
    spared = Displacement(0.2, -0.08, 0.0, spared=lambda place: bool(place[1] > 0.1))
    assert np.ptp(displaced(arm(tmp_path, spared), 1.5)[:, 4:7], axis=0).max() < 1e-3


def test_where_nobody_would_get_at_it_any_more_it_goes_to_the_other_side_or_stays(tmp_path: Path) -> None:
    left = Displacement(0.2, -0.08, 0.05, spared=lambda place: bool(place[1] > 0.22))
    rows = displaced(arm(tmp_path, left))
    np.testing.assert_allclose(rows[-1, 4:7] - rows[0, 4:7], [-0.08, -0.05, 0.0], atol=1e-3)
    nowhere = Displacement(0.2, -0.08, 0.05, spared=lambda place: abs(place[1] - 0.2) > 0.02)  # noqa: PLR2004
    assert np.ptp(displaced(arm(tmp_path, nowhere), 1.5)[:, 4:7], axis=0).max() < 1e-3


def test_what_is_not_there_or_fixed_is_refused_and_without_a_displacement_nothing_is_applied(tmp_path: Path) -> None:
    spec, move = walls(tmp_path), (Displacement(0.0, 0.1, 0.0),)
    with pytest.raises(InputError, match="displacements: there is no body 'mug'; there are cup"):
        ArmRobot(spec, {"cup": BODY}, displacements={"mug": move})
    with pytest.raises(InputError, match="displacements: cup is fixed; only what stands free can be displaced"):
        ArmRobot(spec, {"cup": BodySpec(CUP.file, AT)}, displacements={"cup": move})
    robot = ArmRobot(spec, {"cup": BODY})
    context = robot.plant.GetMyContextFromRoot(robot.CreateDefaultContext())
    assert not robot.plant.get_applied_spatial_force_input_port().HasValue(context)
