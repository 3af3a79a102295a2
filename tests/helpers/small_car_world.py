"""Worlds for the tests: a commander at 3 Hz, an ideal hand, and logs of every frame."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, DiagramBuilder, LeafSystem, State

from ichain_drake.graph import InteractionGraph
from ichain_drake.objects import Car, Joystick, JoystickMount, ObjectSettings, WorldObject
from ichain_drake.robot import HandSpec, IdealHand
from ichain_drake.timing import FRAME, FRAMES_PER_TICK
from ichain_drake.world import World

MOUNT = JoystickMount((0.5, 0.0, 0.05))
HOME = np.array([0.5, 0.0, 0.15])


def hand_spec() -> HandSpec:
    return HandSpec(["x", "y"], {"z": HOME[2], "grip": 1.0})


def random_commands(ticks: int, seed: int = 0) -> np.ndarray:
    """Near enough to each other to be reached in four frames, shape (ticks, 2)."""
    return HOME[:2] + np.random.default_rng(seed).uniform(-0.018, 0.018, (ticks, 2))


def hand_frames(hand: np.ndarray, command: np.ndarray) -> np.ndarray:
    """Straight to the command in 4 frames, then there."""
    part = np.minimum(np.arange(1, FRAMES_PER_TICK + 1) / 4, 1.0).reshape(-1, *[1] * hand.ndim)
    return np.where(part < 1.0, hand + part * (command - hand), command)


class Commands(LeafSystem):
    """Decides on a command at each tick, in an unrestricted update as a controller does."""

    def __init__(self, commands: np.ndarray) -> None:
        super().__init__()
        self.set_name("commands")
        self._commands = commands
        self._command = self.DeclareDiscreteState(np.full(commands.shape[1], np.nan))
        self._frame = self.DeclareDiscreteState(1)
        self.DeclareStateOutputPort("hand_command", self._command)
        self.DeclarePeriodicUnrestrictedUpdateEvent(FRAME, 0.0, self._decide)

    def _decide(self, context: Context, state: State) -> None:
        frame = int(context.get_discrete_state(self._frame).value()[0])
        discrete = state.get_mutable_discrete_state()
        discrete.set_value(self._frame, [frame + 1])
        if frame % FRAMES_PER_TICK == 0:
            discrete.set_value(self._command, self._commands[frame // FRAMES_PER_TICK])


class Rig:
    """A world under commands; `step` advances by frames and keeps what ports show at each."""

    def __init__(self, world: World, commands: np.ndarray, first: str = "world") -> None:
        self.world = world
        builder = DiagramBuilder()
        systems = [world, Commands(commands)]
        for system in systems if first == "world" else reversed(systems):
            builder.AddSystem(system)
        builder.Connect(systems[1].GetOutputPort("hand_command"), world.GetInputPort("hand_command"))
        self.diagram = builder.Build()
        self.simulator = Simulator(self.diagram)
        self.context = self.simulator.get_mutable_context()
        self.simulator.Initialize()
        self.frame = 0

    def read(self, port: str, context: Context | None = None) -> np.ndarray:
        """The value of an exported port, such as `car.state`."""
        inside = self.world.GetMyContextFromRoot(context or self.context)
        return self.world.GetOutputPort(port).Eval(inside).copy()

    def step(self, frames: int, ports: Sequence[str] = ()) -> dict[str, np.ndarray]:
        """Rows of ports at the instants of `frames` frames from now on, before their updates; then one row more."""
        rows: dict[str, list[np.ndarray]] = {p: [self.read(p)] for p in ports}
        for _ in range(frames):
            self.frame += 1
            self.simulator.AdvanceTo(self.frame * FRAME)
            for port in ports:
                rows[port].append(self.read(port))
        return {p: np.array(r) for p, r in rows.items()}


def car_world(
    names: tuple[str, str, str] = ("hand", "stick", "car"),
    order: Callable[[list[str]], list[str]] = list,
    seed: int = 3,
    settings: Mapping[str, ObjectSettings] | None = None,
) -> World:
    """Hand -> joystick -> car with noise, under any names and in any declared order; ids stay with the objects."""
    hand, stick, car = names
    spec = hand_spec()
    spaces = {hand: spec.space, stick: Joystick.state_space, car: Car.state_space}
    graph = InteractionGraph({n: spaces[n] for n in order(list(names))}, order([f"{hand}->{stick}", f"{stick}->{car}"]))
    made: dict[str, WorldObject] = {
        stick: Joystick(stick, {hand: spec.space}, MOUNT, settings=ObjectSettings(1, seed)),
        car: Car(car, {stick: Joystick.state_space}, settings=(settings or {}).get("car", ObjectSettings(2, seed))),
    }
    return World(graph, IdealHand(spec, spec.full(HOME[:2]), seed), {n: made[n] for n in order([stick, car])})
