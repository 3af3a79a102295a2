"""SIGKILL at moments by chance: what a killed process leaves is whole, or it is not taken for anything.

A few moments here; `ICHAIN_KILLS=50 pytest tests/cli/test_killed.py` tries so many in all. The moments are parts of the
processor time that the whole command takes, so that a busy machine kills it at the same places. Each command is a
function of its settings and seed: what it leaves is compared with what it makes when nobody kills it. A person's open
piece, which nothing can make again, is killed in `tests/runs/test_browser_teaching.py`.
"""

from __future__ import annotations

import json
import os
import random
import signal
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from forking import Forks

from ichain_drake.demonstrations import read_demonstration
from ichain_drake.learning.library import check_library

KILLS = int(os.environ.get("ICHAIN_KILLS", "4"))
SMALL = ("--physics", "ideal", "--set", "learning.samples=120")
COMMANDS = ("run", "teach", "evaluate", "learn")


def arguments(command: str, folder: Path, read: Path) -> list[str]:
    """A small command that writes into a folder, and reads a path to follow, or pieces to learn from."""
    return {
        "run": ["run", "car_game", *SMALL, "--no-oracle", "--path", str(read), "-o", str(folder)],
        "teach": ["teach", "car_game", *SMALL, "-o", str(folder)],
        "evaluate": ["evaluate", "car_game", *SMALL, "--methods", "first_link", "--trials", "2",
                     "--report", str(folder / "report.json"), "--resume"],
        "learn": ["learn", "car_game", *SMALL[2:], "--demos", str(read), "-o", str(folder)],
    }[command]  # fmt: skip


def fixed(report: Path) -> dict[str, Any]:
    """What of a report does not depend on the clock."""
    content = json.loads(report.read_text())
    for key in ("wall_seconds", "date", "versions", "given", "command"):
        content.pop(key, None)
    return dict(json.loads(json.dumps(content, default=str)))


@pytest.fixture(scope="module")
def forks(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Forks]:
    made = Forks(tmp_path_factory.mktemp("forks"))
    yield made
    made.close()


@pytest.fixture(scope="module")
def whole(
    forks: Forks, bend_csv: Path, tmp_path_factory: pytest.TempPathFactory
) -> Callable[[str], tuple[Path, float]]:
    """The folder that a command makes when nobody kills it, and its processor time; each is run once."""
    place = tmp_path_factory.mktemp("whole")
    made: dict[str, tuple[Path, float]] = {}

    def make(command: str) -> tuple[Path, float]:
        if command not in made:
            read = make("teach")[0] if command == "learn" else bend_csv
            ended = forks.run(arguments(command, place / command, read))
            assert ended.status == 0, ended.said
            made[command] = (place / command, ended.seconds)
        return made[command]

    return make


def check_pieces(folder: Path, reference: Path) -> None:
    """Every piece that a reader would take is one of the reference's, to the last byte."""
    for file in folder.glob("[!.]*") if folder.is_dir() else ():
        assert file.read_bytes() == (reference / file.name).read_bytes()
        read_demonstration(file)


def check_rows(file: Path, reference: Path) -> None:
    """Every line but one that has no end is one of the reference's."""
    known = reference.read_text().splitlines()
    for line in file.read_text().split("\n")[:-1] if file.exists() else ():
        assert line in known


def check_left(command: str, folder: Path, reference: Path) -> None:
    """Whatever a reader would take of what a killed command left is whole."""
    pieces = "demonstrations" if command == "run" else "."
    if command in ("run", "teach"):
        check_pieces(folder / pieces, reference / pieces)
    if command == "learn" and folder.is_dir():
        assert check_library(folder) == []
        for entry in folder.glob("[!.]*"):
            assert sorted(f.name for f in entry.iterdir()) == sorted(f.name for f in (reference / entry.name).iterdir())
    if command == "evaluate":
        check_rows(folder / "report.rows.jsonl", reference / "report.rows.jsonl")
    if (folder / "report.json").exists():
        assert fixed(folder / "report.json").keys() == fixed(reference / "report.json").keys()
    if (folder / "playback.html").exists():
        assert (folder / "playback.html").read_text().rstrip().endswith("</html>")


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="processor time of another process is read from /proc")
@pytest.mark.parametrize("number", range(KILLS))
def test_what_is_left_is_whole(
    number: int, forks: Forks, whole: Callable[[str], tuple[Path, float]], bend_csv: Path, tmp_path: Path
) -> None:
    command = COMMANDS[number % len(COMMANDS)]
    reference, seconds = whole(command)
    read = whole("teach")[0] if command == "learn" else bend_csv
    folder = tmp_path / command
    # Half of the moments in the last fifth, in which files are written.
    rng = random.Random(number)
    share = rng.uniform(0.0, 1.0) if rng.random() < 0.5 else rng.uniform(0.8, 1.02)  # noqa: PLR2004
    killed = forks.run(arguments(command, folder, read), share * seconds)
    assert killed.status in (-signal.SIGKILL, 0), killed.said
    check_left(command, folder, reference)
    # Done again in the same place, it does its work as if nothing had been; pieces are never written over.
    again = forks.run(arguments(command, folder, read)) if number < len(COMMANDS) or command != "run" else None
    if again is not None and command == "teach" and any(folder.glob("[!.]*.parquet")) and again.status:
        assert (again.status, "demonstrations already" in again.said) == (2, True), again.said
    elif again is not None:
        assert again.status == 0, again.said
        check_left(command, folder, reference)
        if command == "evaluate":
            assert fixed(folder / "report.json")["rows"] == fixed(reference / "report.json")["rows"]
