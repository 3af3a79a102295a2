"""A road car: dynamic single-track model with saturating tyres.

Equations: R. Rajamani, *Vehicle Dynamics and Control*, 2nd ed., Springer 2012, ch. 2 (single-track model), with the
lateral tyre force of the Magic Formula (H. B. Pacejka, *Tire and Vehicle Dynamics*) in its short form
D sin(C atan(B x)), and a friction ellipse for braking in a bend. Parameters of a BMW 320i: vehicle 2 of M. Althoff,
M. Koschi, S. Manzinger, "CommonRoad: Composable benchmarks for motion planning on roads", IEEE Intelligent Vehicles
Symposium 2017, and its vehicle models' tyre file (lateral friction 1.0489, stiffness 21.92, shape factor 1.3507).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ichain_drake.objects.base import ParentStates
from ichain_drake.objects.controls.wheel import TRAVEL
from ichain_drake.objects.vehicles.vehicle import Vehicle, joined, planar_pose, scaled_noise
from ichain_drake.state import FloatArray, StateSpace, Variable, columns, wrap_angle

CAR_LENGTH = 4.508
"""Length of the car [m] (Althoff et al. 2017, vehicle 2)."""

_GRAVITY = 9.81
_SUBSTEPS = 4  # tyres are stiff at low speed
_SLOWEST = 4.0  # [m/s] slip angles are taken at no lower speed, where the model would be singular


@dataclass(frozen=True)
class RoadCarParameters:
    """Constants of the car.

    Attributes:
        mass, inertia: [kg], about the vertical [kg m^2].
        front, rear: distance from the centre of mass to each axle [m].
        friction, stiffness, shape: tyre: peak lateral force and its slope at zero slip angle [1/rad], both over the
            load, and Magic Formula C.
        ratio: turn of the wheel over turn of the road wheels.
        steer_lag: of the road wheels behind the wheel [s].
        acceleration, braking: at full travel of the column [m/s^2].
        drag: of the air, over the mass [1/m].
        rolling: resistance of a rolling car [m/s^2].
        noise: standard deviations per square-root second of speed [m/s], yaw rate [rad/s], lateral speed [m/s],
            position along x and y [m]: gusts and an uneven road.
    """

    mass: float = 1093.3
    inertia: float = 1791.6
    front: float = 1.1562
    rear: float = 1.4227
    friction: float = 1.0489
    stiffness: float = 21.92
    shape: float = 1.3507
    ratio: float = 10.0
    steer_lag: float = 0.15
    acceleration: float = 3.0
    braking: float = 6.0
    drag: float = 4e-4
    rolling: float = 0.12
    noise: tuple[float, ...] = (0.5, 0.06, 0.2, 0.08, 0.08)


class RoadCar(Vehicle[RoadCarParameters]):
    """The car. Its one parent is a wheel: angle [rad], counterclockwise steers left; slide [m], up gives gas.

    Args:
        parameters: constants.
        parents, initial, settings: see `WorldObject`.

    Raises:
        InputError: if there is not one parent with two observable variables.
    """

    state_space: ClassVar[StateSpace] = StateSpace(
        "road_car",
        (
            *planar_pose("ground", "m"),
            Variable("speed", "m/s"),
            Variable("yaw_rate", "rad/s"),
            Variable("slip", "m/s", hidden=True),
            Variable("steer", "rad", hidden=True),
        ),
    )
    controls: ClassVar[tuple[str, str]] = ("angle", "slide")
    parameters_class: ClassVar[type[RoadCarParameters]] = RoadCarParameters
    process_noise_size: ClassVar[int] = 5
    reading_std: ClassVar[tuple[float, ...]] = (0.05, 0.05, 0.003, 0.05, 0.005)

    def step(
        self, state: FloatArray, parents: ParentStates, active: Mapping[str, FloatArray], noise: FloatArray, dt: float
    ) -> FloatArray:
        """One frame, in four steps."""
        p = self.parameters
        angle, slide = self.read_controls(parents, active)
        pedal = np.maximum(np.minimum(slide / TRAVEL, 1.0), -1.0)
        x, y, heading, v, r, u, steer = columns(state)
        h = dt / _SUBSTEPS
        load = p.mass * _GRAVITY / (p.front + p.rear)
        front_load, rear_load = load * p.rear, load * p.front
        for _ in range(_SUBSTEPS):
            steer = steer + h * (angle / p.ratio - steer) / p.steer_lag
            moving = np.tanh(v / 0.5)
            push = np.where(pedal > 0, p.acceleration * pedal, p.braking * pedal * moving)
            grip = np.sqrt(1.0 - np.minimum(0.9, (push / (p.friction * _GRAVITY)) ** 2))
            ahead = np.maximum(v, _SLOWEST)
            fade = np.minimum(v / _SLOWEST, 1.0)  # no side force on wheels that don't roll
            front = fade * grip * front_load * self._side_force(steer - (u + p.front * r) / ahead)
            rear = fade * grip * rear_load * self._side_force(-(u - p.rear * r) / ahead)
            c = np.cos(steer)
            v_rate = push - p.drag * v * np.abs(v) - p.rolling * moving - front * np.sin(steer) / p.mass + r * u
            u_rate = (front * c + rear) / p.mass - r * v
            r_rate = (p.front * front * c - p.rear * rear) / p.inertia
            x = x + h * (v * np.cos(heading) - u * np.sin(heading))
            y = y + h * (v * np.sin(heading) + u * np.cos(heading))
            heading = heading + h * r
            # Standing still, nothing damps what is left of a turn but the tyres' rubber.
            still = np.exp(-h * (1.0 - fade) / 0.1)
            v, u, r = np.maximum(v + h * v_rate, 0.0), (u + h * u_rate) * still, (r + h * r_rate) * still
        rolling = np.tanh(np.abs(v) / 2.0)
        n = [rolling * x for x in scaled_noise(noise, p.noise, dt)]
        values = (x + n[3], y + n[4], wrap_angle(heading), np.maximum(v + n[0], 0.0), r + n[1], u + n[2], steer)
        return joined(state, values)

    def _side_force(self, slip: FloatArray) -> FloatArray:
        """Lateral tyre force over the load at a slip angle [rad]."""
        p = self.parameters
        return p.friction * np.sin(p.shape * np.arctan(p.stiffness / (p.friction * p.shape) * slip))
