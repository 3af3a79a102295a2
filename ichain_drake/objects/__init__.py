"""World objects: one LeafSystem per file, one base class."""

from ichain_drake.objects.base import ObjectSettings, WorldObject
from ichain_drake.objects.car import Car, CarParameters
from ichain_drake.objects.check import ContractError, check_object
from ichain_drake.objects.joystick import Joystick, JoystickMount

__all__ = [
    "Car",
    "CarParameters",
    "ContractError",
    "Joystick",
    "JoystickMount",
    "ObjectSettings",
    "WorldObject",
    "check_object",
]
