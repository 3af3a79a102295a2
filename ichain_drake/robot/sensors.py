"""What the robot reads off its plant: where its hand is, and how hard the gripper presses on each object."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from pydrake.common.value import Value
from pydrake.multibody.plant import ContactResults, MultibodyPlant
from pydrake.multibody.tree import ModelInstanceIndex
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from ichain_drake.robot.hand import GRIP, HAND, PITCH, ROLL, YAW, HandSpec
from ichain_drake.robot.kinematics import ArmKinematics
from ichain_drake.robot.pose import hand_values
from ichain_drake.state import FloatArray

TOUCH_RANGE = 25.0
"""Range of the touch sensor [N]."""


class HandSensor(LeafSystem):
    """The hand's true state by forward kinematics.

    Ports: inputs `arm_state` ([q; v] of the plant), `setpoint` (7: tells equivalent angles apart, and gives the grip);
    output `state` (n_exposed).
    """

    def __init__(self, spec: HandSpec, kinematics: ArmKinematics) -> None:
        super().__init__()
        self._spec, self._kinematics = spec, kinematics
        self._turns = bool(np.isin(spec.indices, (YAW, PITCH, ROLL)).any())
        self._arm = self.DeclareVectorInputPort("arm_state", 2 * kinematics.size)
        self._setpoint = self.DeclareVectorInputPort("setpoint", len(HAND))
        tickets = {self._arm.ticket(), self._setpoint.ticket()}
        self.DeclareVectorOutputPort("state", len(spec.space), self._calc, tickets)

    def _calc(self, context: Context, output: BasicVector) -> None:
        joints = self._arm.Eval(context)[: self._kinematics.size]
        output.SetFromVector(self.state(joints, self._setpoint.Eval(context)))

    def state(self, joints: FloatArray, setpoint: FloatArray) -> FloatArray:
        """The hand's state, shape (n_exposed,), at joint positions (n_joints,) and a set-point (7,)."""
        pose = self._kinematics.pose(joints)
        if self._turns:
            return self._spec.reduce(hand_values(pose, setpoint[GRIP], near=setpoint))
        full = setpoint.copy()  # angles that nobody sees cost most
        full[:3] = pose.translation()
        return self._spec.reduce(full)


class TouchSensor(LeafSystem):
    """Normal force between the gripper and each object, from the plant's contact results.

    As a tactile sensor does, it saturates: each contact point costs some microseconds to read, and a firm grip has ten.

    Ports: input `contact_results`; one output `<object>` (1) each: total normal force [N], at most `TOUCH_RANGE`.
    """

    def __init__(
        self, plant: MultibodyPlant, gripper: ModelInstanceIndex, bodies: Mapping[str, ModelInstanceIndex]
    ) -> None:
        super().__init__()
        self._results = self.DeclareAbstractInputPort("contact_results", Value[ContactResults]())
        self._gripper = {int(b) for b in plant.GetBodyIndices(gripper)}
        tickets = {self._results.ticket()}
        for name, instance in bodies.items():
            links = {int(b) for b in plant.GetBodyIndices(instance)}
            self.DeclareVectorOutputPort(name, 1, self._force_of(links), tickets)

    def _force_of(self, links: set[int]) -> Callable[[Context, BasicVector], None]:
        pairs = {(a, b) for a in self._gripper for b in links} | {(b, a) for a in self._gripper for b in links}

        def calc(context: Context, output: BasicVector) -> None:
            results = self._results.Eval(context)
            infos = map(results.point_pair_contact_info, range(results.num_point_pair_contacts()))
            total = 0.0
            for info in infos:
                if (int(info.bodyA_index()), int(info.bodyB_index())) in pairs:
                    total += abs(info.contact_force().dot(info.point_pair().nhat_BA_W))
                    if total > TOUCH_RANGE:
                        break
            output[0] = min(total, TOUCH_RANGE)

        return calc
