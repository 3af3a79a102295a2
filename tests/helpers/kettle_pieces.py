"""The pieces of bottle and kettle on `ideal`, recorded once for all of its tests."""

from functools import cache

from sharing import made_once

from ichain_drake.demonstrations import Demonstration
from ichain_drake.systems.kettle.scenario import KettleScenario


@cache
def kettle() -> KettleScenario:
    return KettleScenario((), "ideal", seed=0)


@cache
def kettle_pieces() -> list[Demonstration]:
    return made_once("kettle_pieces", lambda: list(kettle().record_demonstrations()))
