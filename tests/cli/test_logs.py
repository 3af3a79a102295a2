"""`ichain import` and `ichain export`: demonstrations of other formats, there and back."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from ichain_drake.demonstrations import Demonstration, read_demonstration, write_demonstration
from ichain_drake.timing import FRAME, TICK


@pytest.fixture
def demos(tmp_path: Path) -> Path:
    """A hand and a stick of the car game, in other units than its own."""
    rows = np.arange(8)
    columns = {"time": TICK * rows, "hand.x": 500.0 + rows, "hand.y": 0.0 * rows}
    columns |= {"joystick.x_axis": rows / 10, "joystick.y_axis": 0.0 * rows, "hand->joystick": 0.0 * rows + 1}
    folder = tmp_path / "demos"
    folder.mkdir()
    write_demonstration(Demonstration(pd.DataFrame(columns), {"hand.x": "mm", "hand.y": "mm"}), folder / "play.parquet")
    return folder


@pytest.mark.parametrize("form", ["lerobot", "mcap"])
def test_there_and_back_and_into_a_systems_units(form, demos, ichain, tmp_path):
    if form == "mcap":
        pytest.importorskip("mcap", reason="mcap is missing: pip install 'ichain_drake[logs]'")
    out = tmp_path / "out"
    assert ichain("export", form, demos, "-o", out).status == 0
    again = tmp_path / "again"
    done = ichain("import", form, out, "--map", out / "map.yaml", "-o", again, "--system", "car_game")
    assert done.status == 0
    assert "hand.x converted from mm to m" in done.err
    (file,) = again.iterdir()
    piece = read_demonstration(file)
    np.testing.assert_allclose(piece.table["hand.x"], 0.5 + np.arange(8) / 1000, rtol=1e-6)
    assert ichain("check", again, "--system", "car_game").status == 0
    refused = ichain("import", form, out, "--map", out / "map.yaml", "-o", again)
    assert refused.status == 2
    assert "holds 1 demonstrations already" in refused.err


def test_another_rate_is_taken_to_ours_only_if_asked_for(demos, ichain, tmp_path):
    pytest.importorskip("mcap", reason="mcap is missing: pip install 'ichain_drake[logs]'")
    file = demos / "play.parquet"
    piece = read_demonstration(file)
    write_demonstration(Demonstration(piece.table.assign(time=FRAME * np.arange(8)), piece.units), file)
    assert ichain("export", "mcap", demos, "-o", tmp_path / "out").status == 0
    read = ["import", "mcap", tmp_path / "out", "--map", tmp_path / "out" / "map.yaml", "-o"]
    refused = ichain(*read, tmp_path / "a", "--system", "car_game")
    assert refused.status == 2
    assert "--resample" in refused.err
    assert ichain(*read, tmp_path / "a").status == 0
    assert len(read_demonstration(next((tmp_path / "a").iterdir()))) == 8
    short = ichain(*read, tmp_path / "b", "--resample")
    assert short.status == 2
    assert "nothing of it is long enough for a piece" in short.err


def test_bad_maps_and_formats_are_one_line(demos, ichain, tmp_path):
    bad = tmp_path / "map.yaml"
    for text, what in [("columns: [", "malformed value"), ("a: 1", "a map has columns"), (b"\xff\xfe\xff", "no UTF-8")]:
        bad.write_bytes(text if isinstance(text, bytes) else text.encode())
        done = ichain("import", "lerobot", demos, "--map", bad, "-o", tmp_path / "x")
        assert done.status == 2
        assert what in done.err
        assert len(done.err.strip().splitlines()) == 1
    bad.write_text("columns: {a: cup.x}")
    assert "format 'avi': unknown" in ichain("import", "avi", demos, "--map", bad, "-o", tmp_path / "x").err
    assert "no such file" in ichain("import", "avi", demos, "--map", tmp_path / "no", "-o", tmp_path / "x").err.lower()
    assert "format 'avi': unknown" in ichain("export", "avi", demos, "-o", tmp_path / "y").err
    assert not (tmp_path / "x").exists()
