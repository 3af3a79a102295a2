"""KinDER's StickButton2D: a robot, a stick that it can take, and buttons that either presses by touching them.

Given: which object acts on which, kinds and roles of variables, where the base can drive, one action a variable of the
robot, and labels of touching and holding. Not given: where a stick can be taken, what presses, that it stays pressed,
or any shape. The room's walls and the table, over which the base can't go, are not seen.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ichain_drake.scenarios.environment_scenario import EnvironmentScenario
from ichain_drake.scenarios.graph_scenario import GraphConfig
from ichain_drake.scenarios.scripted_piece import ScriptedPiece
from ichain_drake.state import FloatArray, StateSpace, Variable
from ichain_drake.systems.kinder.demonstrations import script_pieces
from ichain_drake.systems.kinder.opening import (
    ObjectState,
    holds,
    open_kinder,
    place,
    robot_space,
    touches,
    turn,
    values_of,
)
from ichain_drake.world.environment_spec import EnvironmentSpec, RootTerm

ROBOT, STICK = "robot", "stick"
LOW, HIGH = (0.105, 0.105), (3.395, 1.145)
"""Corners of where the base can be [m]: 5 mm from the room's walls and from the table."""

_FEATURES = {
    ROBOT: ("x", "y", "theta", "arm_joint", "vacuum"),
    STICK: ("x", "y", "theta"),
    "": ("x", "y", "pressed"),  # of a button
}


@dataclass
class StickButtonConfig(GraphConfig):
    """Configuration; see `GraphConfig`."""


class StickButton2D(EnvironmentScenario):
    """See the module's description and `GraphScenario`; a subclass says how many buttons there are."""

    name: ClassVar[str] = "kinder/StickButton2D-b1"
    config_class = StickButtonConfig
    buttons: ClassVar[int] = 1

    def environment(self) -> EnvironmentSpec:
        """The benchmark's own, which goes on after its last button is pressed."""
        name = self.name.rpartition("/")[2]
        names = self._buttons()
        button = StateSpace("button", (*place(), Variable("pressed", "1", 0, 1, kind="binary")))
        edges = [(ROBOT, STICK), *((parent, b) for b in names for parent in (STICK, ROBOT))]
        objects = {ROBOT: robot_space(LOW, HIGH), STICK: StateSpace("stick", (*place(), turn()))}
        return EnvironmentSpec(
            make=lambda: open_kinder(name),
            objects=objects | dict.fromkeys(names, button),
            interactions=[f"{parent}->{child}" for parent, child in edges],
            actions=(*(RootTerm(v) for v in ("x", "y", "theta", "arm")), RootTerm("vacuum", relative=False)),
            read=self._read,
            active=lambda env: {f"{p}->{c}": holds(env, p, c) if c == STICK else touches(env, p, c) for p, c in edges},
            snapshot=ObjectState(),
        )

    def _buttons(self) -> list[str]:
        return [f"button{k}" for k in range(self.buttons)]

    def _read(self, env: Any) -> Mapping[str, FloatArray]:
        return {n: values_of(env, n, _FEATURES.get(n, _FEATURES[""])) for n in (ROBOT, STICK, *self._buttons())}

    def script(self, rng: np.random.Generator) -> Iterable[ScriptedPiece[int]]:
        """Short pieces: the stick is taken, brought to a button and let go; the robot drives over a button."""
        return script_pieces(rng, lambda: self.draw_start(rng), self.start_states, LOW, HIGH)


def _variant(count: int) -> type[StickButton2D]:
    name = f"kinder/StickButton2D-b{count}"
    return type(f"StickButton2DB{count}", (StickButton2D,), {"name": name, "buttons": count, "__module__": __name__})


STICK_BUTTONS = {kind.name: kind for kind in (_variant(n) for n in (1, 3, 5, 10))}
"""The variants, by name."""
