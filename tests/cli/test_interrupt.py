"""Ctrl-C: status 130, one line, and what was done up to then is on disk. In processes of their own."""

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import pandas as pd
import pytest
from interrupting import LISTENING, STATUS, errors, interrupt
from patience import PATIENCE


def test_while_recording_by_contact(tmp_path: Path):
    arguments = ["run", "car_game", "--set", "learning.samples=3000", "-o", str(tmp_path)]
    status, _, err = interrupt(arguments, 55)
    assert status == STATUS, err
    assert errors(err) == ["ichain: interrupted; what was done so far is kept"]
    report = json.loads((tmp_path / "report.json").read_text())
    assert (report["reason"], report["goal_reached"]) == ("interrupted", False)
    play = pd.read_parquet(tmp_path / "demonstrations" / "play.parquet")
    assert len(play) == 7, "whole ticks of 55 frames, with the one under way, and the start"
    assert play.notna().all().all()


def test_a_request_to_end_keeps_as_much(tmp_path: Path):
    arguments = ["teach", "car_game", "--physics", "ideal", "--set", "learning.samples=5000", "-o", str(tmp_path)]
    status, _, err = interrupt(arguments, 200, number=signal.SIGTERM)
    assert status == 143, err
    assert errors(err) == ["ichain: interrupted"]
    assert [f.name for f in tmp_path.iterdir()] == ["play.parquet"]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("after", [0.0, 0.3, 0.8])
def test_at_moments_of_the_imports(number: signal.Signals, after: float):
    """From the first line of this package on; what Python does before that is Python's."""
    process = subprocess.Popen(
        [sys.executable, "-c", "print(flush=True)\n" + LISTENING, "run", "car_game", "--physics", "ideal",
         "--set", "learning.samples=100000", "-o", "/dev/null/x"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert process.stdout is not None
    process.stdout.readline()
    time.sleep(0.1 + after)
    process.send_signal(number)
    _, err = process.communicate(timeout=PATIENCE)
    if process.returncode != 2:  # it was done before
        assert process.returncode == 128 + number, err
        assert errors(err) == ["ichain: interrupted"]


def test_while_following(tmp_path: Path, small):
    """Three paths to go; the first has just begun."""
    status, _, err = interrupt(["run", "car_game", *small, "-o", str(tmp_path)], 25, following=True)
    assert status == STATUS, err
    assert errors(err) == ["ichain: interrupted; what was done so far is kept"]
    report = json.loads((tmp_path / "report.json").read_text())
    assert (report["reason"], report["goal_reached"]) == ("interrupted", False)
    assert report["control_steps"] == 3
    assert "eight" in report["metrics"]["paths"]
    assert (tmp_path / "playback.html").stat().st_size > 10**5
    assert (tmp_path / "paths.png").exists()
    assert len(list((tmp_path / "demonstrations").iterdir())) == 2


def test_teach_keeps_what_was_recorded(tmp_path: Path):
    arguments = ["teach", "car_game", "--physics", "ideal", "--set", "learning.samples=5000", "-o", str(tmp_path)]
    status, _, err = interrupt(arguments, 200)
    assert status == STATUS
    assert errors(err) == ["ichain: interrupted"]
    assert [f.name for f in tmp_path.iterdir()] == ["play.parquet"]
    assert len(pd.read_parquet(tmp_path / "play.parquet")) == 21


def test_evaluate_keeps_the_seeds_that_were_finished(tmp_path: Path):
    report = tmp_path / "report.json"
    arguments = [
        "evaluate",
        "car_game",
        "--physics",
        "ideal",
        "--methods",
        "first_link",
        "--trials",
        "50",
        "--report",
        str(report),
    ]
    status, out, err = interrupt(arguments, at="1 of 50")
    assert status == STATUS, err
    assert errors(err) == ["ichain: interrupted"]
    found = json.loads(report.read_text())
    assert found["reason"] == "interrupted"
    assert {row["seed"] for row in found["rows"]} == {0}
    assert "link:hand->joystick rest" in out
