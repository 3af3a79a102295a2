"""What a person holds in the browser: axes by gamepad, held keys or mouse, and buttons, all by way of Meshcat."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydrake.geometry import Meshcat

FloatArray = NDArray[np.float64]

_DEAD_ZONE = 0.08  # sticks that nobody touches read up to this
_STEP = 0.01
_PRESSED = 0.5


@dataclass(frozen=True)
class Axis:
    """One direction to steer in, -1 to 1, which springs back to 0.

    Attributes:
        name: of the slider.
        keys: codes of the keys held to go to -1 and to 1, as in the browser's `KeyboardEvent.code`.
        directions: what -1 and 1 do, in a word each.
        pad: number of the gamepad's axis; None for none.
        pad_sign: 1 or -1; a stick pushed away from oneself reads -1.
    """

    name: str
    keys: tuple[str, str]
    directions: tuple[str, str]
    pad: int | None = None
    pad_sign: float = 1.0


@dataclass(frozen=True)
class PageButton:
    """Something to press.

    Attributes:
        name: its label.
        key: code of its key, as in the browser's `KeyboardEvent.code`; empty for none.
        about: what it does, in a few words; empty if the label says it.
        pad: number of the gamepad's button; None for none.
    """

    name: str
    key: str = ""
    about: str = ""
    pad: int | None = None


class Controls:
    """Reads axes and buttons. The page of `LivePage` turns held keys into motions of the sliders.

    Args:
        meshcat: where sliders and buttons are put; calls must come from the thread that made it.
        axes: to steer.
        buttons: to press.
    """

    def __init__(self, meshcat: Meshcat, axes: Sequence[Axis] = (), buttons: Sequence[PageButton] = ()) -> None:
        self._meshcat = meshcat
        self.axes = tuple(axes)
        self.buttons = tuple(buttons)
        self.device = "none"
        self._stale: Any = None
        for axis in self.axes:
            meshcat.AddSlider(axis.name, -1.0, 1.0, _STEP, 0.0)
        for button in self.buttons:
            meshcat.AddButton(button.name, button.key)
        self._clicks = {button.name: 0 for button in self.buttons}
        self._held: set[str] = set()

    def read(self) -> FloatArray:
        """Where the axes are now, shape (n_axes,), each in [-1, 1]; `device` says what moved them last."""
        sliders = np.array([self._meshcat.GetSliderValue(axis.name) for axis in self.axes])
        pad = self._pad()
        sticks = np.zeros(len(self.axes))
        for i, axis in enumerate(self.axes):
            if pad is not None and axis.pad is not None and axis.pad < len(pad.axes):
                sticks[i] = axis.pad_sign * _without_dead_zone(float(pad.axes[axis.pad]))
        if sticks.any():
            self.device = "gamepad"
        elif sliders.any():
            self.device = "keys"
        return np.clip(sliders + sticks, -1.0, 1.0)

    def pressed(self) -> list[str]:
        """Names of the buttons pressed since the last call, in their order."""
        pad = self._pad()
        found = []
        for button in self.buttons:
            clicks = self._meshcat.GetButtonClicks(button.name)
            new = clicks > self._clicks[button.name]
            self._clicks[button.name] = clicks
            values = [] if pad is None else pad.button_values
            down = button.pad is not None and button.pad < len(values) and values[button.pad] > _PRESSED
            if down and button.name not in self._held:
                new = True
            (self._held.add if down else self._held.discard)(button.name)
            if new:
                found.append(button.name)
        return found

    def let_go(self) -> None:
        """Take everything as released, after the browser was lost: its last message may be of a stick that was held."""
        for axis in self.axes:
            self._meshcat.SetSliderValue(axis.name, 0.0)
        self._stale = _content(self._meshcat.GetGamepad())

    def page_keys(self) -> dict[str, list[Any]]:
        """Held keys for the page: code -> [slider, direction]."""
        return {k: [a.name, sign] for a in self.axes for k, sign in zip(a.keys, (-1, 1), strict=True) if k}

    def instructions(self) -> list[list[Any]]:
        """Lines for the page: [keys, text, what it is on a gamepad]."""
        lines: list[list[Any]] = []
        for axis in self.axes:
            keys = [key_name(k) for k in axis.keys if k]
            text = f"{axis.name}: {axis.directions[0]}, {axis.directions[1]}"
            lines.append([keys, text, "" if axis.pad is None else _stick(axis.pad)])
        for button in self.buttons:
            keys = [key_name(button.key)] if button.key else []
            lines.append([keys, button.about or button.name, "" if button.pad is None else f"button {button.pad}"])
        return lines

    def _pad(self) -> Meshcat.Gamepad | None:
        pad = self._meshcat.GetGamepad()
        if pad.index is None or (self._stale is not None and _content(pad) == self._stale):
            return None
        self._stale = None
        return pad


def key_name(code: str) -> str:
    """What is printed on a key, from its code in the browser."""
    arrows = {"ArrowLeft": "←", "ArrowRight": "→", "ArrowUp": "↑", "ArrowDown": "↓", "Escape": "Esc", "Space": "space"}
    return arrows.get(code, code.removeprefix("Key").removeprefix("Digit"))


def _without_dead_zone(value: float) -> float:
    size = max(abs(value) - _DEAD_ZONE, 0.0) / (1.0 - _DEAD_ZONE)
    return float(np.copysign(size, value))


def _stick(axis: int) -> str:
    sides = ("left stick sideways", "left stick", "right stick sideways", "right stick")
    return sides[axis] if axis < len(sides) else f"axis {axis}"


def _content(pad: Meshcat.Gamepad) -> tuple[Any, ...]:
    return (pad.index, tuple(pad.axes), tuple(pad.button_values))
