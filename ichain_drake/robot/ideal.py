"""The `ideal` physics: the hand is a point that is where its set-point is."""

from __future__ import annotations

from numpy.typing import ArrayLike
from pydrake.systems.framework import BasicVector, Context, Diagram, DiagramBuilder, LeafSystem

from ichain_drake.robot.hand import HAND, HandSpec
from ichain_drake.robot.measurement import HandMeasurement
from ichain_drake.robot.motion import HandMotion
from ichain_drake.state import FloatArray, StateSpace


class _Exposed(LeafSystem):
    """Picks the exposed variables out of the full hand state."""

    def __init__(self, spec: HandSpec) -> None:
        super().__init__()
        self._spec = spec
        self._full = self.DeclareVectorInputPort("setpoint", len(HAND))
        self.DeclareVectorOutputPort("state", len(spec.space), self._calc, {self._full.ticket()})

    def _calc(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._spec.reduce(self._full.Eval(context)))


class IdealHand(Diagram):
    """A hand without an arm.

    Ports: input `hand_command` (n_exposed); outputs `state` (n_exposed, no feedthrough), `measured` (n_exposed),
    `valid` (1), `setpoint` (7).

    Args:
        spec: which variables of the hand are exposed.
        home: full hand state at start, shape (7,).
        seed: the run's seed.
        object_id: the robot object's number, which keys its noise.
        linear_speed: of the set-point [m/s].
        angular_speed: of the set-point [rad/s].
    """

    def __init__(  # noqa: PLR0913
        self,
        spec: HandSpec,
        home: ArrayLike,
        seed: int = 0,
        object_id: int = 0,
        *,
        linear_speed: float = 0.4,
        angular_speed: float = 2.0,
    ) -> None:
        super().__init__()
        self.spec = spec
        builder = DiagramBuilder()
        self.motion = builder.AddNamedSystem("motion", HandMotion(spec, home, linear_speed, angular_speed))
        exposed = builder.AddNamedSystem("exposed", _Exposed(spec))
        self.measurement = builder.AddNamedSystem("measurement", HandMeasurement(spec, seed, object_id))
        builder.Connect(self.motion.GetOutputPort("setpoint"), exposed.get_input_port())
        builder.Connect(exposed.get_output_port(), self.measurement.get_input_port())
        builder.ExportInput(self.motion.GetInputPort("hand_command"), "hand_command")
        builder.ExportOutput(exposed.get_output_port(), "state")
        builder.ExportOutput(self.measurement.GetOutputPort("measured"), "measured")
        builder.ExportOutput(self.measurement.GetOutputPort("valid"), "valid")
        builder.ExportOutput(self.motion.GetOutputPort("setpoint"), "setpoint")
        builder.BuildInto(self)

    @property
    def space(self) -> StateSpace:
        """State space of the robot object."""
        return self.spec.space

    def states(self, setpoints: FloatArray) -> FloatArray:
        """What `state` was, shape (n, n_exposed), from `setpoint` (n, 7) of the time."""
        return self.spec.reduce(setpoints)

    def set_hand(self, root_context: Context, full: ArrayLike) -> None:
        """Put the hand at a full hand state, shape (7,), at rest.

        Args:
            root_context: context of the diagram that holds this one (or of this one).
            full: x, y, z [m], yaw, pitch, roll [rad], grip.

        Raises:
            InputError: on a wrong shape or a value that is not finite.
        """
        value = HAND.check(full, "hand state")
        self.motion.set_hand(self.motion.GetMyMutableContextFromRoot(root_context), value)
        self.measurement.set_hand(self.measurement.GetMyMutableContextFromRoot(root_context))
