"""What several tests of libraries share."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))  # import-mode importlib: linked_library lies beside the tests

from linked_library import CHAIN, HASH  # noqa: E402

from ichain_drake.learning.library import save_chain  # noqa: E402


@pytest.fixture
def library(tmp_path: Path) -> Path:
    save_chain(CHAIN, tmp_path / "library", "a test", HASH)
    return tmp_path / "library"
