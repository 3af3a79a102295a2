"""What the arm would touch: its own plant's collision queries over declared geometry and what the hand holds."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping

import numpy as np
from pydrake.geometry import CollisionFilterDeclaration, QueryObject
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Joint, ModelInstanceIndex
from pydrake.systems.framework import DiagramBuilder

from ichain_drake.errors import InputError
from ichain_drake.robot.hand import GRIP
from ichain_drake.robot.plant import add_robot_plant
from ichain_drake.robot.pose import hand_pose
from ichain_drake.robot.spec import BodySpec, RobotSpec
from ichain_drake.state import FloatArray

# Where bodies are put that are nowhere [m].
_OPENING = 5  # positions of opening fingers that are looked at
_AWAY = RigidTransform([0.0, 0.0, -50.0])


class CollisionScene:
    """Distances between arm, gripper and what is held on one side, and everything else on the other.

    Fixed bodies stand where they are declared. A free body is at the hand, where it was put down, or nowhere. A fixed
    body with a joint (a door) is as far open as the hand left it, and no obstacle while it is held: it gives way.

    Args:
        spec: the robot with its scenery.
        bodies: declared bodies, by object name.
        in_hand: pose of a body's moving link in the hand's frame while it is held, by object name.
        held: name of the held body, if any; without an entry in `in_hand` nothing goes along.

    Raises:
        InputError: if models or names don't fit, or a body in `in_hand` can't be moved by its one joint.
    """

    def __init__(
        self,
        spec: RobotSpec,
        bodies: Mapping[str, BodySpec],
        in_hand: Mapping[str, RigidTransform],
        held: str | None = None,
    ) -> None:
        builder = DiagramBuilder()
        self._robot = add_robot_plant(builder, spec, bodies)
        self._plant: MultibodyPlant = self._robot.plant
        self._in_hand = dict(in_hand)
        self._free = {
            n: self._plant.get_body(self._plant.GetBodyIndices(self._robot.bodies[n])[0])
            for n, body in bodies.items()
            if not body.fixed
        }
        self._doors = {n: self._door(n) for n in self._in_hand if n not in self._free}
        self._closed = {n: joint.default_positions() for n, joint in self._doors.items()}
        self.held = held if held in self._in_hand else None
        self._grasp = self._in_hand.get(self.held or "", RigidTransform())
        self._fingers = self._finger_positions(spec)
        self._exclude()
        diagram = builder.Build()
        self._context = diagram.CreateDefaultContext()
        self._plant_context = self._plant.GetMyMutableContextFromRoot(self._context)
        self._scene_context = self._robot.scene_graph.GetMyContextFromRoot(self._context)
        self._inspector = self._robot.scene_graph.model_inspector()
        for body in self._free.values():
            self._plant.SetFreeBodyPose(self._plant_context, body, _AWAY)

    def place(self, left: Mapping[str, FloatArray], now: FloatArray) -> None:
        """Put free bodies where the hand let go of them; all others are nowhere.

        Args:
            left: full hand state, shape (7,), at which each body was let go of; of what is held, the one in which it
                would be where it is now, had it not slipped in the hand.
            now: full hand state, shape (7,).
        """
        if self.held is not None:
            slip = hand_pose(now).inverse() @ hand_pose(left.get(self.held, now))
            self._grasp = slip @ self._in_hand[self.held]
        for name, body in self._free.items():
            at = left.get(name) if name in self._in_hand else None
            pose = _AWAY if at is None else hand_pose(at) @ self._in_hand[name]
            self._plant.SetFreeBodyPose(self._plant_context, body, pose)
        for name, joint in self._doors.items():
            self._plant.SetPositions(self._plant_context, self._robot.bodies[name], self._closed[name])
            if name in left and name != self.held:
                self._open(name, joint, left[name])

    @property
    def free(self) -> frozenset[str]:
        """Names of the bodies that stand free, but what is held: what the arm would push aside or over."""
        return frozenset(self._free) - {self.held}

    def clearance(
        self, joints: FloatArray, full: FloatArray, margin: float, bodies: Collection[str | None] | None = None
    ) -> float:
        """Least distance [m], negative where bodies overlap; `margin` if everything is farther away.

        Args:
            joints: of the arm, shape (n_joints,).
            full: hand state, shape (7,); what is held goes with it.
            margin: [m].
            bodies: names of those that count; None for all.
        """
        near = self._near(joints, full, margin)
        if bodies is not None:
            near = [pair for pair in near if any(name.partition(".")[0] in bodies for name in pair[1:])]
        return min((d for d, _, _ in near), default=margin)

    def opening_clearance(self, joints: FloatArray, full: FloatArray) -> float:
        """How deep shut fingers would go into something while they open, negative [m]; 0 if into nothing."""
        opened, shut = self._fingers
        ways = (opened + share * (shut - opened) for share in np.linspace(0.0, 1.0, _OPENING))
        return min((d for fingers in ways for d, _, _ in self._near(joints, full, 0.0, fingers)), default=0.0)

    def touching(self, joints: FloatArray, full: FloatArray, margin: float = 0.0) -> tuple[str, ...]:
        """Pairs of bodies nearer to each other than `margin` [m], as "body - body", the nearest first."""
        pairs = sorted(self._near(joints, full, margin))
        return tuple(dict.fromkeys(f"{a} - {b}" for _, a, b in pairs))

    def _near(
        self, joints: FloatArray, full: FloatArray, margin: float, fingers: FloatArray | None = None
    ) -> list[tuple[float, str, str]]:
        plant, context = self._plant, self._plant_context
        plant.SetPositions(context, self._robot.arm, joints)
        if self._robot.gripper is not None:
            # Around something the fingers are not shut; how far is not known, so they count as open.
            shut = full[GRIP] > 0.5 and self.held is None  # noqa: PLR2004 - a flag
            plant.SetPositions(context, self._robot.gripper, self._fingers[int(shut)] if fingers is None else fingers)
        if self.held in self._free:
            plant.SetFreeBodyPose(context, self._free[self.held], hand_pose(full) @ self._grasp)
        query: QueryObject = self._robot.scene_graph.get_query_output_port().Eval(self._scene_context)
        pairs = query.ComputeSignedDistancePairwiseClosestPoints(margin)
        return [(float(p.distance), self._name(p.id_A), self._name(p.id_B)) for p in pairs if p.distance < margin]

    def _name(self, geometry: object) -> str:
        body = self._plant.GetBodyFromFrameId(self._inspector.GetFrameId(geometry))
        return f"{self._plant.GetModelInstanceName(body.model_instance())}.{body.name()}"

    def _finger_positions(self, spec: RobotSpec) -> FloatArray:
        """Finger joints when open and when shut on nothing, within their limits, shape (2, n)."""
        plant, gripper = self._plant, self._robot.gripper
        if gripper is None:
            return np.zeros((2, 0))
        joints = [plant.get_joint(j) for j in plant.GetJointIndices(gripper)]
        joints = [j for j in joints if j.num_positions()]
        low, high = (np.concatenate(limits) for limits in zip(*map(_limits, joints), strict=True))
        wanted = [[ends.get(j.name(), 0.0) for j in joints] for ends in (spec.gripper_open, spec.gripper_closed)]
        return np.clip(np.array(wanted, dtype=float), low, high)

    def _exclude(self) -> None:
        """Only pairs of one of either side count."""
        plant, robot = self._plant, self._robot
        mine = [b for i in (robot.arm, robot.gripper) if i is not None for b in plant.GetBodyIndices(i)]
        if self.held in self._free:
            mine += plant.GetBodyIndices(robot.bodies[self.held])
        everything = (ModelInstanceIndex(i) for i in range(plant.num_model_instances()))
        others = [plant.get_body(b) for i in everything for b in plant.GetBodyIndices(i) if b not in mine]
        manager = robot.scene_graph.collision_filter_manager()
        for group in ([plant.get_body(b) for b in mine], others):
            manager.Apply(CollisionFilterDeclaration().ExcludeWithin(plant.CollectRegisteredGeometries(group)))
        if self.held in self._doors:
            door = [plant.get_body(b) for b in plant.GetBodyIndices(robot.bodies[self.held])]
            everything = plant.CollectRegisteredGeometries([plant.get_body(b) for b in mine])
            own = plant.CollectRegisteredGeometries(door)
            manager.Apply(CollisionFilterDeclaration().ExcludeBetween(own, everything))

    def _door(self, name: str) -> Joint:
        instance = self._robot.bodies[name]
        joints = [self._plant.get_joint(j) for j in self._plant.GetJointIndices(instance)]
        moving = [j for j in joints if j.num_positions()]
        if len(moving) != 1 or moving[0].num_positions() != 1:
            raise InputError(f"in_hand: {name} is fixed and has {len(moving)} joints; only one that moves can be held")
        return moving[0]

    def _open(self, name: str, joint: Joint, full: FloatArray) -> None:
        """Move a joint to where what the hand holds of its link is nearest to the hand, by interval search."""
        grasped, hand = self._in_hand[name].inverse().translation(), hand_pose(full).translation()
        plant, context, instance = self._plant, self._plant_context, self._robot.bodies[name]
        low, high = (float(v) for (v,) in _limits(joint))
        low, high = max(low, -math.pi), min(high, math.pi)

        def miss(position: float) -> float:
            plant.SetPositions(context, instance, [position])
            return float(np.linalg.norm(joint.child_body().EvalPoseInWorld(context) @ grasped - hand))

        for _ in range(8):
            grid = np.linspace(low, high, 9)
            best, width = min(grid, key=miss), (high - low) / 8
            low, high = max(low, best - width), min(high, best + width)
        plant.SetPositions(context, instance, [best])


def _limits(joint: Joint) -> tuple[FloatArray, FloatArray]:
    return joint.position_lower_limits(), joint.position_upper_limits()
