"""The `arm` and `contact` physics: an arm with a gripper in a MultibodyPlant follows the hand command."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike
from pydrake.geometry import QueryObject
from pydrake.systems.framework import Context, Diagram, DiagramBuilder
from pydrake.systems.primitives import Demultiplexer, ZeroOrderHold

from ichain_drake.robot.displacing import BodyDisplacer, Displacement
from ichain_drake.robot.hand import GRIP, HAND
from ichain_drake.robot.inverse_kinematics import FRAME_MARK, InverseKinematics
from ichain_drake.robot.kinematics import ArmKinematics
from ichain_drake.robot.measurement import HandMeasurement
from ichain_drake.robot.plant import add_robot_plant, control_plant
from ichain_drake.robot.playout import Playout
from ichain_drake.robot.sensors import HandSensor, TouchSensor
from ichain_drake.robot.spec import BodySpec, RobotSpec
from ichain_drake.state import FloatArray, StateSpace
from ichain_drake.timing import FRAME

# Fingers count as touching at this distance [m].
_TOUCH = 1e-5


class ArmRobot(Diagram):
    """Hand command in, hand state out, through joints, motors and (in `contact`) friction.

    Ports: input `hand_command` (n_exposed); outputs `state` (n_exposed; the truth, no feedthrough), `measured`
    (n_exposed), `valid` (1), `setpoint` (7), per body `<object>_body` ([q; v] of its model) and `<object>_touch` (1:
    normal force of gripper on object [N], up to 25; computed only when read), `plant_positions` (q of the whole plant),
    `query` (the scene graph's query object, for visualizers).

    Args:
        spec: see `RobotSpec`.
        bodies: bodies of mechanical objects, by object name; empty in `arm` physics.
        seed: the run's seed.
        object_id: the robot object's number, which keys its noise.
        start: full hand state of the default context, shape (7,); the spec's home by default. With grip 1 the fingers
            are closed until they just touch what is between them.
        displacements: of bodies, by object name, by somebody else: a fault.

    Raises:
        InputError: if models, names or gains don't fit, or what is to be displaced is no free body.
        UnreachableError: if the arm can't reach the home hand state, or the start.
    """

    def __init__(  # noqa: PLR0915 - one system after the other
        self,
        spec: RobotSpec,
        bodies: Mapping[str, BodySpec],
        seed: int = 0,
        object_id: int = 0,
        start: FloatArray | None = None,
        displacements: Mapping[str, tuple[Displacement, ...]] | None = None,
    ) -> None:
        super().__init__()
        self.spec = spec
        self.bodies = dict(bodies)
        builder = DiagramBuilder()
        self._robot = add_robot_plant(builder, spec, bodies)
        self.plant, self.scene_graph = self._robot.plant, self._robot.scene_graph
        self.kinematics = ArmKinematics(control_plant(spec), spec)
        home = spec.home_hand()
        joints = self.kinematics.solve(home)
        if start is not None:
            home = HAND.check(start, "hand state")
            joints = self.kinematics.solve(home)
        self.plant.SetDefaultPositions(self._robot.arm, joints)
        self._grip_ends = self._finger_ends()

        add = builder.AddNamedSystem
        grip = np.stack(
            [
                self._robot.finger_targets(spec.gripper_open, "gripper_open"),
                self._robot.finger_targets(spec.gripper_closed, "gripper_closed"),
            ]
        )
        step = self.plant.time_step()
        closed = bool(home[GRIP] > 0.5)
        self.motion = InverseKinematics(
            spec.hand,
            home,
            spec.linear_speed,
            spec.angular_speed,
            self.kinematics,
            joints,
            spec.ik_rate,
            step,
            grip,
            spec.gripper_speed,
            closed=closed,
        )
        add("motion", self.motion)
        n, fingers = self.kinematics.size, len(self._robot.fingers)
        self.playout = add("playout", Playout(n, fingers, self.motion.steps, step, np.r_[joints, grip[int(closed)]]))
        self._sensor = sensor = add("hand_sensor", HandSensor(spec.hand, self.kinematics))
        self.measurement = add("measurement", HandMeasurement(spec.hand, seed, object_id))
        positions = add("positions", Demultiplexer([self.plant.num_positions(), self.plant.num_velocities()]))

        connect, plant, arm = builder.Connect, self.plant, self._robot.arm
        frames = add("frames", ZeroOrderHold(FRAME, FRAME_MARK))  # holds what it holds; its update is what matters
        connect(frames.get_output_port(), frames.get_input_port())
        connect(frames.get_output_port(), self.motion.GetInputPort("frame"))
        connect(self.motion.GetOutputPort("joint_plan"), self.playout.get_input_port())
        desired = add("desired", Demultiplexer([2 * size for size in (n, fingers) if size]))
        connect(self.playout.get_output_port(), desired.get_input_port())
        connect(desired.get_output_port(0), plant.get_desired_state_input_port(arm))
        if fingers:
            connect(desired.get_output_port(1), plant.get_desired_state_input_port(self._robot.gripper))
        connect(plant.get_state_output_port(arm), sensor.GetInputPort("arm_state"))
        connect(self.motion.GetOutputPort("setpoint"), sensor.GetInputPort("setpoint"))
        connect(sensor.get_output_port(), self.measurement.get_input_port())
        connect(plant.get_state_output_port(), positions.get_input_port())

        builder.ExportInput(self.motion.GetInputPort("hand_command"), "hand_command")
        builder.ExportOutput(sensor.get_output_port(), "state")
        builder.ExportOutput(self.measurement.GetOutputPort("measured"), "measured")
        builder.ExportOutput(self.measurement.GetOutputPort("valid"), "valid")
        builder.ExportOutput(self.motion.GetOutputPort("setpoint"), "setpoint")
        if self._robot.bodies:
            touching = arm if self._robot.gripper is None else self._robot.gripper
            touch = add("touch", TouchSensor(plant, touching, self._robot.bodies))
            connect(plant.get_contact_results_output_port(), touch.get_input_port())
            for name, instance in self._robot.bodies.items():
                builder.ExportOutput(plant.get_state_output_port(instance), f"{name}_body")
                builder.ExportOutput(touch.GetOutputPort(name), f"{name}_touch")
            if displacements:
                displacer = add("displacer", BodyDisplacer(plant, self._robot.bodies, displacements))
                connect(self.motion.GetOutputPort("setpoint"), displacer.GetInputPort("setpoint"))
                connect(displacer.get_output_port(), plant.get_applied_spatial_force_input_port())
                for name in displacements:
                    connect(plant.get_state_output_port(self._robot.bodies[name]), displacer.GetInputPort(name))
                    connect(touch.GetOutputPort(name), displacer.GetInputPort(f"{name}_touch"))
        builder.ExportOutput(positions.get_output_port(0), "plant_positions")
        builder.ExportOutput(self.scene_graph.get_query_output_port(), "query")
        builder.BuildInto(self)
        self._start_with_fingers(closed=closed)

    @property
    def space(self) -> StateSpace:
        """State space of the robot object."""
        return self.spec.hand.space

    def body_size(self, name: str) -> int:
        """Length of `<object>_body`."""
        return self.plant.num_multibody_states(self._robot.bodies[name])

    def states(self, setpoints: FloatArray, positions: FloatArray) -> FloatArray:
        """What `state` was, shape (n, n_exposed), from `setpoint` (n, 7) and `plant_positions` (n, n_q) of the time."""
        arm, plant = self._robot.arm, self.plant
        joints = [plant.GetPositionsFromArray(arm, row) for row in positions]
        rows = [self._sensor.state(*of) for of in zip(joints, setpoints, strict=True)]
        return np.array(rows).reshape(len(rows), len(self.space))

    def set_hand(self, root_context: Context, full: ArrayLike) -> None:
        """Put arm, fingers, set-point and inverse kinematics at a hand state, at rest.

        With grip 1 the fingers are closed until they just touch what is between them; so place the objects first.

        Args:
            root_context: context of the diagram that holds this one (or of this one).
            full: x, y, z [m], yaw, pitch, roll [rad], grip; shape (7,).

        Raises:
            InputError: on a wrong shape or a value that is not finite.
            UnreachableError: if the arm can't get there; says how close it comes.
        """
        value = HAND.check(full, "hand state")
        joints = self.kinematics.solve(value)
        plant_context = self.plant.GetMyMutableContextFromRoot(root_context)
        self.plant.SetPositions(plant_context, self._robot.arm, joints)
        self.plant.SetVelocities(plant_context, self._robot.arm, np.zeros(len(joints)))
        closed = bool(value[GRIP] > 0.5)
        motion_context = self.motion.GetMyMutableContextFromRoot(root_context)
        self.motion.set_hand(motion_context, value)
        row = self.motion.set_joints(motion_context, joints, closed=closed)
        self.playout.set_rows(self.playout.GetMyMutableContextFromRoot(root_context), row)
        self.measurement.set_hand(self.measurement.GetMyMutableContextFromRoot(root_context))
        if self._robot.gripper is not None:
            self._set_fingers(root_context, closed=closed)

    def _finger_ends(self) -> FloatArray:
        """Positions of all finger joints when open and when shut on nothing, shape (2, n)."""
        if self._robot.gripper is None:
            return np.zeros((2, 0))
        plant = self.plant
        joints = [plant.get_joint(j) for j in plant.GetJointIndices(self._robot.gripper)]
        ends = np.zeros((2, plant.num_positions(self._robot.gripper)))
        place = 0
        for joint in joints:
            for _ in range(joint.num_positions()):
                for row, positions in enumerate((self.spec.gripper_open, self.spec.gripper_closed)):
                    low, high = joint.position_lower_limits()[0], joint.position_upper_limits()[0]
                    ends[row, place] = np.clip(positions.get(joint.name(), 0.0), low, high)
                place += 1
        return ends

    def _set_fingers(self, root_context: Context, closed: bool) -> None:
        plant_context = self.plant.GetMyMutableContextFromRoot(root_context)
        gripper = self._robot.gripper
        self.plant.SetVelocities(plant_context, gripper, np.zeros(self.plant.num_velocities(gripper)))
        opened, shut = self._grip_ends
        # Bisect the way from open (0) to shut (1) for the first touch.
        low, high = 0.0, 1.0
        if closed and self._clearance(root_context, shut) < _TOUCH:
            for _ in range(16):
                middle = 0.5 * (low + high)
                touches = self._clearance(root_context, opened + middle * (shut - opened)) < _TOUCH
                low, high = (low, middle) if touches else (middle, high)
            self.plant.SetPositions(plant_context, gripper, opened + low * (shut - opened))
        else:
            self.plant.SetPositions(plant_context, gripper, shut if closed else opened)

    def _start_with_fingers(self, closed: bool) -> None:
        """Make fingers that hold what is between them part of the default context."""
        if self._robot.gripper is not None:
            context = self.CreateDefaultContext()
            self._set_fingers(context, closed=closed)
            self.plant.SetDefaultPositions(self.plant.GetPositions(self.plant.GetMyContextFromRoot(context)))

    def _clearance(self, root_context: Context, fingers: FloatArray) -> float:
        """Least distance between the gripper and anything that it may collide with [m]; large if nothing is near."""
        plant_context = self.plant.GetMyMutableContextFromRoot(root_context)
        gripper = self._robot.gripper
        self.plant.SetPositions(plant_context, gripper, fingers)
        query: QueryObject = self.scene_graph.get_query_output_port().Eval(
            self.scene_graph.GetMyContextFromRoot(root_context)
        )
        own = {
            g
            for b in self.plant.GetBodyIndices(gripper)
            for g in self.plant.GetCollisionGeometriesForBody(self.plant.get_body(b))
        }
        pairs = query.ComputeSignedDistancePairwiseClosestPoints(0.05)
        return min((p.distance for p in pairs if p.id_A in own or p.id_B in own), default=1.0)
