"""What vehicles share that a stick or a wheel drives: parameters, one parent with two controls, noise by variable."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, Generic, TypeVar, Unpack

import numpy as np

from ichain_drake.errors import InputError
from ichain_drake.objects.base import ObjectArguments, ParentStates, WorldObject
from ichain_drake.state import FloatArray, Role, StateSpace, Variable, columns, wrap_angle

ParametersT = TypeVar("ParametersT")


class Vehicle(WorldObject, Generic[ParametersT]):
    """A vehicle with one parent, whose two observable variables are its controls.

    A subclass has a `state_space`, `controls`, `parameters_class`, and a `step`.

    Args:
        parameters: constants; the class's defaults if None.
        parents, initial, settings: see `WorldObject`.

    Raises:
        InputError: if there is not one parent with two observable variables.
    """

    controls: ClassVar[tuple[str, str]] = ("steering", "throttle")
    """What the parent's two observable variables do, in their order."""

    parameters_class: ClassVar[type[Any]]
    """Dataclass of the constants, with a default for each."""

    reading_std: ClassVar[tuple[float, ...]] = ()
    """Standard deviation of a reading of each observable variable, in its unit, at `reading_scale` 1."""

    parameters: ParametersT

    def __init__(
        self,
        name: str,
        parents: Mapping[str, StateSpace],
        parameters: ParametersT | None = None,
        **given: Unpack[ObjectArguments],
    ) -> None:
        super().__init__(name, parents, **given)
        self.parameters = self.parameters_class() if parameters is None else parameters
        self._driver = next(iter(parents), "")
        if len(parents) != 1 or len(parents[self._driver].observable) != 2:
            kind = self.state_space.type.replace("_", " ")
            raise InputError(
                f"{name}: a {kind} has one parent with two observable variables ({', '.join(self.controls)})"
            )
        self._inputs = parents[self._driver].observable_indices

    def measure(self, state: FloatArray, noise: FloatArray) -> FloatArray:
        """The truth, as in the paper's game, or with the declared noise times `reading_scale`; angles are wrapped."""
        read = state[..., self._observable]
        if not self.settings.reading_scale:
            return read
        read = read + self.settings.reading_scale * np.array(self.reading_std) * noise
        angles = self.state_space.observable.angle_mask
        read[..., angles] = wrap_angle(read[..., angles])
        return read

    def read_controls(self, parents: ParentStates, active: Mapping[str, FloatArray]) -> tuple[FloatArray, FloatArray]:
        """The two controls, 0 while nobody is at them, shape (...) each."""
        on, driver = active[self._driver], columns(parents[self._driver])
        first, second = self._inputs
        return on * driver[first], on * driver[second]


def planar_pose(frame: str, unit: str) -> tuple[Variable, Variable, Variable]:
    """Variables x, y and heading of one pose in a plane.

    Args:
        frame: of the pose.
        unit: of x and y; the heading is in rad.
    """
    return (
        Variable("x", unit, role=Role("position", frame=frame, axis="x")),
        Variable("y", unit, role=Role("position", frame=frame, axis="y")),
        Variable("heading", "rad", -math.pi, math.pi, "angle", role=Role("orientation", frame=frame, axis="z")),
    )


def scaled_noise(noise: FloatArray, deviations: Sequence[float], dt: float) -> list[FloatArray]:
    """What noise adds in one frame, by variable.

    Args:
        noise: standard normal, shape (..., n).
        deviations: standard deviations per square-root second, at most n.
        dt: length of the frame [s].
    """
    root = math.sqrt(dt)
    return [n * (scale * root) for n, scale in zip(columns(noise), deviations, strict=False)]


def joined(state: FloatArray, values: Sequence[FloatArray]) -> FloatArray:
    """One array of a state's shape from its variables' values; the inverse of `columns`."""
    if state.ndim == 1:
        return np.array(values, dtype=float)
    after = np.empty_like(state, dtype=float)
    for i, value in enumerate(values):
        after[..., i] = value
    return after
