"""The command line in this process, and small things to run it on."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from ichain_drake.cli.main import main


@dataclass(frozen=True)
class Outcome:
    """What one command left."""

    status: int
    out: str
    err: str

    @property
    def line(self) -> str:
        """The one line of an error, behind progress lines; fails if there are more or none."""
        said = [line for line in self.err.splitlines() if not line.startswith("[")]
        assert len(said) == 1, self.err
        assert said[0].startswith("ichain: ")
        assert "Traceback" not in self.err
        return said[0]


Ichain = Callable[..., Outcome]


@pytest.fixture
def ichain(capfd: pytest.CaptureFixture[str]) -> Ichain:
    def call(*arguments: object) -> Outcome:
        capfd.readouterr()
        status = main([str(a) for a in arguments])
        seen = capfd.readouterr()
        return Outcome(status, seen.out, seen.err)

    return call


SMALL = ("--physics", "ideal", "--set", "learning.samples=120")


@pytest.fixture
def small() -> tuple[str, ...]:
    """Options of a run of two seconds."""
    return SMALL


def write_path(file: Path, points: np.ndarray, columns: tuple[str, ...] = ("x", "y")) -> Path:
    pd.DataFrame(np.asarray(points, dtype=float), columns=list(columns)).to_csv(file, index=False)
    return file


@pytest.fixture
def csv(tmp_path: Path) -> Callable[..., Path]:
    """Writes points into a CSV file."""

    def write(points: object, columns: tuple[str, ...] = ("x", "y"), name: str = "bend.csv") -> Path:
        return write_path(tmp_path / name, np.asarray(points, dtype=float), columns)

    return write


def bend() -> np.ndarray:
    """A quarter of a circle: four seconds to follow."""
    a = np.linspace(0.0, np.pi / 2, 60)
    return np.stack([250 + 120 * np.sin(a), 200 + 120 * (1 - np.cos(a))], axis=1)


@pytest.fixture(scope="session")
def bend_csv(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_path(tmp_path_factory.mktemp("path") / "bend.csv", bend())


@pytest.fixture(scope="session")
def ran(tmp_path_factory: pytest.TempPathFactory, bend_csv: Path) -> Path:
    """The folder of one small run."""
    folder = tmp_path_factory.mktemp("ran")
    assert main(["run", "car_game", *SMALL, "--path", str(bend_csv), "-o", str(folder)]) == 0
    return folder


@pytest.fixture
def strict_json() -> Callable[[str], dict]:
    """Reads JSON that has no NaN and no Infinity."""

    def refuse(name: str) -> float:
        raise AssertionError(f"{name} is no JSON")

    return lambda text: json.loads(text, parse_constant=refuse)
