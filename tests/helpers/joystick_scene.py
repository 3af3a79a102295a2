"""The joystick in the arm's grip, for tests."""

from __future__ import annotations

import numpy as np
from pydrake.common.schema import Transform
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, DiagramBuilder, LeafSystem, State

from ichain_drake.robot import BodySpec, HandSpec, Physics, RobotSpec, SphereSurface, build_robot
from ichain_drake.state import FloatArray
from ichain_drake.timing import FRAME, FRAMES_PER_TICK

PIVOT = (0.5, 0.0, 0.05)
HANDLE = 0.10
STICK = BodySpec("package://ichain_drake_models/joystick/joystick.sdf", Transform(translation=[0.5, 0.0, 0.0]))


def joystick_spec(exposed: tuple[str, ...] = ("x", "y"), **kwargs: object) -> RobotSpec:
    """Hand on the knob's sphere, pointing down; closed unless grip is exposed."""
    held = {} if "grip" in exposed else {"grip": 1.0}
    hand = HandSpec(list(exposed), held, SphereSurface(list(PIVOT), HANDLE), {"x": [0.4, 0.6], "y": [-0.1, 0.1]})
    return RobotSpec(hand=hand, home={"x": 0.5, "y": 0.0, "grip": 1.0}, **kwargs)


def tilt_targets(count: int, seed: int, limit_deg: float = 25.0, step_deg: float = 15.0) -> FloatArray:
    """A random walk of tilts from 0, each axis within the limit, shape (count, 2) [rad]."""
    generator = np.random.default_rng(seed)
    out = [np.zeros(2)]
    while len(out) < count:
        new = out[-1] + generator.uniform(-step_deg, step_deg, 2)
        if np.abs(new).max() <= limit_deg:
            out.append(new)
    return np.radians(np.array(out))


def knob_position(tilt: FloatArray) -> FloatArray:
    """x, y of the knob's centre [m] at tilts of shape (..., 2) [rad]."""
    a, b = tilt[..., 0], tilt[..., 1]
    x = PIVOT[0] + HANDLE * np.sin(a) * np.cos(b)
    return np.stack([x, PIVOT[1] + HANDLE * np.sin(b)], axis=-1)


def knob_commands(count: int, seed: int) -> FloatArray:
    """Hand commands of a random walk of tilts, shape (count, 2) [m]."""
    return knob_position(tilt_targets(count, seed))


class Commands(LeafSystem):
    """A controller that stores row k of a table at tick k, as a real one does: by an unrestricted update."""

    def __init__(self, table: FloatArray) -> None:
        super().__init__()
        self.table = np.atleast_2d(table)
        command = self.DeclareDiscreteState(self.table[0])
        frame = self.DeclareDiscreteState(1)
        self.DeclareStateOutputPort("hand_command", command)

        def update(context: Context, state: State) -> None:
            k = int(context.get_discrete_state(frame).value()[0])
            discrete = state.get_mutable_discrete_state()
            if k % FRAMES_PER_TICK == 0:
                row = min(k // FRAMES_PER_TICK, len(self.table) - 1)
                discrete.set_value(command, self.table[row])
            discrete.set_value(frame, [k + 1.0])

        self.DeclarePeriodicUnrestrictedUpdateEvent(FRAME, 0.0, update)


class Runner:
    """A robot, a table of commands, and the simulator around them."""

    def __init__(  # noqa: PLR0913 -- a scene has that many parts
        self,
        spec: RobotSpec,
        table: FloatArray,
        physics: Physics = "contact",
        bodies: dict[str, BodySpec] | None = None,
        *,
        seed: int = 0,
        start: FloatArray | None = None,
    ) -> None:
        self.robot = build_robot(spec, physics, bodies, seed, object_id=3)
        builder = DiagramBuilder()
        builder.AddSystem(self.robot)
        commands = builder.AddSystem(Commands(table))
        builder.Connect(commands.get_output_port(), self.robot.GetInputPort("hand_command"))
        self.diagram = builder.Build()
        self.simulator = Simulator(self.diagram)
        self.root = self.simulator.get_mutable_context()
        self.robot.set_hand(self.root, spec.home_hand() if start is None else start)
        self.context = self.robot.GetMyContextFromRoot(self.root)

    def frame(self, k: int) -> None:
        """Advance to frame k."""
        self.simulator.AdvanceTo(k * FRAME)

    def read(self, port: str) -> FloatArray:
        """The value of an output port of the robot now."""
        return np.array(self.robot.GetOutputPort(port).Eval(self.context))
