"""`ichain evaluate --methods calibration`: tables, report and pictures, of a goal and of a path."""

from pathlib import Path

import pytest

from ichain_drake.cli.evaluate_calibration import format_calibration
from ichain_drake.cli.main import main
from ichain_drake.systems import load_scenario

BATH = str(Path(__file__).parents[2] / "examples" / "own_system" / "bath.py")


def test_a_goal_and_a_path_are_judged(tmp_path: Path, capsys: pytest.CaptureFixture, strict_json) -> None:
    options = ["--physics", "ideal", "--seed", "41000", "--trials", "1", "--methods", "calibration"]
    assert main(["evaluate", BATH, *options, "-o", str(tmp_path / "bath")]) == 0
    said = capsys.readouterr().out
    assert "hand->tap" in said
    assert "basin.water" in said or "basin." in said
    report = strict_json((tmp_path / "bath" / "report.json").read_text())
    assert {line["interaction"] for line in report["statuses"]} == {"hand->tap", "tap->basin"}
    assert max(line["largest"] for line in report["statuses"]) <= 0.03
    for line in report["intervals"]:
        assert 0.8 < line["scaled"][1] <= 1.0
    for name in ("reliability.png", "coverage.png"):
        assert (tmp_path / "bath" / name).stat().st_size > 5000
    fast = ["--set", "learning.estimator=polynomial(degree=2)", "--set", "learning.samples=200"]
    assert main(["evaluate", "car_game", *options, *fast, "-o", str(tmp_path / "car")]) == 0
    report = strict_json((tmp_path / "car" / "report.json").read_text())
    assert report["statuses"] == []
    assert {line["variable"] for line in report["intervals"]} > {"joystick.x_axis", "car.speed"}
    assert not (tmp_path / "car" / "reliability.png").exists()
    assert (tmp_path / "car" / "coverage.png").exists()


def test_other_methods_beside_it_are_refused_in_one_line(capsys: pytest.CaptureFixture) -> None:
    assert main(["evaluate", BATH, "--physics", "ideal", "--methods", "calibration,monitors"]) == 2
    assert "monitors can't be evaluated beside calibration; ask for it by itself" in capsys.readouterr().err


def test_a_seed_that_failed_has_its_reason_and_nothing_else_is_printed() -> None:
    rows = [{"seed": 3, "reason": "no piece shows it"}]
    text = format_calibration(
        load_scenario("car_game", (), "ideal", 3), {"rows": rows, "statuses": [], "intervals": []}
    )
    assert text.startswith("seed 3: no piece shows it")
    assert (
        "learned from demonstrations of seeds 3-3, compared with those of 503-503, scaled by those of 1003-1003" in text
    )
