"""World objects: one LeafSystem per file, one base class."""

from ichain_drake.objects.base import ObjectSettings, WorldObject
from ichain_drake.objects.button import Button, ButtonMount
from ichain_drake.objects.camera import CameraFrame
from ichain_drake.objects.car import Car, CarParameters
from ichain_drake.objects.check import ContractError, check_object
from ichain_drake.objects.cup import Cup
from ichain_drake.objects.cup_settings import CupFaults, CupSettings, Surface
from ichain_drake.objects.food import Food, FoodSettings, OvenSettings
from ichain_drake.objects.hovercraft import Hovercraft, HovercraftParameters
from ichain_drake.objects.joystick import Joystick, JoystickMount
from ichain_drake.objects.kettle import Kettle, KettleSettings
from ichain_drake.objects.oven_part import Dial, OvenPart, PartMount, SlidingPart
from ichain_drake.objects.region import Region
from ichain_drake.objects.road_car import RoadCar, RoadCarParameters
from ichain_drake.objects.ship import Ship, ShipParameters
from ichain_drake.objects.tank import Tank, TankSettings
from ichain_drake.objects.wheel import Wheel, WheelMount

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
    "Dial",
    "Food",
    "FoodSettings",
    "Hovercraft",
    "HovercraftParameters",
    "Joystick",
    "JoystickMount",
    "Kettle",
    "KettleSettings",
    "ObjectSettings",
    "OvenPart",
    "OvenSettings",
    "PartMount",
    "Region",
    "RoadCar",
    "RoadCarParameters",
    "Ship",
    "ShipParameters",
    "SlidingPart",
    "Surface",
    "Tank",
    "TankSettings",
    "Wheel",
    "WheelMount",
    "WorldObject",
    "check_object",
]
