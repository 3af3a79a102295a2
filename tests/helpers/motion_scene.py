"""A wall on the table before the arm, and how the arm goes along a path in its own plant, for tests."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from joystick_scene import Runner
from pydrake.common.schema import Transform
from pydrake.multibody.parsing import LoadModelDirectivesFromString

from ichain_drake.robot import BodySpec, HandSpec, RobotSpec
from ichain_drake.state import FloatArray

CUP = BodySpec("package://ichain_drake_models/cup/cup.sdf", Transform(translation=[0.0, 0.0, 0.0]), fixed=False)
_BOX = """<robot name="{name}"><link name="body">
<inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
<collision><origin xyz="{place}"/><geometry><box size="{size}"/></geometry></collision></link></robot>"""


def walls(folder: Path, **boxes: tuple[tuple[float, ...], tuple[float, ...]]) -> RobotSpec:
    """The arm with boxes around it: middle and size of each [m]; the hand shows x, y, z, pitch and grip."""
    text = "directives:\n"
    for name, (place, size) in boxes.items():
        file = folder / f"{name}.urdf"
        file.write_text(_BOX.format(name=name, place="{} {} {}".format(*place), size="{} {} {}".format(*size)))
        text += f"- add_model: {{name: {name}, file: file://{file}}}\n"
        text += f"- add_weld: {{parent: world, child: {name}::body}}\n"
    hand = HandSpec(["x", "y", "z", "pitch", "grip"])
    scenery = LoadModelDirectivesFromString(text).directives if boxes else []
    return RobotSpec(hand=hand, scenery=scenery, home={"x": 0.5, "y": 0.0, "z": 0.25})


def door(folder: Path) -> BodySpec:
    """A gate 18 cm high at x 0.5, 16 cm wide about y 0, that slides along y by up to 0.4 m."""
    file = folder / "gate.sdf"
    file.write_text("""<sdf version="1.7"><model name="gate"><link name="post"/><link name="leaf">
<collision name="c"><pose>0 0 0.09 0 0 0</pose><geometry><box><size>0.02 0.16 0.18</size></box></geometry></collision>
</link>
<joint name="slide" type="prismatic"><parent>post</parent><child>leaf</child>
<axis><xyz>0 1 0</xyz><limit><lower>0</lower><upper>0.4</upper></limit></axis></joint></model></sdf>""")
    return BodySpec(str(file), Transform(translation=[0.5, 0.0, 0.0]))


def executed(spec: RobotSpec, start: FloatArray, path: FloatArray) -> tuple[Runner, float]:
    """The arm after going along a path, and the least distance to anything on the way, at most 50 mm [m]."""
    runner = Runner(spec, path, "arm", start=spec.hand.full(start))
    robot, least = runner.robot, 0.05
    scene = robot.scene_graph.GetMyContextFromRoot(runner.root)
    for frame in range(1, 10 * len(path) + 15):
        runner.frame(frame)
        query = robot.scene_graph.get_query_output_port().Eval(scene)
        pairs = query.ComputeSignedDistancePairwiseClosestPoints(0.05)
        least = min([least, *(p.distance for p in pairs)])
    return runner, least


def longest_step(spec: RobotSpec, start: FloatArray, path: FloatArray) -> tuple[float, float]:
    """Largest step in a tick: of the place [m] and of the pitch [rad]."""
    steps = spec.hand.space.difference(path, np.vstack([start, path[:-1]]))
    return float(np.linalg.norm(steps[:, :3], axis=1).max()), float(np.abs(steps[:, 3]).max())
