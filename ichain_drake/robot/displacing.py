"""Somebody else displaces a body of the plant while the hand is away: a fault, no part of the robot."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.common.value import Value
from pydrake.math import RotationMatrix
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import ExternallyAppliedSpatialForce, MultibodyPlant
from pydrake.multibody.tree import ModelInstanceIndex, RigidBody
from pydrake.systems.framework import Context, DiscreteStateIndex, DiscreteValues, InputPort, LeafSystem

from ichain_drake.errors import InputError
from ichain_drake.robot.hand import HAND
from ichain_drake.state import FloatArray
from ichain_drake.timing import FRAME

_LIFT = 0.03  # m; over edges of what it stands on
_UP, _ACROSS = 0.3, 0.6  # s
_DOWN = 0.1  # m/s, until it stands
_STANDS = 0.01  # m above where it should be: more than it lags behind on its way down
_LONGEST = 4.0  # s
_STIFFNESS = 25.0  # 1/s; a critically damped spring, slow against the plant's step
_TOUCHED, _STILL = 1e-3, 0.02  # N, m/s
_BEGUN, _START = 1, slice(2, 9)  # the state of one body: how many are done, when the present one began, from where


@dataclass(frozen=True)
class Displacement:
    """When a body that stands free is displaced, and by how much.

    Attributes:
        time: earliest [s].
        x, y: by how much, in the robot's frame [m]; to the other side along y where it would come to be spared.
        away: how far the hand is from it then, at least [m].
        spared: says of a place in the robot's frame [m], shape (3,), whether nobody gets at it there.
    """

    time: float
    x: float
    y: float
    away: float = 0.0
    spared: Callable[[FloatArray], bool] = lambda place: False

    def aside(self, place: FloatArray) -> FloatArray | None:
        """By how much it is displaced from a place [m], shape (2,); None where it is left alone.

        Args:
            place: in the robot's frame [m], shape (3,).
        """
        ways = (np.array([self.x, y]) for y in (self.y, -self.y))
        free = (way for way in ways if not self.spared(place + [*way, 0.0]))
        return None if self.spared(place) else next(free, None)


class BodyDisplacer(LeafSystem):
    """Lifts free bodies a little, brings them aside upright, and sets them down, by a force on each of them alone.

    It begins when it is due, the gripper does not touch the body, the body is at rest and the hand is far enough.

    Ports: inputs `setpoint` (7) of the hand, of each body `<body>` ([q; v]) and `<body>_touch` (1); output `forces`
    for the plant's applied spatial forces.

    Args:
        plant: has the bodies.
        bodies: model instance of each, by name.
        displacements: of each, in the order of time.

    Raises:
        InputError: on a body that is not there, or is not free.
    """

    def __init__(
        self,
        plant: MultibodyPlant,
        bodies: Mapping[str, ModelInstanceIndex],
        displacements: Mapping[str, tuple[Displacement, ...]],
    ) -> None:
        super().__init__()
        self._setpoint = self.DeclareVectorInputPort("setpoint", len(HAND))
        self._gravity = float(np.linalg.norm(plant.gravity_field().gravity_vector()))
        self._bodies: list[_FreeBody] = []
        for name, moves in displacements.items():
            if name not in bodies:
                raise InputError(f"displacements: there is no body {name!r}; there are {', '.join(bodies) or 'none'}")
            body = plant.get_body(plant.GetBodyIndices(bodies[name])[0])
            if not body.is_floating_base_body():
                raise InputError(f"displacements: {name} is fixed; only what stands free can be displaced")
            ports = self.DeclareVectorInputPort(name, 13), self.DeclareVectorInputPort(f"{name}_touch", 1)
            index = self.DeclareDiscreteState(np.array([0.0, -1.0, 1.0, *[0.0] * 6]))
            self._bodies.append(_FreeBody(body, tuple(sorted(moves, key=lambda m: m.time)), ports, index))
        self.DeclarePeriodicDiscreteUpdateEvent(FRAME, 0.0, self._update)
        # Not on touch, which depends on these forces itself.
        tickets = {self.xd_ticket(), self.time_ticket(), *(one.ports[0].ticket() for one in self._bodies)}
        self.DeclareAbstractOutputPort("forces", lambda: Value([ExternallyAppliedSpatialForce()]), self._calc, tickets)

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        now = context.get_time()
        for one in self._bodies:
            memory = discrete.get_mutable_value(one.index)
            done = int(memory[0])
            if done >= len(one.moves):
                continue
            move, state = one.moves[done], one.ports[0].Eval(context)
            if memory[_BEGUN] >= 0:
                wanted, over = _reference(memory[_START], move, now - memory[_BEGUN])
                if over or wanted[2] < state[6] - _STANDS:
                    memory[:2] = done + 1, -1.0
            elif now >= move.time - 0.5 * FRAME and self._free(context, one, state, move):
                memory[_BEGUN], memory[_START] = now, state[:7]

    def _free(self, context: Context, one: _FreeBody, state: FloatArray, move: Displacement) -> bool:
        away = np.linalg.norm(self._setpoint.Eval(context)[:3] - state[4:7])
        still = bool(np.abs(state[10:13]).max() < _STILL)
        free = bool(away >= move.away) and still and move.aside(state[4:7]) is not None
        return free and float(one.ports[1].Eval(context)[0]) < _TOUCHED

    def _calc(self, context: Context, output: Value) -> None:
        forces = []
        for one in self._bodies:
            memory = context.get_discrete_state(one.index).value()
            if memory[_BEGUN] >= 0:
                move, state = one.moves[int(memory[0])], one.ports[0].Eval(context)
                wanted, _ = _reference(memory[_START], move, context.get_time() - memory[_BEGUN])
                forces.append(one.force(state, memory[_START], wanted, self._gravity))
        output.set_value(forces)


@dataclass(frozen=True, eq=False)
class _FreeBody:
    """A body, when it is displaced, its input ports, and its part of the state."""

    body: RigidBody
    moves: tuple[Displacement, ...]
    ports: tuple[InputPort, InputPort]
    index: DiscreteStateIndex

    def force(
        self, state: FloatArray, start: FloatArray, wanted: FloatArray, gravity: float
    ) -> ExternallyAppliedSpatialForce:
        """What a spring and a damper between the body and where it should be exert, with its weight."""
        inertia = self.body.default_spatial_inertia()
        com, mass = inertia.get_com(), inertia.get_mass()
        turned, at_first = (RotationMatrix(Quaternion(v[:4] / np.linalg.norm(v[:4]))) for v in (state, start))
        off = (at_first @ turned.inverse()).ToAngleAxis()
        about = turned.matrix() @ inertia.Shift(com).CalcRotationalInertia().CopyToFullMatrix3() @ turned.matrix().T
        turn = _STIFFNESS**2 * off.angle() * off.axis() - 2 * _STIFFNESS * state[7:10]
        velocity = state[10:13] + np.cross(state[7:10], turned.matrix() @ com)
        pull = _STIFFNESS**2 * (wanted - state[4:7]) - 2 * _STIFFNESS * velocity + [0.0, 0.0, gravity]
        applied = ExternallyAppliedSpatialForce()
        applied.body_index = self.body.index()
        applied.p_BoBq_B = com
        applied.F_Bq_W = SpatialForce(tau=about @ turn, f=mass * pull)
        return applied


def _reference(start: FloatArray, move: Displacement, passed: float) -> tuple[FloatArray, bool]:
    """Where the body should be so long after it was taken, shape (3,), and whether that was long enough."""
    place, way = np.array(start[4:7]), move.aside(start[4:7])
    assert way is not None
    place[2] += _LIFT * min(passed / _UP, 1.0)
    place[:2] += min(max(passed - _UP, 0.0) / _ACROSS, 1.0) * way
    place[2] -= _DOWN * max(passed - _UP - _ACROSS, 0.0)
    return place, passed > _LONGEST
