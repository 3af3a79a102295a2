"""Quaternions of a log as angles: what a map says of them, and what they become."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from ichain_drake.demonstrations.importing.sources import Source, split_target
from ichain_drake.errors import InputError
from ichain_drake.files import printable
from ichain_drake.state import FloatArray, wrap_angle
from ichain_drake.units import convert

_ORDERS = ("xyzw", "wxyz")
_ANGLES = ("yaw", "pitch", "roll")  # as scipy gives them
_UNIT = "rad"
_LONGEST = 1e-3
"""How far from 1 a quaternion's length may be [1]: as much as rounding to three decimals changes it."""
FORM = '{xyzw: [source, source, source, source], roll: "object.variable [rad]", ...}; the order may be wxyz, too'


@dataclass(frozen=True)
class Quaternion:
    """Four numbers of a log that tell how an object stands, and which of its angles are wanted.

    Attributes:
        sources: of x, y, z and w.
        angles: the column that each becomes, by `roll`, `pitch` and `yaw`.
        units: of these columns.
    """

    sources: tuple[Source, ...]
    angles: Mapping[str, str]
    units: Mapping[str, str]

    @property
    def text(self) -> str:
        """As errors name it: by the first of its sources."""
        return f"the quaternion of {printable(self.sources[0].text)}"


def parse_rotation(plain: Any, where: str) -> Quaternion:
    """An entry of `rotations` in a map.

    Args:
        plain: as YAML gives it.
        where: what to call the map in errors.

    Raises:
        InputError: on another form, a target that is no variable, or a unit that no angle has.
    """
    shown = printable(str(plain))[:80]
    orders = [o for o in _ORDERS if o in plain] if isinstance(plain, Mapping) else []
    if len(orders) != 1 or set(plain) - {*orders, *_ANGLES} or len(plain) == 1:
        raise InputError(f"{where}: rotation {shown}: write {FORM}")
    texts = plain[orders[0]]
    if not isinstance(texts, list) or len(texts) != 4 or not all(isinstance(t, str) for t in texts):
        raise InputError(f"{where}: rotation {shown}: {orders[0]} is a list of four sources, of one number each")
    by_name = dict(zip(orders[0], (Source.parse(t) for t in texts), strict=True))
    if len(set(by_name.values())) < 4:
        raise InputError(f"{where}: rotation {shown}: a source stands twice among its four; name each number's own")
    angles, units = {}, {}
    for name in _ANGLES:
        if name in plain:
            target, unit = split_target(plain[name], where)
            if "->" in target:
                raise InputError(f"{where}: {printable(target)} is an interaction and no angle; write object.variable")
            try:
                convert(np.zeros(1), _UNIT, unit or _UNIT)
            except InputError as error:
                raise InputError(f"{where}: {printable(target)} is an angle; {error}") from None
            angles[name], units[target] = target, unit or _UNIT
    return Quaternion(tuple(by_name[n] for n in "xyzw"), angles, units)


def angles_of(rotation: Quaternion, values: Mapping[Source, FloatArray], where: str) -> dict[str, FloatArray]:
    """The wanted angles, each of shape (n,), by their columns.

    They are Drake's `RollPitchYaw`: turned by roll about the object's own x, after pitch about its y, after yaw about
    its z (intrinsic z-y'-x''). Roll and yaw are wrapped as all angles here are, pitch is within a right angle; where
    it is one, roll is 0 and yaw tells all.

    Args:
        rotation: which.
        values: of each of its sources, shape (n,).
        where: what to call the log in errors.

    Raises:
        InputError: names a row in which there is no unit quaternion.
    """
    numbers = np.stack([values[s] for s in rotation.sources], axis=1)
    with np.errstate(over="ignore", invalid="ignore"):
        lengths = np.linalg.norm(numbers, axis=1)
    wrong = ~(np.abs(lengths - 1) <= _LONGEST)  # NaN, too
    if wrong.any():
        row = int(np.argmax(wrong))
        four = ", ".join(f"{v:.4g}" for v in numbers[row])
        raise InputError(
            f"{where}: {rotation.text}: row {row + 1} (x, y, z, w: {four}) has length {lengths[row]:.4g} and is no "
            "rotation; a unit quaternion is needed"
        )
    if not len(numbers):
        return {target: np.zeros(0) for target in rotation.angles.values()}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # of a pitch of a right angle, where roll and yaw are one
        angles = dict(zip(_ANGLES, Rotation.from_quat(numbers).as_euler("ZYX").T, strict=True))
    found = {target: wrap_angle(angles[name]) for name, target in rotation.angles.items()}
    return {target: convert(angle, _UNIT, rotation.units[target]) for target, angle in found.items()}
