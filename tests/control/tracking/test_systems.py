"""Controller and follower as systems: when they decide, what they show, where they read."""

from dataclasses import dataclass, field

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from ichain_drake.control.tracking.path import PathLimits, TimedPath
from ichain_drake.control.tracking.systems import Controller, PathFollower
from ichain_drake.state import StateSpace, Variable
from ichain_drake.timing import FRAME, TICK

ONE = StateSpace("one", (Variable("a"),))
PLANE = StateSpace("plane", (Variable("angle"), Variable("x"), Variable("y")))


@dataclass
class Counting:
    """A policy that answers with its call's number and keeps it in its memory."""

    memory_size: int = 1
    lookahead: int = 2
    seen: list[np.ndarray] = field(default_factory=list)

    def decide(
        self, states: list[np.ndarray], wanted: np.ndarray, memory: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, list[np.ndarray]]:
        self.seen.append(wanted)
        number = memory + 1 if self.memory_size else np.full((1, 1), float(len(self.seen)))
        return number, number[:, : self.memory_size], [states[0] + 1, states[1] + 1]


def run(policy: Counting, frames: int) -> list[float]:
    """Hand commands at the instants of the frames, before their updates."""
    builder = DiagramBuilder()
    controller = builder.AddSystem(Controller(policy, dict.fromkeys("rab", ONE), 1, np.array([-1.0])))  # type: ignore[arg-type]
    for i, name in enumerate("rab"):
        source = builder.AddSystem(ConstantVectorSource([10.0 * i]))
        builder.Connect(source.get_output_port(), controller.GetInputPort(name))
    target = builder.AddSystem(ConstantVectorSource([7.0, 8.0]))
    builder.Connect(target.get_output_port(), controller.GetInputPort("target"))
    simulator = Simulator(builder.Build())
    context = controller.GetMyContextFromRoot(simulator.get_context())
    simulator.Initialize()
    commands = []
    for k in range(frames):
        if k:
            simulator.AdvanceTo(k * FRAME)
        commands.append(controller.GetOutputPort("hand_command").Eval(context)[0])
    assert controller.GetOutputPort("wanted").Eval(context).tolist() == [1.0, 11.0]
    return commands


def test_a_decision_is_taken_at_every_tenth_frame_and_held() -> None:
    """By an integer counter: exact for any number of frames."""
    policy = Counting()
    commands = run(policy, 1001)
    assert commands == [-1.0, *(1.0 + (k - 1) // 10 for k in range(1, 1001))]
    np.testing.assert_array_equal(policy.seen[0], [[[7.0], [8.0]]])


def test_a_policy_without_memory_works_too() -> None:
    assert run(Counting(memory_size=0), 12)[-1] == 2.0


PATH = TimedPath(np.array([[0.0, 0.0], [200.0, 0.0]]), PathLimits(speed=45.0))


def follow(positions: np.ndarray, lookahead: int = 2) -> tuple[np.ndarray, np.ndarray]:
    """Targets before, and progress after the update of each frame, for an object that is moved by hand."""
    follower = PathFollower(PATH, PLANE, (1, 2), lookahead)
    simulator = Simulator(follower)
    context = simulator.get_mutable_context()
    targets, progress = [], []
    for k, position in enumerate(positions):
        follower.GetInputPort("measured").FixValue(context, [99.0, *position])
        targets.append(follower.GetOutputPort("target").Eval(context).reshape(lookahead, 2))
        simulator.AdvanceTo((k + 1) * FRAME)
        progress.append(int(follower.GetOutputPort("progress").Eval(context)[0]))
    return np.array(targets), np.array(progress)


def test_targets_lie_ahead_of_where_the_object_is_now() -> None:
    """From the nearest point of the path, one and two ticks at nominal speed on; off the path makes no difference."""
    positions = np.array([[0, 0], [5, 0], [5, 3], [12, -2.0]])
    targets, _ = follow(positions)
    step = 45.0 * TICK
    np.testing.assert_allclose(targets[:, :, 0], positions[:, :1] + [step, 2 * step], atol=1e-9)
    np.testing.assert_allclose(targets[:, :, 1], 0.0, atol=1e-12)


def test_progress_is_taken_once_a_tick_and_never_goes_back() -> None:
    positions = np.zeros((31, 2))
    positions[:, 0] = np.concatenate([np.linspace(0, 40, 21), np.linspace(38, 0, 10)])
    _, progress = follow(positions)
    assert (np.diff(progress) >= 0).all()
    assert np.flatnonzero(np.diff(progress)).tolist() == [9, 19]
    assert progress[[0, 10, 20, 30]].tolist() == [0, 20, 40, 40]
