"""The pieces of bottle and kettle on `ideal`, recorded once for all of its tests."""

from functools import cache

from ichain_drake.demonstrations import Demonstration
from ichain_drake.systems.kettle.scenario import KettleScenario


@cache
def kettle() -> KettleScenario:
    return KettleScenario((), "ideal", seed=0)


@cache
def kettle_pieces() -> list[Demonstration]:
    return list(kettle().record_demonstrations())
