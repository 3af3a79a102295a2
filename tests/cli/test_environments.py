"""Surroundings as they may be: little of everything is enough for the work, or it ends with one line."""

from __future__ import annotations

import errno
import json
import os
import resource
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from full_disk import room_for

# Limits are set by the process itself: what starts it may have none.
LIMITED = """
import json, locale, os, resource, sys
locale.setlocale(locale.LC_ALL, "")  # as windows and plots of some libraries do
for name, most in json.loads(os.environ.pop("LIMITS")).items():
    resource.setrlimit(getattr(resource, f"RLIMIT_{name}"), (most, most))
from ichain_drake.cli.start import main
sys.exit(main())
"""
HOMELESS = {"HOME", "TERM", "XDG_CONFIG_HOME", "XDG_CACHE_HOME", "MPLCONFIGDIR", "LANG", "LC_ALL", "LC_CTYPE"}


def limited(arguments: list[str], limits: dict[str, int], **environment: str) -> subprocess.CompletedProcess:
    """A command in a process with limits, without a home or a terminal."""
    kept = {name: value for name, value in os.environ.items() if name not in HOMELESS}
    return subprocess.run(
        [sys.executable, "-c", LIMITED, *arguments], capture_output=True, check=False,
        env=kept | {"OMP_NUM_THREADS": "1", "LIMITS": json.dumps(limits)} | environment,
    )  # fmt: skip


@pytest.fixture(scope="module")
def turkish(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """A locale with decimal commas, in which the capital of i is no I."""
    folder = tmp_path_factory.mktemp("locales")
    try:
        subprocess.run(["localedef", "-i", "tr_TR", "-f", "UTF-8", str(folder / "tr_TR.UTF-8")], check=True)
    except (OSError, subprocess.CalledProcessError) as error:
        pytest.skip(f"no locale can be made here: {error}")
    return {"LOCPATH": str(folder), "LC_ALL": "tr_TR.UTF-8"}


@pytest.mark.skipif(not hasattr(resource, "RLIMIT_DATA"), reason="the system has no such limit")
def test_little_of_everything_is_enough(small, bend_csv: Path, tmp_path: Path, turkish: dict[str, str]) -> None:
    """16 open files, 1.5 GiB of memory, no home, no terminal, a Turkish locale, names in other alphabets."""
    place = tmp_path / "Gr\u00f6\u00dfe \u4e2d \u043f\u0440\u0438\u043c\u0435\u0440"
    place.mkdir()
    path = place / "Kurve \u0130\u0131.csv"
    path.write_bytes(bend_csv.read_bytes())
    done = limited(
        ["run", "car_game", *small, "--path", str(path), "-o", str(place / "run")],
        {"NOFILE": 16, "DATA": 3 * 2**29}, **turkish,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert b"Traceback" not in done.stderr
    assert json.loads((place / "run" / "report.json").read_text())["goal_reached"]


def test_a_locale_that_lacks_the_letters_of_a_name(tmp_path: Path) -> None:
    """Python takes UTF-8 for it. Told not to (PYTHONUTF8=0), pydrake itself can't be imported."""
    file = tmp_path / "\u043f\u0440\u0438\u043c\u0435\u0440 \u4e2d.dot"
    done = limited(["graph", "car_game", "-o", str(file)], {"NOFILE": 16}, LC_ALL="C")
    assert (done.returncode, done.stderr) == (0, b"")
    assert file.read_text().startswith("digraph")


@pytest.mark.parametrize(
    ("error", "line"),
    [
        (MemoryError(), "there is not enough memory; free some, or ask for less at once (smaller files, --jobs 1)"),
        (
            OSError(errno.EMFILE, os.strerror(errno.EMFILE)),
            "Too many open files; raise that limit (ulimit -n), or ask for less at once (--jobs 1)",
        ),
    ],
)
def test_too_little_is_one_line(error: Exception, line: str, monkeypatch: pytest.MonkeyPatch, ichain) -> None:
    def fail(*arguments: object, **options: object) -> None:
        raise error

    monkeypatch.setattr("ichain_drake.cli.settings.print_settings", fail)
    done = ichain("settings", "car_game")
    assert (done.status, done.line) == (2, f"ichain: {line}")


def test_a_full_disk_is_one_line_in_every_command_that_writes(ichain, tmp_path: Path) -> None:
    """Files may not grow over 2 kB meanwhile; what is left is taken for nothing."""
    demos, small = tmp_path / "demos", ("--set", "learning.samples=60")
    assert ichain("teach", "car_game", "--physics", "ideal", *small, "-o", demos).status == 0
    made = ichain("export", "mcap", demos, "-o", tmp_path / "logs")
    logs = tmp_path / "logs" / "drive"
    out = tmp_path / "out"
    for command in (
        ["teach", "car_game", "--physics", "ideal", *small, "-o", out],
        ["learn", "car_game", "--demos", demos, *small, "-o", out],
        ["evaluate", "car_game", "--physics", "ideal", *small, "--methods", "first_link", "--trials", "1",
         "--report", out / "report.json"],
        ["check", demos, "--page", out / "page.html", "--report", out / "check.json"],
        ["import", "mcap", logs, "--map", logs / "map.yaml", "-o", out],
        ["export", "mcap", demos, "-o", out],
    ):  # fmt: skip
        shutil.rmtree(out, ignore_errors=True)
        with room_for(600 if command[0] == "check" else 2000):
            done = ichain(*command)
        assert (done.status, "File too large" in done.line) == (2, True), (command, done)
        assert not [f for f in out.rglob("[!.]*") if f.is_file() and f.suffix not in (".json", ".jsonl")], command
    assert made.status == 0


def test_a_folder_that_may_only_be_read(small, ichain, tmp_path: Path) -> None:
    folder = Path("/sys") if os.geteuid() == 0 else tmp_path  # where not even root may make a file
    refusals = ("Permission denied", "Operation not permitted", "Read-only file system")
    tmp_path.chmod(0o555)
    try:
        run, pieces = ["run", "car_game", *small, "-o", folder / "a"], ["teach", "car_game", "-o", folder / "t"]
        for command in (["graph", "car_game", "-o", folder / "g.dot"], run, pieces):
            done = ichain(*command)
            assert (done.status, any(r in done.line for r in refusals)) == (2, True), done
    finally:
        tmp_path.chmod(0o755)
