"""From a graph and its objects to a Drake Diagram with the same nodes and edges."""

from __future__ import annotations

from collections.abc import Mapping

from pydrake.systems.framework import Diagram, DiagramBuilder, System
from pydrake.systems.primitives import Demultiplexer

from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.objects.base import WorldObject


class World(Diagram):
    """The world of a scenario: the robot and the objects, wired along the interactions.

    Systems carry the objects' names, and every interaction is one connection from the parent's `state` to the child's
    input port of the parent's name. An object with a body is also connected to the robot's plant.

    Ports: input `hand_command`, of several robots one after the other (`InteractionGraph.command`); outputs
    `<object>.state`, `<object>.measured`, `<object>.valid` for every object and the robot, `<object>.active` for every
    object; of a hand also `setpoint`, where it is to be, of several `<robot>.setpoint`; of a robot with a plant also
    `plant_positions`, and `query`, which a visualizer takes.

    Args:
        graph: the interaction graph.
        robot: the system at the root: ports `hand_command`, `state`, `measured`, `valid`, and `<object>_body`,
            `<object>_touch` for every object that has a body. Where the graph has several robots, those of all of them,
            by name; none of them has bodies.
        objects: the other systems, by name.

    Attributes:
        robots: the systems at the roots, by name.
        robot: the first of them.

    Raises:
        InputError: if robots or objects don't fit the graph; names the object and what differs.
    """

    def __init__(
        self, graph: InteractionGraph, robot: System | Mapping[str, System], objects: Mapping[str, WorldObject]
    ) -> None:
        super().__init__()
        self.graph = graph
        self.robots = dict(robot) if isinstance(robot, Mapping) else {graph.roots[0]: robot}
        self.objects = dict(objects)
        _check_robots(graph, self.robots)
        _check_fit(graph, self.objects)
        self.robot = robot = self.robots[graph.roots[0]]

        builder = DiagramBuilder()
        for name, system in self.robots.items():
            builder.AddNamedSystem(name, system)
        for name in graph.objects:
            if name not in self.robots:
                builder.AddNamedSystem(name, self.objects[name])
        for edge in graph.interactions:
            builder.Connect(
                self.system(edge.parent).GetOutputPort("state"), self.objects[edge.child].GetInputPort(edge.parent)
            )
        for name, system in self.objects.items():
            if system.settings.body_size:
                builder.Connect(robot.GetOutputPort(f"{name}_body"), system.GetInputPort("body"))
                builder.Connect(robot.GetOutputPort(f"{name}_touch"), system.GetInputPort("touch"))
        if len(self.robots) > 1:
            self._share_command(builder)
        elif robot.HasInputPort("hand_command"):
            builder.ExportInput(robot.GetInputPort("hand_command"), "hand_command")
        self._export(builder)
        ports = ("setpoint", "plant_positions", "query")
        for name, system in self.robots.items():
            for port in [p for p in ports if system.HasOutputPort(p)]:
                shown = port if len(self.robots) == 1 else f"{name}.{port}"
                builder.ExportOutput(system.GetOutputPort(port), shown)
        builder.BuildInto(self)
        self.set_name("world")

    def _share_command(self, builder: DiagramBuilder) -> None:
        """Each robot's part of the one command."""
        ports = [self.robots[name].GetInputPort("hand_command") for name in self.graph.roots]
        parts = builder.AddNamedSystem("commands", Demultiplexer([port.size() for port in ports]))
        builder.ExportInput(parts.get_input_port(), "hand_command")
        for k, port in enumerate(ports):
            builder.Connect(parts.get_output_port(k), port)

    def _export(self, builder: DiagramBuilder) -> None:
        """Ports of all systems as the world's own."""
        for name in self.graph.objects:
            for port in ("state", "measured", "valid", "active"):
                if self.system(name).HasOutputPort(port):
                    builder.ExportOutput(self.system(name).GetOutputPort(port), f"{name}.{port}")

    def system(self, name: str) -> System:
        """The system of an object or of a robot.

        Raises:
            InputError: if there is none of that name.
        """
        if name in self.robots:
            return self.robots[name]
        if name not in self.objects:
            raise InputError(f"the world has no object {name!r}; it has {', '.join(self.graph.objects)}")
        return self.objects[name]


def _check_robots(graph: InteractionGraph, robots: Mapping[str, System]) -> None:
    if set(robots) != set(graph.roots):
        raise InputError(f"the graph's robots are {', '.join(graph.roots)}; given are {', '.join(robots) or 'none'}")
    for name, robot in robots.items():
        space = graph.objects[name]
        for port, size in (("state", len(space)), ("measured", len(space.observable))):
            if robot.GetOutputPort(port).size() != size:
                raise InputError(
                    f"robot {name}: its port {port} has {robot.GetOutputPort(port).size()} values, the graph "
                    f"declares {size}"
                )


def _check_fit(graph: InteractionGraph, objects: Mapping[str, WorldObject]) -> None:
    wanted = [n for n in graph.objects if n not in graph.roots]
    missing, extra = set(wanted) - set(objects), set(objects) - set(wanted)
    if missing or extra:
        raise InputError(f"objects and graph differ: {', '.join(sorted(missing | extra))} is in only one of them")
    keys: dict[int, str] = {}
    for name, system in objects.items():
        number = system.settings.object_id
        if number in keys:
            raise InputError(
                f"objects {keys[number]} and {name} both have object_id {number}, so their noise would be the same; "
                "give each a number of its own in its ObjectSettings"
            )
        keys[number] = name
    for name, system in objects.items():
        if system.get_name() != name:
            raise InputError(f"object {name} is a system named {system.get_name()!r}; give it the object's name")
        if graph.objects[name] != system.state_space:
            raise InputError(f"object {name}: the graph declares another state space than {type(system).__name__}'s")
        if tuple(system.parents) != graph.parents(name):
            raise InputError(
                f"object {name} was built for parents {list(system.parents)}, the graph has {list(graph.parents(name))}"
            )
        for parent, space in system.parents.items():
            if space != graph.objects[parent]:
                raise InputError(f"object {name}: it expects another state space of its parent {parent}")
