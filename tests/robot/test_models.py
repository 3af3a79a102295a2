"""Every model file parses, and the arm is the published one."""

import gc
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from pydrake.geometry import Meshcat, MeshcatParams
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import MultibodyForces
from pydrake.visualization import ModelVisualizer

import ichain_drake
from ichain_drake.errors import InputError
from ichain_drake.robot import model_parser, models_path, package_map
from ichain_drake.robot.kinematics import ArmKinematics
from ichain_drake.robot.models import resolve_model
from ichain_drake.robot.plant import control_plant
from ichain_drake.robot.spec import RobotSpec

OWN = ("gen3", "gripper", "joystick", "robots", "table")
FILES = sorted(
    f.relative_to(models_path()).as_posix()
    for folder in OWN
    for f in (models_path() / folder).rglob("*")
    if f.name.endswith((".urdf", ".sdf", ".dmd.yaml"))
)

# Joint origins of the published Gen3: xyz [m], rpy [rad].
HALF, TURN = np.pi / 2, np.pi
GEN3 = [
    ((0, 0, 0.15643), TURN),
    ((0, 0.005375, -0.12838), HALF),
    ((0, -0.21038, -0.006375), -HALF),
    ((0, 0.006375, -0.21038), HALF),
    ((0, -0.20843, -0.006375), -HALF),
    ((0, 0.00017505, -0.10593), HALF),
    ((0, -0.10593, -0.00017505), -HALF),
]
FLANGE, TCP = ((0, 0, -0.061525), TURN), (0, 0, 0.1009)


def numpy_transform(xyz: tuple, roll: float, angle: float = 0.0) -> np.ndarray:
    """Translation, roll about x, then a joint angle about z, as a 4 x 4 matrix."""
    c, s, cq, sq = np.cos(roll), np.sin(roll), np.cos(angle), np.sin(angle)
    out = np.eye(4)
    out[:3, :3] = np.array([[1, 0, 0], [0, c, -s], [0, s, c]]) @ np.array([[cq, -sq, 0], [sq, cq, 0], [0, 0, 1]])
    out[:3, 3] = xyz
    return out


@pytest.fixture(scope="module")
def kinematics() -> ArmKinematics:
    """The default arm's."""
    spec = RobotSpec()
    return ArmKinematics(control_plant(spec), spec)


def test_all_kinds_of_files_are_found() -> None:
    assert len(FILES) >= 5


@pytest.mark.parametrize("file", FILES)
def test_file_parses_without_network(file: str) -> None:
    plant = MultibodyPlant(1 / 120)
    assert model_parser(plant).AddModels(str(models_path() / file))
    plant.Finalize()
    assert plant.num_bodies() > 1


@pytest.fixture
def meshcat() -> Iterator[Meshcat]:
    yield Meshcat(MeshcatParams(host="127.0.0.1"))
    gc.collect()  # a visualizer is a cycle, and if another thread than this deletes its parts, the process ends


@pytest.mark.parametrize("file", FILES)
def test_file_opens_in_the_model_visualizer(file: str, meshcat: Meshcat) -> None:
    visualizer = ModelVisualizer(browser_new=False, publish_contacts=False, meshcat=meshcat)
    visualizer.package_map().AddMap(package_map())
    visualizer.AddModels(str(models_path() / file))
    visualizer.Finalize()
    visualizer.Run(loop_once=True)


def test_package_xml_names_the_package() -> None:
    assert "<name>ichain_drake_models</name>" in (models_path() / "package.xml").read_text()
    assert Path(package_map().GetPath("ichain_drake_models")) == models_path()


def test_missing_model_is_named() -> None:
    with pytest.raises(InputError, match="body cup: there is no model file"):
        resolve_model("package://ichain_drake_models/no/such.urdf", "body cup")


@pytest.mark.parametrize("seed", range(5))
def test_forward_kinematics_is_the_product_of_published_transforms(kinematics: ArmKinematics, seed: int) -> None:
    joints = np.random.default_rng(seed).uniform(-2, 2, 7)
    pose = np.eye(4)
    for (xyz, roll), angle in zip(GEN3, joints, strict=True):
        pose = pose @ numpy_transform(xyz, roll, angle)
    pose = pose @ numpy_transform(*FLANGE) @ numpy_transform(TCP, 0.0)
    np.testing.assert_allclose(kinematics.pose(joints).GetAsMatrix4(), pose, atol=1e-9)


def test_limits_are_the_published_ones(kinematics: ArmKinematics) -> None:
    inf = np.inf
    np.testing.assert_allclose(kinematics.upper, [inf, 2.24, inf, 2.57, inf, 2.09, inf])
    np.testing.assert_allclose(kinematics.lower, -kinematics.upper)
    np.testing.assert_allclose(kinematics.speed, [1.3963] * 4 + [1.2218] * 3)
    plant = control_plant(RobotSpec())
    efforts = [plant.get_joint_actuator(i).effort_limit() for i in plant.GetJointActuatorIndices()]
    assert efforts == [39] * 4 + [9] * 3 + [80]


def test_joystick_has_springs_and_turns_as_declared() -> None:
    plant = MultibodyPlant(1 / 120)
    model_parser(plant).AddModels(str(models_path() / "joystick/joystick.sdf"))
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("base"))
    plant.Finalize()
    context = plant.CreateDefaultContext()
    a, b = 0.3, -0.2
    plant.SetPositions(context, [a, b])
    knob = plant.GetFrameByName("stick").CalcPoseInWorld(context) @ np.array([0, 0, 0.1])
    rotation = RigidTransform(RollPitchYaw(0, a, 0), [0, 0, 0.05]) @ RigidTransform(RollPitchYaw(-b, 0, 0), [0, 0, 0])
    np.testing.assert_allclose(knob, rotation @ np.array([0, 0, 0.1]), atol=1e-12)
    # Gravity and springs: the stick is balanced, so 0.5 Nm/rad alone remain.
    forces = MultibodyForces(plant)
    plant.CalcForceElementsContribution(context, forces)
    np.testing.assert_allclose(forces.generalized_forces(), [-0.5 * a, -0.5 * b], atol=1e-12)
    np.testing.assert_allclose(plant.CalcGravityGeneralizedForces(context), 0.0, atol=1e-12)


def test_drakes_visualizer_finds_our_models(meshcat: Meshcat) -> None:
    visualizer = ichain_drake.model_visualizer(visualize_frames=True, meshcat=meshcat)
    visualizer.AddModels(url="package://ichain_drake_models/joystick/joystick.sdf")
    visualizer.Finalize()
    assert visualizer.meshcat().web_url().startswith("http")
