"""World objects: one LeafSystem per file, one base class."""

from ichain_drake.objects.base import ObjectSettings, WorldObject
from ichain_drake.objects.camera import CameraFrame
from ichain_drake.objects.check import ContractError, check_object
from ichain_drake.objects.controls.joystick import Joystick, JoystickMount
from ichain_drake.objects.controls.wheel import Wheel, WheelMount
from ichain_drake.objects.parts.button import Button, ButtonMount
from ichain_drake.objects.parts.food import Food, FoodSettings, OvenSettings
from ichain_drake.objects.parts.lid import Lid, LidMount
from ichain_drake.objects.parts.oven_part import Dial, OvenPart, PartMount, SlidingPart
from ichain_drake.objects.region import Region
from ichain_drake.objects.vehicles.car import Car, CarParameters
from ichain_drake.objects.vehicles.hovercraft import Hovercraft, HovercraftParameters
from ichain_drake.objects.vehicles.road_car import RoadCar, RoadCarParameters
from ichain_drake.objects.vehicles.ship import Ship, ShipParameters
from ichain_drake.objects.vessels.cup import Cup
from ichain_drake.objects.vessels.cup_settings import CupFaults, CupSettings, Surface
from ichain_drake.objects.vessels.jug import Jug, JugSettings
from ichain_drake.objects.vessels.kettle import Kettle, KettleSettings
from ichain_drake.objects.vessels.pot import Pot, PotSettings
from ichain_drake.objects.vessels.tank import Tank, TankSettings

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
    "Jug",
    "JugSettings",
    "Kettle",
    "KettleSettings",
    "Lid",
    "LidMount",
    "ObjectSettings",
    "OvenPart",
    "OvenSettings",
    "PartMount",
    "Pot",
    "PotSettings",
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
