"""What the robot reads off its plant: where its hand is, and how hard the gripper presses on each object."""

from __future__ import annotations

from collections.abc import Mapping

from pydrake.common.value import Value
from pydrake.multibody.plant import ContactResults, MultibodyPlant
from pydrake.multibody.tree import ModelInstanceIndex
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from ichain_drake.robot.hand import GRIP, HAND, HandSpec
from ichain_drake.robot.kinematics import ArmKinematics
from ichain_drake.robot.pose import hand_values


class HandSensor(LeafSystem):
    """The hand's true state by forward kinematics.

    Ports: inputs `arm_state` ([q; v] of the plant), `setpoint` (7: tells equivalent angles apart, and gives the grip);
    output `state` (n_exposed).
    """

    def __init__(self, spec: HandSpec, kinematics: ArmKinematics) -> None:
        super().__init__()
        self._spec, self._kinematics = spec, kinematics
        self._arm = self.DeclareVectorInputPort("arm_state", 2 * kinematics.size)
        self._setpoint = self.DeclareVectorInputPort("setpoint", len(HAND))
        tickets = {self._arm.ticket(), self._setpoint.ticket()}
        self.DeclareVectorOutputPort("state", len(spec.space), self._calc, tickets)

    def _calc(self, context: Context, output: BasicVector) -> None:
        setpoint = self._setpoint.Eval(context)
        pose = self._kinematics.pose(self._arm.Eval(context)[: self._kinematics.size])
        output.SetFromVector(self._spec.reduce(hand_values(pose, setpoint[GRIP], near=setpoint)))


class TouchSensor(LeafSystem):
    """Normal force between the gripper and each object, from the plant's contact results.

    Ports: input `contact_results`; one output `<object>` (1) each: total normal force [N].
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

    def _force_of(self, links: set[int]):  # noqa: ANN202
        def calc(context: Context, output: BasicVector) -> None:
            results = self._results.Eval(context)
            total = 0.0
            for i in range(results.num_point_pair_contacts()):
                info = results.point_pair_contact_info(i)
                a, b = int(info.bodyA_index()), int(info.bodyB_index())
                if (a in self._gripper and b in links) or (b in self._gripper and a in links):
                    total += abs(float(info.contact_force() @ info.point_pair().nhat_BA_W))
            output.SetFromVector([total])

        return calc
