"""What several tests learn from and save: a linked chain, and the small world's pieces."""

from pathlib import Path

import pytest
import small_world
from linked_library import CHAIN, HASH

from ichain_drake.demonstrations import Demonstration
from ichain_drake.learning import InteractionModel, learn_interactions
from ichain_drake.learning.library import save_chain


@pytest.fixture
def library(tmp_path: Path) -> Path:
    save_chain(CHAIN, tmp_path / "library", "a test", HASH)
    return tmp_path / "library"


@pytest.fixture(scope="session")
def demonstrations() -> list[Demonstration]:
    return small_world.pieces(0)


@pytest.fixture(scope="session")
def model(demonstrations: list[Demonstration]) -> InteractionModel:
    return learn_interactions(demonstrations, small_world.GRAPH)
