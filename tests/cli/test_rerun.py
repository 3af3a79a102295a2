"""`ichain run --rerun FILE.rrd`: written beside the playback, and refused before any work."""

import sys

import pytest
from rrd import read_rrd


def test_a_recording_is_written_beside_the_playback(ichain, small, bend_csv, tmp_path):
    pytest.importorskip("rerun", reason="rerun is missing: pip install 'ichain_drake[rerun]'")
    file = tmp_path / "films" / "bend.rrd"
    done = ichain("run", "car_game", *small, "--path", bend_csv, "-o", tmp_path / "o", "--rerun", file)
    assert done.status == 0
    assert f"written: {file}" in done.out
    assert (tmp_path / "o" / "playback.html").exists()
    assert "/measured/car/x" in {entity for entity, _ in read_rrd(file)}


def test_what_can_not_be_is_told_before_anything_is_done(ichain, small, bend_csv, tmp_path, monkeypatch):
    def told(*more):
        done = ichain("run", "car_game", *small, "--path", bend_csv, "-o", tmp_path / "o", *more)
        assert done.status == 2
        assert not (tmp_path / "o" / "demonstrations").exists()
        return done.line

    assert "--rerun film.html: a recording for rerun ends in .rrd" in told("--rerun", "film.html")
    monkeypatch.setitem(sys.modules, "rerun", None)
    missing = told("--rerun", tmp_path / "film.rrd")
    assert "a recording for rerun needs rerun, which is missing; install it with" in missing
    assert "pip install 'ichain_drake[rerun]'" in missing


def test_it_is_written_over_nothing_of_the_run(ichain, small, bend_csv, tmp_path):
    pytest.importorskip("rerun", reason="rerun is missing: pip install 'ichain_drake[rerun]'")
    file = tmp_path / "same.rrd"
    done = ichain(
        "run", "car_game", *small, "--path", bend_csv, "-o", tmp_path / "o", "--rerun", file, "--report", file
    )
    assert done.status == 2
    assert "same.rrd: is where something else of this run is written" in done.line
    (tmp_path / "folder.rrd").mkdir()
    done = ichain(
        "run", "car_game", *small, "--path", bend_csv, "-o", tmp_path / "o", "--rerun", tmp_path / "folder.rrd"
    )
    assert done.status == 2
    assert "folder.rrd: is a folder" in done.line
