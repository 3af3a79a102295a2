"""What controls share that a hand holds by a knob, a joystick and a wheel: their one parent, and when it holds them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Generic, TypeVar, Unpack

import numpy as np

from ichain_drake.objects.base import ObjectArguments, ParentStates, WorldObject
from ichain_drake.objects.parents import only_hand, position_indices
from ichain_drake.objects.touch import TouchRule
from ichain_drake.state import BoolArray, FloatArray, StateSpace

MountT = TypeVar("MountT")

_TOUCH = TouchRule(1.0, 0.2)


class KnobControl(WorldObject, Generic[MountT]):
    """A control that mirrors, while it is held, where the hand has its knob.

    A subclass has a `state_space`, `mount_class`, `knob_axes`, and a `step`.

    Args:
        mount: where it stands; the class's default if None.
        parents, initial, settings: see `WorldObject`.

    Raises:
        InputError: if there is not one parent, or it has no position along `knob_axes`.
    """

    immediate: ClassVar[bool] = True
    mount_class: ClassVar[type[Any]]
    """Says where it stands; has a default for everything."""

    knob_axes: ClassVar[tuple[str, ...]]
    """Axes along which the hand's position moves the knob."""

    mount: MountT

    def __init__(
        self,
        name: str,
        parents: Mapping[str, StateSpace],
        mount: MountT | None = None,
        **given: Unpack[ObjectArguments],
    ) -> None:
        super().__init__(name, parents, **given)
        self.mount = self.mount_class() if mount is None else mount
        self._hand, space = only_hand(parents, name, f"a {self.state_space.type}")
        self._knob = position_indices(space, self.knob_axes, name)
        self._grip = [i for i, v in enumerate(space.variables) if v.kind == "binary"]

    def decide_active(
        self, state: FloatArray, parents: ParentStates, active: Mapping[str, bool], touch: float | None
    ) -> Mapping[str, bool]:
        """By contact force where there is a body; else while the hand, if it has a grip, is closed."""
        if touch is not None:
            on = _TOUCH.holds(touch, active[self._hand])
        else:
            on = all(parents[self._hand][i] > 0.5 for i in self._grip)
        return {self._hand: on}

    def decide_rows(
        self, state: FloatArray, parents: ParentStates, active: Mapping[str, BoolArray]
    ) -> Mapping[str, BoolArray]:
        """See `DecidesRows`."""
        return {self._hand: np.all(parents[self._hand][:, self._grip] > 0.5, axis=1)}
