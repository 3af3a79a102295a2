"""The arm's plant: models, gains, collision filters, and the bodies of mechanical objects."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from pydrake.geometry import CollisionFilterDeclaration, SceneGraph
from pydrake.multibody.parsing import (
    LoadModelDirectives,
    ModelDirective,
    ModelDirectives,
    Parser,
    ProcessModelDirectives,
)
from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlant, MultibodyPlantConfig
from pydrake.multibody.tree import JointActuator, ModelInstanceIndex, PdControllerGains
from pydrake.systems.framework import DiagramBuilder

from ichain_drake.errors import InputError
from ichain_drake.robot.models import model_parser, resolve_model
from ichain_drake.robot.spec import BodySpec, RobotSpec
from ichain_drake.state import FloatArray
from ichain_drake.timing import FRAME


@dataclass(frozen=True)
class RobotPlant:
    """A finalized plant and what is known about it.

    Attributes:
        plant, scene_graph: in the builder.
        arm, gripper: model instances; gripper is None where there is none.
        bodies: model instance of each mechanical object.
        fingers: driven joints of the gripper, in actuator order.
    """

    plant: MultibodyPlant
    scene_graph: SceneGraph
    arm: ModelInstanceIndex
    gripper: ModelInstanceIndex | None
    bodies: dict[str, ModelInstanceIndex]
    fingers: tuple[str, ...]

    def finger_targets(self, positions: Mapping[str, float], where: str) -> FloatArray:
        """Positions of the driven fingers, shape (n_fingers,).

        Raises:
            InputError: if one is missing, or is none of the gripper's.
        """
        joints = () if self.gripper is None else map(self.plant.get_joint, self.plant.GetJointIndices(self.gripper))
        known = [joint.name() for joint in joints if joint.num_positions()]
        for name in positions if known else ():
            if name not in known:
                raise InputError(f"robot.{where}: there is no joint {name!r}; the gripper has {', '.join(known)}")
        for name in self.fingers:
            if name not in positions:
                raise InputError(f"robot.{where}: no position for the driven joint {name}")
        return np.array([positions[name] for name in self.fingers], dtype=float)


def robot_directives(spec: RobotSpec) -> ModelDirectives:
    """Directives of arm and gripper.

    Raises:
        InputError: if there is no such file or it is not a directives file.
    """
    if spec.directives:
        return ModelDirectives(directives=spec.directives)
    path = resolve_model(spec.model, "robot.model")
    try:
        return LoadModelDirectives(path)
    except RuntimeError as error:
        raise InputError(f"robot.model: {path} is not a directives file: {_first_line(error)}") from error


def control_plant(spec: RobotSpec) -> MultibodyPlant:
    """A finalized plant with arm and gripper alone, for kinematics.

    Raises:
        InputError: if a model can't be read or an instance is missing.
    """
    plant = MultibodyPlant(0.0)
    _add_directives(model_parser(plant), robot_directives(spec).directives, "robot.model")
    _robot_instances(plant, spec)
    plant.Finalize()
    return plant


def add_robot_plant(builder: DiagramBuilder, spec: RobotSpec, bodies: Mapping[str, BodySpec]) -> RobotPlant:
    """Add plant and scene graph with arm, gripper, scenery and the objects' bodies.

    Nothing joins gripper and bodies: they meet by contact alone. Arm and gripper are weightless (a real arm's
    controller makes up for gravity) and don't collide with themselves.

    Raises:
        InputError: if a model can't be read, an instance is missing, or gains or the step don't fit.
    """
    ratio = FRAME / spec.plant_step
    if abs(math.log2(ratio) - round(math.log2(ratio))) > 1e-9 or ratio < 1:
        raise InputError(f"robot.plant_step: {spec.plant_step} s is not 1/30 s over a power of two (1/120 s is usual)")
    config = MultibodyPlantConfig(
        # Divided from the frame, so that k steps equal a frame bit by bit.
        time_step=FRAME / round(ratio),
        contact_model="point",
        discrete_contact_approximation="lagged",
        use_sampled_output_ports=False,
    )
    plant, scene_graph = AddMultibodyPlant(config, builder)
    parser = model_parser(plant)
    _add_directives(parser, robot_directives(spec).directives, "robot.model")
    _add_directives(parser, spec.scenery, "robot.scenery")
    arm, gripper = _robot_instances(plant, spec)
    instances = {name: _add_body(plant, name, body) for name, body in bodies.items()}
    fingers = _set_gains(plant, spec, arm, gripper)
    owned = [i for i in (arm, gripper) if i is not None]
    for instance in owned:
        plant.set_gravity_enabled(instance, False)
    plant.Finalize()
    for name, body in bodies.items():
        _set_joints(plant, instances[name], name, body)
    links = [plant.get_body(b) for instance in owned for b in plant.GetBodyIndices(instance)]
    scene_graph.collision_filter_manager().Apply(
        CollisionFilterDeclaration().ExcludeWithin(plant.CollectRegisteredGeometries(links))
    )
    return RobotPlant(plant, scene_graph, arm, gripper, instances, fingers)


def _first_line(error: Exception) -> str:
    return str(error).strip().splitlines()[0]


def _add_directives(parser: Parser, directives: list[ModelDirective], where: str) -> None:
    if not directives:
        return
    try:
        ProcessModelDirectives(ModelDirectives(directives=directives), parser)
    except RuntimeError as error:
        raise InputError(f"{where}: {_first_line(error)}") from error


def _robot_instances(plant: MultibodyPlant, spec: RobotSpec) -> tuple[ModelInstanceIndex, ModelInstanceIndex | None]:
    for key, name in (("arm", spec.arm), ("gripper", spec.gripper)):
        if name and not plant.HasModelInstanceNamed(name):
            raise InputError(f"robot.{key}: the model has no instance {name!r}; name it as in the directives")
    arm = plant.GetModelInstanceByName(spec.arm)
    return arm, plant.GetModelInstanceByName(spec.gripper) if spec.gripper else None


def _add_body(plant: MultibodyPlant, name: str, body: BodySpec) -> ModelInstanceIndex:
    path = resolve_model(body.file, f"body {name}")
    if plant.HasModelInstanceNamed(name):
        raise InputError(f"body {name}: the plant already has a model of that name")
    parser = model_parser(plant)
    parser.SetAutoRenaming(True)
    try:
        models = parser.AddModels(path)
    except RuntimeError as error:
        raise InputError(f"body {name}: {_first_line(error)}") from error
    if len(models) != 1:
        raise InputError(f"body {name}: {path} holds {len(models)} models, one is needed")
    plant.RenameModelInstance(models[0], name)
    base = plant.get_body(plant.GetBodyIndices(models[0])[0])
    pose = body.pose.GetDeterministicValue()
    if body.fixed:
        plant.WeldFrames(plant.world_frame(), base.body_frame(), pose)
    else:
        plant.SetDefaultFloatingBaseBodyPose(base, pose)
    return models[0]


def _set_joints(plant: MultibodyPlant, instance: ModelInstanceIndex, name: str, body: BodySpec) -> None:
    for joint_name, value in body.joints.items():
        if not plant.HasJointNamed(joint_name, instance):
            raise InputError(f"body {name}: its model has no joint {joint_name!r}")
        plant.GetJointByName(joint_name, instance).set_default_positions([value])


def _actuators(plant: MultibodyPlant, instance: ModelInstanceIndex) -> list[JointActuator]:
    # GetJointActuatorIndices(instance) is empty before Finalize (Drake 1.51), hence the search.
    actuators = [plant.get_mutable_joint_actuator(i) for i in plant.GetJointActuatorIndices()]
    return [a for a in actuators if a.model_instance() == instance]


def _set_gains(
    plant: MultibodyPlant, spec: RobotSpec, arm: ModelInstanceIndex, gripper: ModelInstanceIndex | None
) -> tuple[str, ...]:
    actuators = _actuators(plant, arm)
    gains = []
    for key, values in (("kp", spec.kp), ("kd", spec.kd)):
        if len(values) not in (1, len(actuators)):
            raise InputError(f"robot.{key}: {len(values)} gains given, the arm has {len(actuators)} actuated joints")
        gains.append(values * len(actuators) if len(values) == 1 else values)
    for actuator, p, d in zip(actuators, *gains, strict=True):
        actuator.set_controller_gains(PdControllerGains(p=p, d=d))
    if gripper is None:
        return ()
    if not spec.gripper_speed > 0:
        raise InputError(f"robot.gripper_speed: {spec.gripper_speed} m/s; give a speed above 0")
    driven = _actuators(plant, gripper)
    for actuator in driven:
        actuator.set_controller_gains(PdControllerGains(p=spec.gripper_kp, d=spec.gripper_kd))
    return tuple(a.joint().name() for a in driven)
