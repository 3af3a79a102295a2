"""The lidded pot on `ideal` with its script's pieces and what is learned of them, once for all of its tests."""

from functools import cache

from sharing import made_once

from ichain_drake.demonstrations import Demonstration
from ichain_drake.learning import InteractionModel, InteractionSpec
from ichain_drake.learning.chain.link import EstimatorSpec
from ichain_drake.runs.learn import learn
from ichain_drake.systems.lidded_pot.scenario import LiddedPot

QUICK = InteractionSpec(status_estimators=(EstimatorSpec.parse("box(reach=0.3)"),))


@cache
def lidded_pot() -> LiddedPot:
    return LiddedPot((), "ideal", seed=70_000)


@cache
def lidded_pot_pieces() -> list[Demonstration]:
    return made_once("lidded_pot_pieces", lambda: list(lidded_pot().record_demonstrations()))


@cache
def lidded_pot_model() -> InteractionModel:
    return made_once("lidded_pot_model", lambda: learn(lidded_pot(), lidded_pot_pieces(), spec=QUICK))
