"""The hand's variables, poses, and what a scenario exposes of them."""

import numpy as np
import pytest
from pydrake.common.yaml import yaml_load_typed
from pydrake.math import RigidTransform, RotationMatrix

from ichain_drake.errors import InputError
from ichain_drake.robot import HAND, HandSpec, RingPath, RobotSpec, SphereSurface, hand_pose, hand_values
from ichain_drake.robot.pose import rotation_vector
from ichain_drake.state import wrap_angle


def test_pose_is_the_declared_product_of_rotations() -> None:
    yaw, pitch, roll = 0.3, 0.5, -0.7
    make = RotationMatrix
    expected = make.MakeZRotation(yaw) @ make.MakeXRotation(roll) @ make.MakeYRotation(-pitch)
    pose = hand_pose([1, 2, 3, yaw, pitch, roll, 0])
    np.testing.assert_allclose(pose.rotation().matrix(), expected.matrix() @ np.diag([1, -1, -1]), atol=1e-14)
    np.testing.assert_allclose(pose.translation(), [1, 2, 3])


def test_down_approaches_down_and_forward_forward() -> None:
    np.testing.assert_allclose(hand_pose(np.zeros(7)).rotation().col(2), [0, 0, -1], atol=1e-15)
    forward = hand_pose([0, 0, 0, 0, np.pi / 2, 0, 0]).rotation()
    np.testing.assert_allclose(forward.col(2), [1, 0, 0], atol=1e-15)
    assert abs(forward.matrix()[1, 1]) == pytest.approx(1.0)  # fingers open along y


def test_values_invert_the_pose_near_the_previous_values() -> None:
    generator = np.random.default_rng(1)
    for _ in range(300):
        full = np.r_[generator.normal(size=3), generator.uniform(-np.pi, np.pi, 3), 1.0]
        near = full + np.r_[0, 0, 0, generator.normal(0, 0.02, 3), 0]
        back = hand_values(hand_pose(full), 1.0, near)
        np.testing.assert_allclose(back[:3], full[:3])
        turn = hand_pose(full).rotation().matrix() @ hand_pose(back).rotation().matrix().T
        assert np.abs(rotation_vector(turn)).max() < 1e-5
        assert np.abs(wrap_angle(back[3:6] - near[3:6])).max() < 0.15


def test_pouring_through_the_singular_roll_moves_roll_alone() -> None:
    previous = np.array([0.6, 0, 0.3, 0, np.pi / 2, 0, 1])
    for roll in np.linspace(0, -1.92, 60):
        wanted = np.array([0.6, 0, 0.3, 0, np.pi / 2, roll, 1])
        tilt = RigidTransform(RotationMatrix.MakeZRotation(1e-3), [0, 0, 0])  # a tracking error
        previous = hand_values(tilt @ hand_pose(wanted), 1.0, previous)
        assert np.abs(previous[3:6] - wanted[3:6]).max() < 0.02


def test_rotation_vector_of_half_a_turn() -> None:
    vector = rotation_vector(np.diag([1.0, -1.0, -1.0]))
    np.testing.assert_allclose(np.abs(vector), [np.pi, 0, 0], atol=1e-12)


def test_full_and_reduce_with_leading_dimensions() -> None:
    spec = HandSpec(["grip", "x", "y"], {"z": 0.2, "pitch": 0.5})
    exposed = np.arange(12.0).reshape(2, 2, 3)
    full = spec.full(exposed)
    assert full.shape == (2, 2, 7)
    np.testing.assert_array_equal(full[1, 1], [10, 11, 0.2, 0, 0.5, 0, 9])
    np.testing.assert_array_equal(spec.reduce(full), exposed)
    assert spec.space.names == ("grip", "x", "y")
    assert spec.space.variables[0].kind == "binary"


def test_z_follows_x_and_y_on_a_surface() -> None:
    spec = HandSpec(["x", "y"], {}, SphereSurface([0.5, 0.0, 0.05], 0.1))
    np.testing.assert_allclose(spec.full([0.5, 0.0])[2], 0.15)
    np.testing.assert_allclose(np.linalg.norm(spec.full([[0.53, -0.02]])[0, :3] - [0.5, 0, 0.05]), 0.1)
    assert spec.full([0.7, 0.0])[2] == pytest.approx(0.05)  # beyond the outline: its equator


def test_roles_and_bounds() -> None:
    spec = HandSpec(["x", "yaw"], {"y": 0, "z": 0.1}, bounds={"x": [0.3, 0.4]})
    x, yaw = spec.space.variables
    assert (x.lower, x.upper, x.role.kind, x.role.frame, x.role.axis) == (0.3, 0.4, "position", "robot", "x")
    assert (yaw.kind, yaw.role.kind, yaw.role.axis) == ("angle", "orientation", "z")
    assert HAND.names == ("x", "y", "z", "yaw", "pitch", "roll", "grip")


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        (HandSpec(["x", "y"]), "z is neither exposed nor held"),
        (HandSpec(["x", "y", "z"], {"x": 0.1}), "x is both exposed and held"),
        (HandSpec(["x", "y", "w"], {"z": 0.1}), "no variable 'w'"),
        (HandSpec(held={"w": 0.1}), "hand.held: no variable 'w'"),
        (HandSpec([]), "hand.exposed is empty"),
        (HandSpec(bounds={"x": [1.0]}), "x needs"),
        (HandSpec(bounds={"x": [1.0, 0.0]}), "lower bound"),
        (HandSpec(surface=SphereSurface()), "z follows the surface"),
    ],
)
def test_bad_specs_name_the_variable(spec: HandSpec, message: str) -> None:
    with pytest.raises(InputError, match=message):
        _ = spec.space


def test_negative_noise_is_refused() -> None:
    with pytest.raises(InputError, match="noise_std: y is negative"):
        HandSpec(noise_std={"y": -1.0}).noise_vector()


def test_robot_spec_from_yaml_and_unknown_keys() -> None:
    text = """
    hand: {exposed: [x, y, grip], held: {z: 0.2}, noise_std: {x: 0.001}}
    home: {x: 0.5, z: 0.2}
    postures: [{pitch: 0.0, joints: [0, 0.6, 3.14, -1.9, 0, -1.2, 1.57]}]
    scenery:
    - add_model: {name: table, file: "package://ichain_drake_models/table/table.urdf"}
    """
    spec = yaml_load_typed(schema=RobotSpec, data=text)
    assert spec.hand.space.names == ("x", "y", "grip")
    np.testing.assert_allclose(spec.home_hand(), [0.5, 0, 0.2, 0, 0, 0, 0])
    assert spec.scenery[0].add_model.name == "table"
    with pytest.raises(RuntimeError, match="no_such_key"):
        yaml_load_typed(schema=RobotSpec, data="no_such_key: 1")


def test_home_of_an_unknown_variable() -> None:
    with pytest.raises(InputError, match="robot.home: no variable 'w'"):
        RobotSpec(home={"w": 1.0}).home_hand()


def test_x_and_y_keep_to_a_ring() -> None:
    spec = HandSpec(["x", "y", "z"], {}, ring=RingPath([0.5, 0.1], 0.2))
    np.testing.assert_allclose(spec.full([0.5, 0.4, 0.3])[:3], [0.5, 0.3, 0.3])
    np.testing.assert_allclose(spec.full([[0.5, 0.1, 0.3]])[0, :2], [0.3, 0.1])  # from the axis itself: in front
    for bad, message in (
        (HandSpec(["x", "z"], {"y": 0.0}, ring=RingPath()), "x and y keep to the ring"),
        (HandSpec(["x", "y", "z"], {}, ring=RingPath([0.0], 0.1)), r"hand.ring: give center as \[x, y\]"),
        (HandSpec(["x", "y", "z"], {}, ring=RingPath([0.0, 0.0], 0.0)), "a radius above 0"),
    ):
        with pytest.raises(InputError, match=message):
            _ = bad.space
