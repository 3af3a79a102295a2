"""World objects: one LeafSystem per file, one base class."""

from ichain_drake.objects.base import ObjectSettings, WorldObject
from ichain_drake.objects.button import Button, ButtonMount
from ichain_drake.objects.camera import CameraFrame
from ichain_drake.objects.car import Car, CarParameters
from ichain_drake.objects.check import ContractError, check_object
from ichain_drake.objects.cup import Cup
from ichain_drake.objects.cup_settings import CupFaults, CupSettings, Surface
from ichain_drake.objects.joystick import Joystick, JoystickMount
from ichain_drake.objects.region import Region
from ichain_drake.objects.tank import Tank, TankSettings

__all__ = [
    "Button",
    "ButtonMount",
    "CameraFrame",
    "Car",
    "CarParameters",
    "ContractError",
    "Cup",
    "CupFaults",
    "CupSettings",
    "Joystick",
    "JoystickMount",
    "ObjectSettings",
    "Region",
    "Surface",
    "Tank",
    "TankSettings",
    "WorldObject",
    "check_object",
]
