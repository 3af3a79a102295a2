"""Folders and files as people hand them in: indices of time, units, hidden files, other people's Parquet."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from ichain_drake.demonstrations import read_demonstration, read_demonstrations, read_folder
from ichain_drake.demonstrations.parquet import parquet_bytes
from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.state import StateSpace, Variable
from ichain_drake.timing import TICK

GRAPH = InteractionGraph(
    {
        "arm": StateSpace("arm", (Variable("x", "m", -1, 1),)),
        "kart": StateSpace("kart", (Variable("place", "px"), Variable("h", "rad", -np.pi, np.pi, "angle"))),
    },
    ["arm->kart"],
)
TIMES = TICK * np.arange(4)
TABLE = pd.DataFrame({"kart.place": [1.0, 2.0, 4.0, 7.0], "kart.h": [0.0, 0.1, 0.2, 0.3]})


def test_an_index_of_time_is_the_column_of_time(tmp_path: Path) -> None:
    TABLE.set_index(pd.Index(TIMES, name="time")).to_csv(tmp_path / "named.csv")
    TABLE.set_index(pd.Index(TIMES)).to_csv(tmp_path / "unnamed.csv")
    TABLE.set_index(pd.Index(TIMES, name="time")).to_parquet(tmp_path / "named.parquet")
    TABLE.set_index(pd.Index(TIMES)).to_parquet(tmp_path / "unnamed.parquet")
    TABLE.set_index(pd.to_timedelta(TIMES, unit="s")).to_parquet(tmp_path / "spans.parquet")
    moments = pd.Timestamp("2026-01-02 03:04:05") + pd.to_timedelta(TIMES, unit="s")
    TABLE.set_index(moments).to_parquet(tmp_path / "moments.parquet")
    TABLE.assign(time=moments).to_csv(tmp_path / "moments.csv", index=False)
    TABLE.assign(time=TIMES).to_csv(tmp_path / "counted.csv")  # an index that only counts rows is nothing
    TABLE.assign(time=TIMES).set_index(pd.Index(range(4), name="index")).to_parquet(tmp_path / "counted.parquet")
    for piece in read_demonstrations(tmp_path, GRAPH):
        np.testing.assert_allclose(piece.table["time"], TIMES, atol=1e-6, err_msg=piece.name)
        assert len(piece.table.columns) == 3, piece.name


def test_other_endings_and_files_that_are_none(tmp_path: Path) -> None:
    for name in ("A.CSV", "b.csv.gz"):
        TABLE.assign(time=TIMES).to_csv(tmp_path / name, index=False)
    for name in ("._A.csv", ".DS_Store", "notes.docx", "A.json"):
        (tmp_path / name).write_bytes(b"\0\5\x16\7")
    (tmp_path / "sub").mkdir()
    said: list[str] = []
    assert [p.name for p in read_folder(tmp_path, said.append)] == ["A.CSV", "b.csv.gz"]
    assert said == [
        "passed over: .DS_Store (hidden)",
        "passed over: ._A.csv (hidden)",
        "passed over: notes.docx (neither .parquet nor .csv)",
        "passed over: sub (neither .parquet nor .csv)",
    ]


def test_units_are_converted_where_they_can_be(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(
        "time [ms],arm.x [mm],kart.place [px],kart.h [deg]\n0,100,1,0\n333.333,200,2,90\n666.667,300,3,180\n"
    )
    said: list[str] = []
    (piece,) = read_demonstrations(tmp_path, GRAPH, say=said.append)
    assert piece.table["arm.x"].to_list() == pytest.approx([0.1, 0.2, 0.3])
    assert piece.table["kart.h"].to_list() == pytest.approx([0, np.pi / 2, np.pi])
    assert piece.units["arm.x"] == "m"
    assert "a.csv: arm.x converted from mm to m" in said
    (tmp_path / "b.csv").write_text("time,kart.place [m],kart.h\n0,100,0\n0.3333,200,0\n")
    with pytest.raises(InputError, match=r"b\.csv: column kart\.place is in m, but px is needed, and there is no way"):
        read_demonstrations(tmp_path, GRAPH)


@pytest.mark.parametrize("about", ["[1]", "null", '{"units": null}', '{"units": [1]}', '{"units": {"a": 1}}', "nope"])
def test_metadata_that_is_not_ours_is_one_line(about: str, tmp_path: Path) -> None:
    stored = pa.Table.from_pandas(TABLE.assign(time=TIMES)).replace_schema_metadata({b"ichain_drake": about.encode()})
    pq.write_table(stored, tmp_path / "a.parquet")
    with pytest.raises(InputError, match=r"a\.parquet: can't read the demonstration: its metadata is"):
        read_demonstration(tmp_path / "a.parquet")


@pytest.mark.parametrize("about", ["{}", "[]", "null", "{", '{"index_columns": ["nope"]}'])
def test_what_pandas_says_about_its_index_is_not_needed(about: str, tmp_path: Path) -> None:
    stored = pa.Table.from_pandas(TABLE.assign(time=TIMES)).replace_schema_metadata({b"pandas": about.encode()})
    pq.write_table(stored, tmp_path / "a.parquet")
    read_demonstration(tmp_path / "a.parquet").check(GRAPH)


def test_folders_do_not_become_columns(tmp_path: Path) -> None:
    (tmp_path / "run=1").mkdir()
    (tmp_path / "run=1" / "a.parquet").write_bytes(parquet_bytes(TABLE.assign(time=TIMES), {}))
    assert "run" not in read_demonstration(tmp_path / "run=1" / "a.parquet").table


def test_a_table_of_lerobot_says_what_to_do(tmp_path: Path) -> None:
    frame = pd.DataFrame(
        {
            "observation.state": [[0.1, 0.2]] * 3, "action": [[0.1, 0.2]] * 3, "timestamp": [0.0, 0.02, 0.04],
            "frame_index": range(3), "episode_index": 0, "index": range(3), "task_index": 0,
        }
    )  # fmt: skip
    frame.to_parquet(tmp_path / "episode_000000.parquet")
    with pytest.raises(InputError, match=r"this is a table of LeRobot; .*ichain import lerobot .*--resample"):
        read_demonstrations(tmp_path, GRAPH)


def test_a_time_by_another_name_is_found(tmp_path: Path) -> None:
    TABLE.assign(timestamp=TIMES).to_csv(tmp_path / "a.csv", index=False)
    with pytest.raises(InputError, match="column time is missing; rename timestamp, if that is the time of each row"):
        read_demonstrations(tmp_path, GRAPH)


def test_lists_and_text_in_columns_are_no_numbers(tmp_path: Path) -> None:
    frame = TABLE.assign(time=TIMES)
    frame["kart.h"] = [[1.0]] * 4
    frame.to_parquet(tmp_path / "a.parquet")
    with pytest.raises(InputError, match=r"line 2, column kart\.h: not a finite number"):
        read_demonstrations(tmp_path, GRAPH)


def test_more_values_than_are_read_are_refused_unread(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ichain_drake.demonstrations.parquet_claims.MOST_CELLS", 10)
    (tmp_path / "a.parquet").write_bytes(parquet_bytes(TABLE.assign(time=TIMES), {}))
    with pytest.raises(InputError, match="it claims 12 values, and 10 are read at most"):
        read_demonstration(tmp_path / "a.parquet")


def test_units_in_parquet_come_back(tmp_path: Path) -> None:
    (tmp_path / "a.parquet").write_bytes(parquet_bytes(TABLE, {"kart.h": "deg"}))
    assert json.loads(json.dumps(dict(read_demonstration(tmp_path / "a.parquet").units))) == {"kart.h": "deg"}
