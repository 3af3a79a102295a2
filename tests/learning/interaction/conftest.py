import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))  # import-mode importlib: small_world lies beside the tests

import small_world  # noqa: E402

from ichain_drake.demonstrations import Demonstration  # noqa: E402
from ichain_drake.learning.interaction import InteractionModel, learn_interactions  # noqa: E402


@pytest.fixture(scope="session")
def demonstrations() -> list[Demonstration]:
    return small_world.pieces(0)


@pytest.fixture(scope="session")
def model(demonstrations: list[Demonstration]) -> InteractionModel:
    return learn_interactions(demonstrations, small_world.GRAPH)
