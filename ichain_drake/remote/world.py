"""A world that is elsewhere: the ports of `World`, whose values come over a line and whose command goes there."""

from __future__ import annotations

import numpy as np
from pydrake.systems.framework import BasicVector, Context, Diagram, DiagramBuilder, DiscreteValues, LeafSystem, System

from ichain_drake.graph import InteractionGraph
from ichain_drake.remote.link import RobotLink
from ichain_drake.remote.messages import world_names
from ichain_drake.timing import FRAME, FRAMES_PER_TICK
from ichain_drake.world.world import World


class RemoteObject(LeafSystem):
    """What is heard of one object: outputs `state`, `measured`, `valid`, and `active` where something acts on it.

    The values are those of the robot's newest frame, not a function of the context: it can't be cloned or replayed.

    Args:
        name: of the object.
        graph: the interaction graph.
        link: to the robot.
    """

    def __init__(self, name: str, graph: InteractionGraph, link: RobotLink) -> None:
        super().__init__()
        self.set_name(name)
        self._link = link
        at = {n: k for k, n in enumerate(world_names(graph))}
        space = graph.objects[name]
        ports = {
            "measured": [at[f"{name}.{v}"] for v in space.observable.names],
            "state": [at[f"true {name}.{v}"] for v in space.names],
            "active": [at[f"true {p}->{name}"] for p in graph.parents(name)],
        }
        self._valid = at[f"{name} valid"]
        time = {self.time_ticket()}
        for port, places in ports.items():
            if places:
                self.DeclareVectorOutputPort(port, len(places), self._reader(places), time)
        self.DeclareVectorOutputPort("valid", 1, self._calc_valid, time)

    def _reader(self, places: list[int]):  # type: ignore[no-untyped-def] # noqa: ANN202 - Drake's own kind of function
        def calc(context: Context, output: BasicVector) -> None:
            output.SetFromVector(self._link.at(context.get_time())[0][places])

        return calc

    def _calc_valid(self, context: Context, output: BasicVector) -> None:
        values, fresh = self._link.at(context.get_time())
        output.SetAtIndex(0, values[self._valid] if fresh else 0.0)


class RemoteRobot(RemoteObject):
    """The robot: also input `hand_command`, which is sent in each frame, after whoever decides has decided.

    Of several robots it is the first, and sends the commands of all.
    """

    def __init__(self, graph: InteractionGraph, link: RobotLink) -> None:
        super().__init__(graph.roots[0], graph, link)
        self._command = self.DeclareVectorInputPort("hand_command", len(graph.command))
        self.DeclareVectorOutputPort("delay", 1, self._calc_delay, {self.time_ticket()})
        self.DeclarePeriodicDiscreteUpdateEvent(FRAME, 0.0, self._send)

    def _calc_delay(self, context: Context, output: BasicVector) -> None:
        self._link.at(context.get_time())
        output.SetAtIndex(0, self._link.delay / FRAMES_PER_TICK)

    def _send(self, context: Context, discrete: DiscreteValues) -> None:
        self._link.at(context.get_time())
        self._link.command(self._command.Eval(context))


class RemoteWorld(World):
    """A world in another process; see `World` for ports, and `connect`.

    One output more: `delay`, how long after what is measured a command acts [ticks].

    Args:
        graph: the interaction graph.
        link: to the robot.
    """

    def __init__(self, graph: InteractionGraph, link: RobotLink) -> None:
        Diagram.__init__(self)
        self.graph, self.link = graph, link
        self.robot: System = RemoteRobot(graph, link)
        self._others = {n: RemoteObject(n, graph, link) for n in graph.objects if n != graph.roots[0]}
        self.robots = {n: self.system(n) for n in graph.roots}
        self.objects = {}
        builder = DiagramBuilder()
        for name in graph.objects:
            builder.AddNamedSystem(name, self.system(name))
        builder.ExportInput(self.robot.GetInputPort("hand_command"), "hand_command")
        builder.ExportOutput(self.robot.GetOutputPort("delay"), "delay")
        self._export(builder)
        builder.BuildInto(self)
        self.set_name("world")

    def system(self, name: str) -> System:
        """The system of an object or of the robot."""
        return self.robot if name == self.graph.roots[0] else self._others[name]

    def report(self) -> dict[str, float | int]:
        """How the line was: frames that were lost or late, and the time from a command to its echo [ms]."""
        trips = 1000.0 * np.array(self.link.round_trips or [np.nan])
        found: dict[str, float | int] = {"lost_frames": self.link.lost, "lead_frames": self.link.lead}
        if np.isfinite(trips).all():
            found["median_round_trip_ms"] = round(float(np.median(trips)), 3)
            found["p95_round_trip_ms"] = round(float(np.percentile(trips, 95)), 3)
        return found


def connect(address: str, graph: InteractionGraph) -> RemoteWorld:
    """The world that a robot at an address is in.

    Args:
        address: such as `lcm://239.255.76.67:7667`.
        graph: of the scenario, which the robot must have too.

    Raises:
        InputError: on an address that is none, if no robot speaks there, or if it is of another system.
    """
    return RemoteWorld(graph, RobotLink(address, graph))
