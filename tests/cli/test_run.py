"""`ichain run`: what it writes, what it says, and that it says the same twice."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

KEYS = {
    "scenario", "physics", "seed", "goal_reached", "reason", "control_steps", "sim_seconds", "wall_seconds", "versions",
    "given", "models", "metrics",
}  # fmt: skip
FLAT = {"mean_error_px", "paper_metric_px", "completed", "reason", "oracle_error_px", "oracle_reason", "unit"}


def test_a_run_writes_report_playback_picture_and_demonstrations(ran, strict_json):
    assert (ran / "playback.html").stat().st_size > 10**5
    assert (ran / "paths.png").read_bytes().startswith(b"\x89PNG")
    assert sorted(f.name for f in (ran / "demonstrations").iterdir()) == ["drive.parquet", "play.parquet"]
    report = strict_json((ran / "report.json").read_text())
    assert set(report) >= KEYS
    assert (report["scenario"], report["physics"], report["seed"]) == ("car_game", "ideal", 0)
    assert report["goal_reached"] is True
    assert report["control_steps"] * 10 == round(report["sim_seconds"] * 30)
    assert set(report["versions"]) >= {"python", "drake", "numpy", "scikit-learn", "ichain_drake"}
    assert report["given"]["path"]["speed"] == 45.0
    assert set(report["models"]) == {"hand->joystick", "joystick->car"}
    for name, seconds in (("hand->joystick", 121 / 3), ("joystick->car", 0.0)):
        model = report["models"][name]
        assert model["samples"] == 120
        assert model["robot_seconds"] == pytest.approx(seconds)
        assert 0.5 < model["cross_validation_score"] <= 1
        assert model["source"] == "demonstrations"


def test_metrics_are_there_by_path_and_flat_when_there_is_one(ran):
    metrics = json.loads((ran / "report.json").read_text())["metrics"]
    assert set(metrics["paths"]["bend"]) == FLAT
    assert {k: metrics[k] for k in FLAT} == metrics["paths"]["bend"]
    assert 0.2 < metrics["mean_error_px"] < 2.0
    assert metrics["unit"] == "px"
    assert (metrics["oracle_error_px"], metrics["oracle_reason"]) == (None, "the oracle was not run")


def test_metrics_of_two_paths_are_not_flat(ichain, small, tmp_path):
    done = ichain("run", "car_game", *small, "--paths", "spiral", "eight", "-o", tmp_path)
    assert done.status == 0
    assert "every path was followed" in done.out
    metrics = json.loads((tmp_path / "report.json").read_text())["metrics"]
    assert list(metrics) == ["paths"]
    assert list(metrics["paths"]) == ["spiral", "eight"]


def test_the_oracle_runs_where_it_is_asked_for(ichain, small, bend_csv, tmp_path):
    done = ichain("run", "car_game", *small, "--oracle", "--path", bend_csv, "-o", tmp_path)
    assert done.status == 0
    assert "oracle (px)" in done.out
    metrics = json.loads((tmp_path / "report.json").read_text())["metrics"]
    assert 0.3 < metrics["oracle_error_px"] < metrics["mean_error_px"] + 0.2
    assert metrics["oracle_reason"] == ""


def test_two_runs_give_the_same_report(ran, ichain, small, bend_csv, tmp_path):
    again = ichain("run", "car_game", *small, "--path", bend_csv, "-o", tmp_path)
    assert again.status == 0
    first, second = (json.loads((f / "report.json").read_text()) for f in (ran, tmp_path))
    for report in (first, second):
        del report["wall_seconds"], report["versions"]
    assert first == second
    assert (ran / "playback.html").read_bytes() == (tmp_path / "playback.html").read_bytes()


def test_another_seed_gives_another_run(ran, ichain, small, bend_csv, tmp_path):
    assert ichain("run", "car_game", *small, "--path", bend_csv, "-o", tmp_path, "--seed", 1).status == 0
    first, second = (json.loads((f / "report.json").read_text()) for f in (ran, tmp_path))
    assert first["metrics"]["mean_error_px"] != second["metrics"]["mean_error_px"]


def test_a_report_to_stdout_is_all_there_is_on_stdout(ichain, small, bend_csv, tmp_path, strict_json):
    done = ichain("run", "car_game", *small, "--path", bend_csv, "-o", tmp_path, "--report", "-")
    assert done.status == 0
    assert strict_json(done.out)["goal_reached"] is True
    assert not (tmp_path / "report.json").exists()
    assert (tmp_path / "playback.html").exists()


def test_files_go_where_they_are_told(ichain, small, bend_csv, tmp_path):
    record, report = tmp_path / "a" / "film.html", tmp_path / "b" / "r.json"
    done = ichain(
        "run", "car_game", *small, "--path", bend_csv, "-o", tmp_path / "c", "--record", record, "--report", report
    )
    assert done.status == 0
    assert record.exists() and json.loads(report.read_text())["goal_reached"]
    assert sorted(f.name for f in (tmp_path / "c").iterdir()) == ["demonstrations", "paths.png"]


def test_the_installed_command_logs_lines_and_keeps_stdout_clean(bend_csv, tmp_path, small, strict_json):
    """As a process of its own, its output in pipes: no bar, no escape code, nothing but JSON on stdout."""
    command = [sys.executable, "-m", "ichain_drake", "run", "car_game", *small, "--path", str(bend_csv)]
    environment = os.environ | {"OMP_NUM_THREADS": "1"}
    done = subprocess.run(
        [*command, "-o", str(tmp_path), "--report", "-"], capture_output=True, text=True, env=environment, check=False
    )
    assert done.returncode == 0, done.stderr
    assert strict_json(done.stdout)["metrics"]["completed"] is True
    assert "\x1b" not in done.stderr and "\r" not in done.stderr
    lines = done.stderr.splitlines()
    assert len(lines) > 4
    assert all(line.startswith("[") for line in lines), done.stderr


def test_a_goal_that_is_not_reached_says_why(ichain, tmp_path):
    """The paper's method on a hundred transitions in a game six times as noisy loses the car."""
    done = ichain(
        "run", "car_game", "--physics", "ideal", "--paths", "eight", "-o", tmp_path,
        "--set", "learning.samples=120", "--set", "noise.scale=6", "--set", "control.method=inverse",
    )  # fmt: skip
    assert done.status == 1
    assert done.err.count("Traceback") == 0
    report = json.loads((tmp_path / "report.json").read_text())
    assert report["goal_reached"] is False
    assert report["reason"].startswith("the end was not reached on: eight (")
    assert report["metrics"]["completed"] is False
    assert "the end was not reached on: eight" in done.out
    assert (tmp_path / "playback.html").exists()


def test_an_unreachable_start_is_reported_with_status_1(ichain, bend_csv, tmp_path):
    """A joystick three metres away: the arm says so, and the report is kept."""
    done = ichain(
        "run", "car_game", "--physics", "arm", "--path", bend_csv, "-o", tmp_path,
        "--set", "robot.home={x: 0.85, y: 0.85, z: 1.0}", "--set", "learning.samples=60",
        "--set", "robot.hand.surface=null", "--set", "robot.hand.held={z: 1.0, grip: 1}",
    )  # fmt: skip
    assert done.status == 1
    report = json.loads((tmp_path / "report.json").read_text())
    assert report["goal_reached"] is False
    assert report["reason"] in " ".join(done.line.split())


def test_a_link_in_place_of_the_report_stays_a_link(ichain, small, bend_csv, tmp_path: Path):
    target = tmp_path / "kept" / "r.json"
    target.parent.mkdir()
    target.write_text("old")
    (tmp_path / "r.json").symlink_to(target)
    done = ichain("run", "car_game", *small, "--path", bend_csv, "-o", tmp_path / "o", "--report", tmp_path / "r.json")
    assert done.status == 0
    assert (tmp_path / "r.json").is_symlink()
    assert json.loads(target.read_text())["goal_reached"] is True
