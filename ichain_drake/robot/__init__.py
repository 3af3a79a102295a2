"""The robot: a hand that follows commands, by itself (`ideal`) or at the end of an arm (`arm`, `contact`)."""

from ichain_drake.robot.arm import ArmRobot
from ichain_drake.robot.build import ROBOT_PHYSICS, Physics, build_robot
from ichain_drake.robot.displacing import Displacement
from ichain_drake.robot.hand import HAND, HandSpec, RingPath, SphereSurface
from ichain_drake.robot.ideal import IdealHand
from ichain_drake.robot.models import model_parser, models_path, package_map
from ichain_drake.robot.motion_planning import MotionPlanner
from ichain_drake.robot.pose import hand_pose, hand_values
from ichain_drake.robot.spec import BodySpec, Posture, RobotSpec

__all__ = [
    "HAND",
    "ROBOT_PHYSICS",
    "ArmRobot",
    "BodySpec",
    "Displacement",
    "HandSpec",
    "IdealHand",
    "MotionPlanner",
    "Physics",
    "Posture",
    "RingPath",
    "RobotSpec",
    "SphereSurface",
    "build_robot",
    "hand_pose",
    "hand_values",
    "model_parser",
    "models_path",
    "package_map",
]
