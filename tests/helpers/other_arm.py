"""A 6-axis arm that is no part of the library."""

from pathlib import Path

from pydrake.multibody.parsing import LoadModelDirectivesFromString

from ichain_drake.robot import HandSpec, Posture, RobotSpec

OTHER = Path(__file__).parent / "other_arm.urdf"


def other_arm(**kwargs: object) -> RobotSpec:
    """A 6-axis arm without gripper."""
    directives = LoadModelDirectivesFromString(f"""
directives:
- add_model:
    name: other
    file: file://{OTHER}
- add_weld: {{parent: world, child: other::foot}}
- add_frame:
    name: other::tool
    X_PF: {{base_frame: other::a6, translation: [0, 0, 0.06], rotation: !Rpy {{deg: [0, 0, 180]}}}}
""").directives
    values: dict[str, object] = {
        "directives": directives,
        "arm": "other",
        "gripper": "",
        "hand_frame": "tool",
        "hand": HandSpec(["x", "y", "z", "yaw"]),
        "home": {"x": 0.3, "y": 0.05, "z": 0.25},
        "kp": [5000.0],
        "kd": [80.0],
        "postures": [Posture(0.0, [0.0, 0.3, 1.5, 0.0, 1.3, 0.0])],
        "posture_weights": [],
    }
    return RobotSpec(**(values | kwargs))
