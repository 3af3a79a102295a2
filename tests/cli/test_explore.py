"""`ichain explore`."""

import json
from pathlib import Path

import pytest
import yaml

from ichain_drake.cli.main import main

BATH = str(Path(__file__).parents[2] / "examples" / "own_system" / "bath.py")


def test_what_it_leaves_behind_is_what_discover_reads(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    folder = tmp_path / "out"
    options = ["--seed", "41000", "--budget", "65", "--no-goal", "-o", str(folder)]
    assert main(["explore", BATH, *options]) == 1  # two pieces are too few to be sure
    assert "the budget is spent: 2 pieces, 60 s of the robot" in capsys.readouterr().out
    report = json.loads((folder / "report.json").read_text())
    assert (report["pieces"], report["samples"], report["robot_seconds"]) == (2, 180, 60.0)
    assert (report["known"], report["goal"], report["goal_reached"]) == (False, [], False)
    found = yaml.safe_load((folder / "graph.yaml").read_text())["edges"]
    again = tmp_path / "again.yaml"
    assert main(["discover", str(folder / "pieces"), "-o", str(again), "--system", BATH]) == 0
    assert yaml.safe_load(again.read_text())["edges"] == found
    assert found


@pytest.mark.parametrize(
    ("system", "options", "message"),
    [
        (BATH, ("--physics", "contact"), "would strike things; choose ideal or arm"),
        (BATH, ("--goal", "basin.level >= 0.5", "--no-goal"), "give one of the two"),
        (BATH, ("--goal", "basin.colour >= 0.5"), "colour"),
        (BATH, ("--budget", "20"), "a piece alone takes 30 s"),
        (BATH, ("--confidence", "0.2"), "confidence"),
        ("car_game", ("--goal", "car.x >= 5"), "--goal is not for it"),
        ("lidded_pot", (), "exploring"),
    ],
)
def test_what_can_not_be_explored_is_refused(
    system: str, options: tuple[str, ...], message: str, tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    assert main(["explore", system, *options, "-o", str(tmp_path / "out")]) == 2
    error = capsys.readouterr().err.strip().splitlines()[-1]
    assert error.startswith("ichain: ") and message in error
