"""The microwave oven's pieces on `ideal`, recorded once for all of its tests."""

from functools import cache

from sharing import made_once

from ichain_drake.demonstrations import Demonstration
from ichain_drake.systems.microwave.scenario import Microwave


@cache
def oven() -> Microwave:
    return Microwave((), "ideal")


@cache
def oven_pieces() -> tuple[Demonstration, ...]:
    return made_once("oven_pieces", lambda: tuple(oven().record_demonstrations()))
