"""`ichain cut`, and long recordings given to the commands that learn from states alone."""

import json
from pathlib import Path

import bath_log
import pytest
import yaml

from ichain_drake.cli.main import main
from ichain_drake.demonstrations import read_folder

PIECES = bath_log.pieces()
ENDS = [sum(len(p) for p in PIECES[: k + 1]) for k in range(len(PIECES))]


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """All pieces in one file, without a mark."""
    return bath_log.write_log(PIECES, tmp_path_factory.mktemp("logs"))


def test_pieces_and_a_table_are_written(log: Path, tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    folder = tmp_path / "demos"
    assert main(["cut", str(log), "-o", str(folder), "--robot", "hand", "--skills"]) == 0
    said = capsys.readouterr().out
    assert f"{len(PIECES) - 1} cuts, {len(PIECES)} pieces" in said
    assert "skill hand->lever" in said
    assert [len(p) for p in read_folder(folder)] == [len(p) for p in PIECES]
    table = json.loads((folder / "cuts.json").read_text())
    assert [c["row"] for c in table["cuts"]] == ENDS[:-1]
    assert all(c["sure"] > 0.5 and "reset" in c["why"] for c in table["cuts"])
    assert any("lever.x either way" in s["effect"] for s in table["skills"])
    assert main(["cut", str(log), "-o", str(folder), "--robot", "hand"]) == 2
    assert "holds 5 demonstrations already" in capsys.readouterr().err


def test_discover_takes_one_long_file(log: Path, tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    file = tmp_path / "graph.yaml"
    assert main(["discover", str(log), "-o", str(file), "--robot", "hand"]) == 0
    assert set(yaml.safe_load(file.read_text())["edges"]) == {"hand->lever", "lever->tank"}
    assert f"log.csv row {ENDS[0]} " in capsys.readouterr().err


def test_cuts_are_evaluated(tmp_path: Path) -> None:
    bath, report = str(Path(__file__).parents[2] / "examples" / "own_system" / "bath.py"), tmp_path / "report.json"
    options = ["--physics", "ideal", "--seed", "61000", "--trials", "1", "--report", str(report)]
    assert main(["evaluate", bath, "--methods", "cuts", *options]) == 0
    (line,) = json.loads(report.read_text())["table"]
    assert line["precision"] == 1.0
    assert line["recall"] >= 0.8


def test_a_log_of_another_rate_is_refused_whole(log: Path, tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    lines = log.read_text().splitlines()
    header = lines[0].split(",")
    at = header.index("time")
    rows = [line.split(",") for line in lines[1:]]
    quick = [",".join([*r[:at], str(0.1 * k), *r[at + 1 :]]) for k, r in enumerate(rows)]
    file = tmp_path / "quick.csv"
    file.write_text("\n".join([lines[0], *quick]))
    assert main(["cut", str(file), "-o", str(tmp_path / "demos"), "--robot", "hand"]) == 2
    assert "quick.csv: line 3, column time: 0.1 s since the previous row" in capsys.readouterr().err
    assert not list((tmp_path / "demos").iterdir())
