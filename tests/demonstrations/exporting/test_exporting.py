"""Export and import again: the same tables; and what can't be exported."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
import yaml

from ichain_drake.demonstrations import Demonstration
from ichain_drake.demonstrations.exporting import export_pieces
from ichain_drake.demonstrations.importing import import_logs, parse_map
from ichain_drake.errors import InputError
from ichain_drake.timing import TICK


def piece(name: str, rows: int = 4, **more: object) -> Demonstration:
    rng = np.random.default_rng(rows)
    table = pd.DataFrame(
        {
            "time": TICK * np.arange(rows),
            "hand.x": rng.standard_normal(rows),
            "cup.x": rng.standard_normal(rows),
            "cup.level": rng.random(rows),
            "command.x": rng.standard_normal(rows),
            "hand->cup": (np.arange(rows) % 2).astype(float),
            **more,
        }
    )
    return Demonstration(table, {"hand.x": "m", "cup.x": "m", "command.x": "m"}, f"{name}.parquet")


def back(form: str, folder: Path) -> list[Demonstration]:
    return import_logs(form, folder, parse_map(yaml.safe_load((folder / "map.yaml").read_text()), "map"))


def test_mcap_comes_back_to_the_last_bit(tmp_path: Path) -> None:
    pytest.importorskip("mcap", reason="mcap is missing: pip install 'ichain_drake[logs]'")
    pieces = [piece("a"), piece("b", 7)]
    assert export_pieces("mcap", pieces, tmp_path / "out") == [tmp_path / "out"]
    for one, other in zip(pieces, back("mcap", tmp_path / "out"), strict=True):
        assert Path(one.name).stem == other.name
        pd.testing.assert_frame_equal(one.table, other.table[list(one.table)], check_exact=True)
        assert one.units == other.units


def test_lerobot_comes_back_in_single_precision_and_describes_itself(tmp_path: Path) -> None:
    pieces = [piece("a"), piece("b", 7)]
    export_pieces("lerobot", pieces, tmp_path / "out", "fill the cup")
    for one, other in zip(pieces, back("lerobot", tmp_path / "out"), strict=True):
        single = one.table.drop(columns="time").astype(np.float32).astype(float)
        pd.testing.assert_frame_equal(single, other.table[list(single)], check_exact=True)
        np.testing.assert_allclose(other.table["time"], one.table["time"], rtol=1e-12)
        assert one.units == other.units
    meta = tmp_path / "out" / "meta"
    info = json.loads((meta / "info.json").read_text())
    assert (info["codebase_version"], info["fps"], info["total_episodes"], info["total_frames"]) == ("v3.0", 3, 2, 11)
    state = {"dtype": "float32", "shape": [3], "names": ["hand.x", "cup.x", "cup.level"]}
    assert info["features"]["observation.state"] == state
    assert info["features"]["action"] == {"dtype": "float32", "shape": [1], "names": ["command.x"]}
    episodes = pq.read_table(meta / "episodes" / "chunk-000" / "file-000.parquet").to_pylist()
    assert [e["length"] for e in episodes] == [4, 7]
    assert [e["dataset_from_index"] for e in episodes] == [0, 4]
    assert episodes[1]["tasks"] == ["fill the cup"]
    assert pd.read_parquet(meta / "tasks.parquet").loc["fill the cup", "task_index"] == 0
    data = pq.read_table(tmp_path / "out" / "data" / "chunk-000" / "file-000.parquet").to_pydict()
    assert data["index"] == list(range(11))
    assert data["frame_index"] == [0, 1, 2, 3, 0, 1, 2, 3, 4, 5, 6]
    stats = json.loads((meta / "stats.json").read_text())
    assert stats["observation.state"]["max"] == np.max(data["observation.state"], axis=0).tolist()
    assert stats["action"]["count"] == [11]


def test_pieces_that_hold_different_things_get_folders_of_their_own(tmp_path: Path) -> None:
    pieces = [piece("a"), piece("b", 5, **{"lid.open": 1.0}), piece("c", 6)]
    assert export_pieces("lerobot", pieces, tmp_path) == [tmp_path / "a", tmp_path / "b"]
    assert [len(p) for p in back("lerobot", tmp_path / "a")] == [4, 6]
    assert list(back("lerobot", tmp_path / "b")[0].table["lid.open"]) == [1.0] * 5


def test_what_can_not_be_exported_is_refused_and_nothing_written(tmp_path: Path) -> None:
    def told(form: str, *pieces: Demonstration, folder: Path = tmp_path / "out") -> str:
        with pytest.raises(InputError) as error:
            export_pieces(form, pieces, folder)
        assert folder == tmp_path or not folder.exists()
        return str(error.value)

    assert "format 'avi': unknown" in told("avi", piece("a"))
    assert "two pieces are called a" in told("lerobot", piece("a"), piece("a"))
    assert "no piece is given" in told("lerobot")
    assert "column odd is no object.variable" in told("lerobot", piece("a", odd=1.0))
    assert "it has empty cells" in told("lerobot", piece("a", **{"lid.open": np.nan}))
    slow = piece("a")
    slow = Demonstration(slow.table.assign(time=1.5 * np.arange(4)), slow.units, "slow")
    assert "slow: LeRobot has a whole number of rows a second" in told("lerobot", slow)
    assert "there is nothing to write" in told("lerobot", Demonstration(slow.table[["time"]], {}, "bare"))
    (tmp_path / "x").write_text("")
    assert "holds something already" in told("lerobot", piece("a"), folder=tmp_path)
