"""A hovercraft of a second video game: it slides, so that where it points and where it goes are two things (ours)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ichain_drake.objects.base import ParentStates
from ichain_drake.objects.vehicles.vehicle import Vehicle, joined, planar_pose, scaled_noise
from ichain_drake.state import FloatArray, StateSpace, Variable, columns, wrap_angle


@dataclass(frozen=True)
class HovercraftParameters:
    """Constants of the game.

    Attributes:
        thrust: acceleration by the fan at full speed [px/s^2].
        brake: drag in addition with the stick pulled back, which lets air out of the skirt [1/s].
        fan_lag: time constant of the fan [s].
        drag_ahead, drag_aside: of air and skirt [1/s].
        drag_quadratic: of the speed [1/px].
        turn: yaw acceleration by the full rudder [rad/s^2].
        turn_drag: [1/s].
        vane: yaw acceleration that turns the nose to where it goes, by the speed aside [rad/(px s)].
        wind: acceleration along x and y [px/s^2].
        noise: standard deviations per square-root second of the speeds ahead and aside [px/s], yaw rate [rad/s],
            position along x and y [px].
    """

    thrust: float = 75.0
    brake: float = 1.2
    fan_lag: float = 0.25
    drag_ahead: float = 0.6
    drag_aside: float = 1.6
    drag_quadratic: float = 0.003
    turn: float = 3.0
    turn_drag: float = 2.0
    vane: float = 0.03
    wind: tuple[float, float] = (2.5, -1.5)
    noise: tuple[float, ...] = (4.0, 4.0, 0.15, 0.4, 0.4)


class Hovercraft(Vehicle[HovercraftParameters]):
    """The hovercraft. Its one parent has two observable variables in [-1, 1]: rudder, then throttle.

    It is pushed along its nose, turned by the rudder, and hardly held by the ground: in a bend it slides outwards, and
    is kept on its way by pointing inwards.

    Args:
        parameters: the game's constants.
        parents, initial, settings: see `WorldObject`.

    Raises:
        InputError: if there is not one parent with two observable variables.
    """

    state_space: ClassVar[StateSpace] = StateSpace(
        "hovercraft",
        (
            *planar_pose("screen", "px"),
            Variable("ahead", "px/s"),
            Variable("aside", "px/s"),
            Variable("yaw_rate", "rad/s"),
            Variable("fan", "1", hidden=True),
        ),
    )
    controls: ClassVar[tuple[str, str]] = ("rudder", "throttle")
    parameters_class: ClassVar[type[HovercraftParameters]] = HovercraftParameters
    process_noise_size: ClassVar[int] = 5
    reading_std: ClassVar[tuple[float, ...]] = (0.5, 0.5, 0.01, 1.0, 1.0, 0.02)

    def step(
        self, state: FloatArray, parents: ParentStates, active: Mapping[str, FloatArray], noise: FloatArray, dt: float
    ) -> FloatArray:
        """One frame of the game."""
        p = self.parameters
        jx, jy = (np.maximum(np.minimum(c, 1.0), -1.0) for c in self.read_controls(parents, active))
        x, y, heading, u, v, w, fan = columns(state)
        n = scaled_noise(noise, p.noise, dt)
        c, s = np.cos(heading), np.sin(heading)

        rudder = jx * (0.7 + 0.3 * jx**2)
        wanted = np.maximum(jy, 0.0) * (0.7 + 0.3 * np.abs(jy))
        drag = p.drag_quadratic * np.sqrt(u * u + v * v) + p.brake * np.maximum(-jy, 0.0)
        wind_ahead, wind_aside = c * p.wind[0] + s * p.wind[1], c * p.wind[1] - s * p.wind[0]
        # The frame of the hull turns: what goes straight on changes its speeds ahead and aside.
        u1 = u + dt * (p.thrust * fan - (p.drag_ahead + drag) * u + w * v + wind_ahead) + n[0]
        v1 = v + dt * (-(p.drag_aside + drag) * v - w * u + wind_aside) + n[1]
        w1 = w + dt * (p.turn * rudder - p.turn_drag * w + p.vane * v) + n[2]
        values = (
            x + dt * (c * u1 - s * v1) + n[3],
            y + dt * (s * u1 + c * v1) + n[4],
            wrap_angle(heading + dt * w1),
            u1,
            v1,
            w1,
            fan + dt * (wanted - fan) / p.fan_lag,
        )
        return joined(state, values)
