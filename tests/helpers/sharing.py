"""What takes long to record or to learn, made once for all processes and files of a test run."""

import os
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import pytest

T = TypeVar("T")

_folder: Path | None = None


def share_in(factory: pytest.TempPathFactory) -> None:
    """Keep things in the temporary folder of the whole run: with xdist, every worker's is a folder in it."""
    global _folder  # noqa: PLW0603 - helpers are plain functions, which no fixture reaches
    own = factory.getbasetemp()
    _folder = own.parent if "PYTEST_XDIST_WORKER" in os.environ else own


def made_once(name: str, make: Callable[[], T]) -> T:
    """What the first process that needs it makes; the others read it. Each gets a copy of its own.

    Args:
        name: of the file.
        make: makes it; the same wherever it is called.
    """
    assert _folder is not None, "tests/conftest.py says where"
    file = _folder / f"{name}.pickle"
    if not file.exists():
        part = file.with_suffix(f".{os.getpid()}")
        part.write_bytes(pickle.dumps(make()))
        part.replace(file)
    return pickle.loads(file.read_bytes())
