"""`ichain evaluate`: one table, the same rows for any number of processes."""

import json
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from ichain_drake.cli.main import main
from ichain_drake.systems import SCENARIOS
from ichain_drake.systems.car_game.scenario import CarGame

ROW = {"method", "samples", "physics", "case", "seed", "success", "error", "paper_metric", "reason", "unit"}
LINE = {
    "method", "samples", "case", "runs", "completed", "mean_error", "std_error", "max_error", "ratio_to_oracle",
    "unit", "interval", "seeds",
}  # fmt: skip


class ShortGame(CarGame):
    """The car game with one path of six seconds in place of the three."""

    def reference_paths(self) -> Mapping[str, np.ndarray]:
        t = np.linspace(0.0, 1.0, 200)[:, None]
        return {"wave": np.concatenate([250 + 250 * t, 300 + 45 * np.sin(7 * t)], axis=1)}


@pytest.fixture(scope="module")
def evaluated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("evaluated")
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(SCENARIOS, "short_game", ShortGame)
        status = main(
            ["evaluate", "short_game", "--physics", "ideal", "--methods", "default,oracle,parent_t", "--trials", "1",
             "--report", str(folder / "report.json"), "-o", str(folder)]
        )  # fmt: skip
    assert status == 0
    return folder


def test_rows_and_table(evaluated, strict_json):
    report = strict_json((evaluated / "report.json").read_text())
    assert set(report) >= {"scenario", "physics", "seed", "trials", "versions", "given", "rows", "table", "reason"}
    assert report["physics"] == "ideal"
    rows, table = report["rows"], report["table"]
    assert all(set(row) == ROW for row in rows)
    assert all(set(line) == LINE for line in table)
    assert {line["unit"] for line in (*rows, *table)} == {"px"}
    # The learning curve of the default method, the other convention, the oracle.
    assert [(r["method"], r["samples"], r["case"]) for r in rows] == [
        *(("default", n, "wave") for n in (50, 100, 200, 500, 1000)),
        ("parent_t", 500, "wave"),
        ("oracle", 0, "wave"),
    ]
    assert len(table) == len(rows)
    for row in rows:
        assert (row["error"] is not None) == row["success"]
        assert bool(row["reason"]) != row["success"]


def test_the_default_method_is_near_the_oracle_and_the_other_convention_is_not(evaluated):
    table = json.loads((evaluated / "report.json").read_text())["table"]
    by_method = {(line["method"], line["samples"]): line for line in table}
    default, other = by_method["default", 500], by_method["parent_t", 500]
    assert default["completed"] == 1
    assert default["ratio_to_oracle"] < 1.4
    # The parent's state at t as action (paper sec. III speaks against it).
    assert other["completed"] == 0 or other["mean_error"] > 2 * default["mean_error"]
    assert (evaluated / "learning_curve.png").exists()


def test_the_first_link_has_the_same_rows_for_any_number_of_processes(ichain, tmp_path, strict_json):
    found = []
    for jobs in (1, 2):
        file = tmp_path / f"{jobs}.json"
        done = ichain(
            "evaluate",
            "car_game",
            "--physics",
            "ideal",
            "--methods",
            "first_link",
            "--set",
            "learning.samples=150",
            "--trials",
            2,
            "--jobs",
            jobs,
            "--report",
            file,
        )
        assert done.status == 0
        assert "rms error (1)" in done.out  # the axes' unit, not pixels
        found.append(strict_json(file.read_text()))
    assert found[0]["rows"] == found[1]["rows"]
    assert found[0]["table"] == found[1]["table"]
    rows = found[0]["rows"]
    assert [row["seed"] for row in rows] == [0, 0, 1, 1]
    assert [row["case"] for row in rows] == ["link:hand->joystick moving", "link:hand->joystick rest"] * 2
    for row, floor in zip(rows, (0.03, 0.02) * 2, strict=True):
        assert row["unit"] == "1"
        assert row["success"] is True
        assert row["true_error"] < row["error"] <= floor  # reads are noisy and rounded
        assert row["samples"] == 500


def test_a_report_to_stdout_is_all_there_is_on_stdout(ichain, strict_json, monkeypatch):
    monkeypatch.setitem(SCENARIOS, "short_game", ShortGame)
    done = ichain("evaluate", "short_game", "--physics", "ideal", "--methods", "oracle", "--trials", 1, "--report", "-")
    assert done.status == 0
    assert [row["case"] for row in strict_json(done.out)["rows"]] == ["wave"]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--methods", "magic"], "there is no method 'magic'; there are paper, default"),
        (["--methods", "default,magic"], "there is no method 'magic'"),
        (["--trials", "0"], "give numbers from 1"),
        (["--jobs", "0"], "give numbers from 1"),
        (["--fresh", "--shared"], "car_game follows paths: give one of --fresh and --shared"),
        (["--shared", "--methods", "first_link"], "first_link has no trials"),
        (["--physics", "unreal"], "physics 'unreal'"),
        (["--set", "learning.estimator=nix"], "there is no estimator 'nix'"),
    ],
)
def test_wrong_options(options, message, ichain):
    done = ichain("evaluate", "car_game", *options)
    assert done.status == 2
    assert message in done.line
    assert done.err.count("\n") == 1  # before any work


def test_a_report_that_cannot_be_written_is_refused_before_any_work(ichain, tmp_path):
    (tmp_path / "file").write_text("")
    done = ichain("evaluate", "car_game", "--report", tmp_path / "file" / "report.json")
    assert done.status == 2
    assert done.err.count("\n") == 1


def test_trials_may_share_demonstrations_for_any_number_of_processes(ichain, strict_json, monkeypatch, tmp_path):
    monkeypatch.setitem(SCENARIOS, "short_game", ShortGame)
    shared = ["evaluate", "short_game", "--physics", "ideal", "--methods", "paper@50,oracle", "--shared", "--trials", 6]
    found = []
    for jobs in (1, 2):
        file = tmp_path / f"{jobs}.json"
        done = ichain(*shared, "--jobs", jobs, "--report", file)
        assert done.status == 0
        assert "all with the demonstrations of seed 0" in done.out
        found.append(strict_json(file.read_text()))
    assert found[0]["rows"] == found[1]["rows"]
    assert {(row["seed"], row["demonstrations"]) for row in found[0]["rows"]} == {(k, "seed 0") for k in range(6)}
    done = ichain(*shared, "--report", tmp_path / "1.json", "--resume")
    assert done.status == 0
    assert strict_json((tmp_path / "1.json").read_text())["rows"] == found[0]["rows"]
