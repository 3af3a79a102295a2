"""What several tests learn from: the water dispenser's pieces on `ideal`."""

import sys
from pathlib import Path

import pytest

from ichain_drake.demonstrations import Demonstration
from ichain_drake.learning.interaction import InteractionSpec
from ichain_drake.learning.link import EstimatorSpec
from ichain_drake.scenarios.knowledge import Knowledge, learn_graph
from ichain_drake.scenarios.water_dispenser import WaterDispenser

sys.path.insert(0, str(Path(__file__).parent))  # import-mode importlib: helpers lie beside the tests

QUICK = InteractionSpec(status_estimators=(EstimatorSpec.parse("box(reach=0.3)"),))


@pytest.fixture(scope="session")
def quick_spec() -> InteractionSpec:
    return QUICK


@pytest.fixture(scope="session")
def dispenser_pieces() -> list[Demonstration]:
    return list(WaterDispenser((), "ideal").record_demonstrations())


@pytest.fixture(scope="session")
def dispenser_knowledge(dispenser_pieces: list[Demonstration]) -> Knowledge:
    return learn_graph(dispenser_pieces, WaterDispenser((), "ideal").graph, QUICK)
