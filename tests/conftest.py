"""What tests of several folders learn from: the water dispenser's pieces on `ideal`; and patience with busy machines.

Imported where they are used, so that a test of something small loads neither plants nor estimators.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from hypothesis import HealthCheck, settings

if TYPE_CHECKING:
    from ichain_drake.demonstrations import Demonstration
    from ichain_drake.learning import InteractionModel, InteractionSpec

# How long an example takes says more about what else runs on the machine than about the code.
settings.register_profile("patient", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("patient")


@pytest.fixture(scope="session")
def quick_spec() -> InteractionSpec:
    from ichain_drake.learning import InteractionSpec
    from ichain_drake.learning.chain.link import EstimatorSpec

    return InteractionSpec(status_estimators=(EstimatorSpec.parse("box(reach=0.3)"),))


@pytest.fixture(scope="session")
def dispenser_pieces() -> list[Demonstration]:
    from ichain_drake.systems.water_dispenser.scenario import WaterDispenser

    return list(WaterDispenser((), "ideal").record_demonstrations())


@pytest.fixture(scope="session")
def dispenser_model(dispenser_pieces: list[Demonstration], quick_spec: InteractionSpec) -> InteractionModel:
    from ichain_drake.runs.learn import learn
    from ichain_drake.systems.water_dispenser.scenario import WaterDispenser

    return learn(WaterDispenser((), "ideal").graph, dispenser_pieces, spec=quick_spec)
