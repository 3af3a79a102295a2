"""What an episode logs, a row a frame: the states as it runs; what the sensors made of them, when somebody asks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from pydrake.systems.framework import Context, DiagramBuilder, OutputPort, System
from pydrake.systems.primitives import LogVectorOutput, Multiplexer

from ichain_drake.objects.base import WorldObject
from ichain_drake.robot.arm import ArmRobot
from ichain_drake.robot.ideal import IdealHand
from ichain_drake.state import FloatArray
from ichain_drake.timing import FRAME
from ichain_drake.world.world import World

DOING = ("progress", "wanted", "mode", "edge", "skill", "plan_step")
"""Ports of commanders that are logged where there are any: what they are doing."""


@dataclass(frozen=True)
class _Derived:
    """Rows that follow from others of the same frames."""

    of: tuple[str, ...]
    make: Callable[[Sequence[int], Sequence[FloatArray]], FloatArray]


class FrameLog:
    """Logs the hand command, and every port `state`, `measured` and `active` of a world, in a diagram to be.

    Each call into Python between two steps of a plant costs, and the ports of sensors are such calls. So what follows
    from states and the number of the frame, which are logged in C++ alone, is made of them afterwards, to the last bit.
    One sink has it all: each of its own would cost something on every step.

    Args:
        builder: has world and commander.
        world: the world.
        commander: see `wire`; what it says of its doing is logged too.
    """

    def __init__(self, builder: DiagramBuilder, world: World, commander: System) -> None:
        self._derived: dict[str, _Derived] = {}
        self._made: dict[str, tuple[list[FloatArray], FloatArray]] = {}
        ports: dict[str, OutputPort] = {"command": commander.GetOutputPort("hand_command")}
        several = [f"{name}.setpoint" for name in world.graph.roots]
        for key in ("setpoint", "plant_positions", *several):
            if world.HasOutputPort(key):
                ports[key] = world.GetOutputPort(key)
        for name in world.graph.objects:
            self._derive(name, world.system(name), own=len(world.graph.roots) > 1)
            for port in ("state", "measured", "active"):
                key = f"{name}.{port}"
                if world.HasOutputPort(key) and key not in self._derived:
                    ports[key] = world.GetOutputPort(key)
        for key in DOING:
            if commander.HasOutputPort(key):
                ports[key] = commander.GetOutputPort(key)
        logged = {key: port for key, port in ports.items() if port.size()}
        joined = builder.AddSystem(Multiplexer([port.size() for port in logged.values()]))
        self._places: dict[str, slice] = {}
        end = 0
        for i, (key, port) in enumerate(logged.items()):
            builder.Connect(port, joined.get_input_port(i))
            self._places[key], end = slice(end, end + port.size()), end + port.size()
        self._sink = LogVectorOutput(joined.get_output_port(), builder, FRAME)

    def _derive(self, name: str, system: System, *, own: bool) -> None:
        """Note what follows from what is logged; `own`: of several robots each has its own set-point."""
        state, measured = f"{name}.state", f"{name}.measured"
        if isinstance(system, WorldObject) and not system.settings.dropouts:
            self._derived[measured] = _Derived((state,), lambda frames, of: system.readings(of[0], frames))
        elif isinstance(system, (ArmRobot, IdealHand)):
            target = f"{name}.setpoint" if own else "setpoint"
            places = (target, "plant_positions") if isinstance(system, ArmRobot) else (target,)
            self._derived[state] = _Derived(places, lambda _, of: system.states(*of))
            sensor = system.measurement
            self._derived[measured] = _Derived((state,), lambda frames, of: sensor.readings(of[0], frames))

    def rows(self, context: Context, key: str, last: int) -> FloatArray:
        """The last rows, as many as there are, of one port: `<object>.state` and the like, shape (n, size)."""
        found = self._sink.FindLog(context)
        return self._rows(key, found.sample_times()[-last:], found.data()[:, -last:])

    def all_rows(self, context: Context) -> tuple[FloatArray, dict[str, FloatArray]]:
        """Times [s], shape (n,), and rows by port, shape (n, size) each, of what has been logged so far."""
        found = self._sink.FindLog(context)
        times, data = np.array(found.sample_times()), found.data()
        rows = {key: data[place].T.copy() for key, place in self._places.items()}
        for key in self._derived:
            rows[key] = self._remembered(key, times, [rows[k] for k in self._derived[key].of])
        return times, rows

    def _rows(self, key: str, times: FloatArray, data: FloatArray) -> FloatArray:
        if key in self._places:
            return data[self._places[key]].T.copy()
        derived = self._derived[key]
        return derived.make(_frames(times), [self._rows(k, times, data) for k in derived.of])

    def _remembered(self, key: str, times: FloatArray, of: list[FloatArray]) -> FloatArray:
        """Derived rows; those of what was there when it was asked last are not made again."""
        before, rows = self._made.get(key, ([], np.zeros((0, 0))))
        done = len(rows) if all(np.array_equal(a, b[: len(a)]) for a, b in zip(before, of, strict=False)) else 0
        added = self._derived[key].make(_frames(times[done:]), [part[done:] for part in of])
        rows = np.concatenate([rows[:done], added]) if done else added
        self._made[key] = (of, rows)
        return rows.copy()


def _frames(times: FloatArray) -> list[int]:
    return np.rint(np.asarray(times) / FRAME).astype(int).tolist()
