"""What a scenario's YAML says about its robot: arm, gripper, gains, hand, and the bodies that stand in its plant.

Every class has defaults for all fields, so that Drake's typed YAML reader (`pydrake.common.yaml.yaml_load_typed`) fills
in what a file leaves out and refuses keys that don't exist.
"""

# No `from __future__ import annotations`: Drake's typed YAML reader needs the fields' types themselves.

from dataclasses import dataclass, field

from pydrake.common.schema import Transform
from pydrake.multibody.parsing import ModelDirective

from ichain_drake.errors import InputError
from ichain_drake.robot.hand import HAND, HandSpec
from ichain_drake.settings import setting
from ichain_drake.state import FloatArray

DEFAULT_ARM = "package://ichain_drake_models/robots/gen3_gripper.dmd.yaml"


@dataclass
class Posture:
    """Joint positions that the arm's free motion is drawn to.

    Attributes:
        pitch: hand pitch at which it holds [rad]; between two postures it is interpolated by cos(pitch).
        joints: one value a joint of the arm [rad or m]. The first joint is taken relative to the hand's bearing if its
            axis is vertical.
    """

    pitch: float = setting(0.0, "rad")
    joints: list[float] = setting(list, "rad or m")


def _gen3_postures() -> list[Posture]:
    return [
        Posture(0.0, [0.0, 0.6, 3.141592653589793, -1.9, 0.0, -1.2, 1.5707963267948966]),
        Posture(1.5707963267948966, [0.0, 1.0, 3.141592653589793, -1.8, 0.0, 0.8, 1.5707963267948966]),
    ]


@dataclass
class BodySpec:
    """An object's body in the arm's plant (`contact` physics).

    Attributes:
        file: model file, by `package://ichain_drake_models/` address or path.
        pose: of the model's first link in the robot frame.
        fixed: whether that link is welded there; a free body otherwise starts there.
        joints: joint positions at start, by joint name [rad or m]; 0 where not named.
    """

    file: str = ""
    pose: Transform = field(default_factory=Transform)
    fixed: bool = True
    joints: dict[str, float] = field(default_factory=dict)


@dataclass
class RobotSpec:
    """The robot of a scenario.

    Attributes:
        model: directives file of arm and gripper, welded to the world.
        directives: directives in its place, if any (another arm without a file of its own).
        scenery: directives of static things (a table) that the arm can touch and that are no object of the graph.
        arm, gripper: names of the model instances; an empty gripper name means none.
        hand_frame: frame of the gripper (of the arm, without gripper) that the hand's pose is.
        hand: variables of the hand.
        home: hand state at start, by variable; 0 where not named.
        kp, kd: gains of the arm's joints [Nm/rad, Nms/rad], one a joint or one for all.
        gripper_kp, gripper_kd: gains of the driven finger [N/m, Ns/m].
        gripper_open, gripper_closed: finger positions, by joint of the gripper [m]; closed may lie beyond the joint's
            limit: the excess times `gripper_kp`, up to the actuator's effort, is the grip force.
        gripper_speed: of each finger's desired position as the grip closes [m/s]; above 0.
        postures: see `Posture`; none means: the default positions of the model.
        posture_weights: how strongly each joint is drawn to its posture, one a joint; none means 1 for all.
        posture_gain: rate of that motion [1/s].
        linear_speed, angular_speed: limits of the hand's set-point [m/s, rad/s].
        speed_scale: factor on the joint-speed limits of the model.
        plant_step: step of the plant [s]; 1/30 s over an integer power of two, so that both clocks agree in floating
            point.
        ik_rate: inverse kinematics updates in a second: 30 times a power of two.
    """

    model: str = DEFAULT_ARM
    directives: list[ModelDirective] = field(default_factory=list)
    scenery: list[ModelDirective] = field(default_factory=list)
    arm: str = setting("arm", filled=True)
    gripper: str = "gripper"
    hand_frame: str = setting("tcp", filled=True)
    hand: HandSpec = field(default_factory=HandSpec)
    home: dict[str, float] = setting(lambda: {"x": 0.45, "y": 0.0, "z": 0.25}, "m or rad")
    kp: list[float] = setting(lambda: [10000.0] * 4 + [3000.0] * 3, "Nm/rad", above=0, upper=1e7, filled=True)
    kd: list[float] = setting(lambda: [130.0] * 4 + [30.0] * 3, "Nms/rad", above=0, upper=1e7, filled=True)
    gripper_kp: float = setting(4000.0, "N/m", above=0, upper=1e7)
    gripper_kd: float = setting(60.0, "Ns/m", above=0, upper=1e7)
    gripper_open: dict[str, float] = setting(
        lambda: {"finger_left": 0.04, "finger_right": 0.04}, "m", lower=-1, upper=1
    )
    gripper_closed: dict[str, float] = setting(
        lambda: {"finger_left": -0.02, "finger_right": -0.02}, "m", lower=-1, upper=1
    )
    gripper_speed: float = setting(0.2, "m/s", above=0, upper=10)
    postures: list[Posture] = field(default_factory=_gen3_postures)
    posture_weights: list[float] = setting(lambda: [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0], lower=0, upper=1e6)
    posture_gain: float = setting(2.0, "1/s", lower=0, upper=1000)
    linear_speed: float = setting(0.4, "m/s", above=0, upper=10)
    angular_speed: float = setting(2.0, "rad/s", above=0, upper=100)
    speed_scale: float = setting(1.0, above=0, upper=10)
    plant_step: float = setting(1.0 / 120.0, "s", lower=1e-4, upper=1.0 / 30.0)
    ik_rate: int = setting(60, "1/s", lower=30, upper=7680)

    def home_hand(self) -> FloatArray:
        """The full hand state at start, shape (7,): `home`, over what the hand holds.

        Raises:
            InputError: on a name that is not the hand's.
        """
        values = dict(self.hand.held) | self.home
        full = self.hand.full([values.get(name, 0.0) for name in self.hand.space.names])
        for name, value in self.home.items():
            if name not in HAND.names:
                raise InputError(f"robot.home: no variable {name!r}; a hand has {', '.join(HAND.names)}")
            full[HAND.index(name)] = value
        return full
