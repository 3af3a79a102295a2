"""`ichain check`, `--resample`, and that nothing which was recorded is written over."""

import json
from pathlib import Path

import numpy as np
import pytest

from ichain_drake.cli.main import main
from ichain_drake.demonstrations import Demonstration, read_demonstration, write_demonstration
from ichain_drake.files import held


@pytest.fixture(scope="session")
def taught(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("checked")
    assert main(["teach", "car_game", "--physics", "ideal", "--set", "learning.samples=120", "-o", str(folder)]) == 0
    return folder


def test_a_report_as_text_json_and_page(taught, ichain, tmp_path, strict_json):
    done = ichain("check", taught, "--page", tmp_path / "p.html")
    assert done.status == 0
    assert "play.parquet: 122 rows" in done.out
    assert done.out.splitlines()[-1] == "nothing odd was found"
    assert "play.parquet" in (tmp_path / "p.html").read_text()
    report = strict_json(ichain("check", taught, "--system", "car_game", "--report", "-").out)
    assert [p["name"] for p in report["pieces"]] == ["drive.parquet", "play.parquet"]
    assert report["findings"] == []
    assert set(report["interactions"]) == {"hand->joystick", "joystick->car"}


def test_every_bad_piece_is_told_not_the_first_alone(taught, ichain, tmp_path):
    folder = tmp_path / "mixed"
    folder.mkdir()
    (folder / "play.parquet").write_bytes((taught / "play.parquet").read_bytes())
    (folder / "copy.parquet").write_bytes((taught / "play.parquet").read_bytes())
    (folder / "a.csv").write_text("no")
    (folder / "b.parquet").write_text("no")
    done = ichain("check", folder, "--report", tmp_path / "r.json")
    assert done.status == 2
    assert "2 of its pieces can't be used" in done.err
    report = json.loads((tmp_path / "r.json").read_text())
    assert len(report["refused"]) == 2
    assert report["findings"][0]["piece"] == "copy.parquet, play.parquet"


@pytest.mark.parametrize("name", ["nowhere", "x" * 300])
def test_a_folder_that_is_none(name, ichain, tmp_path):
    for command in (["check"], ["learn", "car_game", "-o", tmp_path / "lib", "--demos"]):
        done = ichain(*command, tmp_path / name)
        assert done.status == 2
        assert "demonstrations" in done.line


def faster(piece: Demonstration) -> Demonstration:
    """The same motion, told ten times as often: straight lines between the ticks."""
    table = piece.table
    time = np.arange(10 * (len(table) - 1) + 1) * (table["time"][1] / 10)
    wide = {c: np.interp(time, table["time"], table[c]) for c in table if "->" not in c and not c.startswith("command")}
    last = np.searchsorted(table["time"], time + 1e-9, side="right") - 1
    held_ = {c: table[c].to_numpy()[last] for c in table if c not in wide}
    return Demonstration(table.iloc[:0].reindex(range(len(time))).assign(**wide, **held_), piece.units, piece.name)


def test_a_log_of_another_rate_is_resampled_where_asked(taught, ichain, tmp_path):
    folder = tmp_path / "fast"
    folder.mkdir()
    for file in taught.glob("*.parquet"):
        write_demonstration(faster(read_demonstration(file)), folder / f"{file.stem}.csv")
    refused = ichain("learn", "car_game", "--demos", folder, "-o", tmp_path / "no")
    assert refused.status == 2
    assert (
        "0.03333 s since the previous row, 0.3333 s needed (the median is 0.03333 s, 30 Hz): --resample" in refused.line
    )
    small = ("--set", "learning.samples=120")
    done = ichain("learn", "car_game", "--demos", folder, "-o", tmp_path / "yes", *small, "--resample")
    assert done.status == 0, done.err
    assert "play.csv: 1211 rows every 0.03333 s" in done.err
    ichain("learn", "car_game", "--demos", taught, "-o", tmp_path / "as_it_was", "--set", "learning.samples=120")
    scores = [json.loads((tmp_path / d / "hand-joystick" / "manifest.json").read_text())["forward"]["score"]
              for d in ("yes", "as_it_was")]  # fmt: skip
    assert scores[0] == pytest.approx(scores[1], abs=1e-9)


def test_teach_does_not_write_over_pieces(taught, ichain, tmp_path):
    before = {f.name: f.read_bytes() for f in taught.iterdir()}
    done = ichain("teach", "car_game", "--physics", "ideal", "--seed", 7, "-o", taught)
    assert done.status == 2
    assert (
        "holds 2 demonstrations already (drive.parquet, play.parquet); give another folder, or --overwrite" in done.line
    )
    assert {f.name: f.read_bytes() for f in taught.iterdir()} == before
    own = tmp_path / "own"
    own.mkdir()
    (own / "play.parquet").write_bytes(b"mine")
    small = ("--physics", "ideal", "--set", "learning.samples=120")
    assert ichain("teach", "car_game", *small, "-o", own, "--overwrite").status == 0
    assert len(read_demonstration(own / "play.parquet")) == 122
    assert "--overwrite is for scripts" in ichain("teach", "car_game", "--browser", "--overwrite", "-o", own).line


def test_a_second_run_keeps_the_pieces_of_the_first(ichain, small, bend_csv, tmp_path):
    for seed in (0, 1):
        assert ichain("run", "car_game", *small, "--seed", seed, "--path", bend_csv, "-o", tmp_path).status == 0
    first, second = tmp_path / "demonstrations", tmp_path / "demonstrations-2"
    assert [f.name for f in sorted(second.iterdir())] == ["drive.parquet", "play.parquet"]
    assert (first / "play.parquet").read_bytes() != (second / "play.parquet").read_bytes()


def test_two_runs_at_once_do_not_mix(ichain, small, bend_csv, tmp_path):
    with held(tmp_path):
        done = ichain("run", "car_game", *small, "--path", bend_csv, "-o", tmp_path)
    assert done.status == 2
    assert "another run writes there now" in done.line
    assert not list(tmp_path.iterdir())


def test_nothing_is_written_twice_or_over_what_is_read(ichain, small, bend_csv, tmp_path):
    path = tmp_path / "path.html"
    path.write_bytes(bend_csv.read_bytes())
    for options, message in (
        (["--record", tmp_path / "a.html", "--report", tmp_path / "." / "a.html"], "something else of this run"),
        (["--record", path, "--path", path], "is what the run reads"),
        (["--report", tmp_path / "a.csv"], "is named like a table"),
        (["--record", tmp_path / "o" / "report.html", "--report", tmp_path / "o" / "paths.png"], "something else"),
    ):
        given = [] if "--path" in options else ["--path", bend_csv]
        done = ichain("run", "car_game", *small, *given, "-o", tmp_path / "o", *options)
        assert (done.status, message in done.line) == (2, True), done
    assert path.read_bytes() == bend_csv.read_bytes()
