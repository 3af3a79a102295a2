"""Ctrl-C: status 130, one line, and what was done up to then is on disk. In processes of their own."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pandas as pd
from patience import PATIENCE

STATUS = 130

# A shell's background jobs, and some test runners, ignore SIGINT; a child would inherit that.
LISTENING = """
import os, signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
from ichain_drake.cli.main import main
from ichain_drake.simulation.watching import watched_by

class Impatient:
    frames, following = int(os.environ["PRESS_AT_FRAME"]), bool(int(os.environ["PRESS_WHILE_FOLLOWING"]))
    count = 0

    def begin(self, episode):
        pass

    def frame(self, episode):
        self.count += (episode.path is not None) == self.following
        if self.count == self.frames:
            os.kill(os.getpid(), signal.SIGINT)
        return False

with watched_by(Impatient()):
    sys.exit(main())
"""


def interrupt(
    arguments: list[str], frame: int = 0, *, following: bool = False, at: str | None = None
) -> tuple[int, str, str]:
    """Run `ichain` and send it SIGINT; gives status, stdout and stderr.

    Args:
        arguments: of the command.
        frame: in which it gets the signal, counted from the first of an episode's; 0 for in none.
        following: whether frames count in which a path is followed, or those of all others.
        at: a text that it says before it gets the signal, in place of a frame.
    """
    environment = {"OMP_NUM_THREADS": "1", "PRESS_AT_FRAME": str(frame), "PRESS_WHILE_FOLLOWING": str(int(following))}
    process = subprocess.Popen(
        [sys.executable, "-c", LISTENING, *arguments],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=os.environ | environment,
    )  # fmt: skip
    assert process.stderr is not None
    said = ""
    if at is not None:
        for line in process.stderr:
            said += line
            if at in line:
                process.send_signal(signal.SIGINT)
                break
    out, err = process.communicate(timeout=PATIENCE)
    return process.returncode, out, said + err


def errors(stderr: str) -> list[str]:
    return [line for line in stderr.splitlines() if not line.startswith("[")]


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
