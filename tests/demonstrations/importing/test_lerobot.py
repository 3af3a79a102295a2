"""LeRobot data sets: versions, episodes over several files, and what is refused."""

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from lerobot_set import data_set

from ichain_drake.demonstrations.importing import import_logs, parse_map
from ichain_drake.errors import InputError

MAP = parse_map(
    {"columns": {"observation.state[y]": "cup.y [mm]", "observation.state[0]": "cup.x", "done": "cup.full"}}, "m"
)


@pytest.mark.parametrize("version", ["v2.1", "v3.0"])
@pytest.mark.parametrize("files", [1, 2, 4])
def test_every_episode_is_a_piece(tmp_path: Path, version: str, files: int) -> None:
    pieces = import_logs("lerobot", data_set(tmp_path / "set", version, files), MAP)
    assert [p.name for p in pieces] == ["episode_000000", "episode_000001"]
    second = pieces[1]
    assert list(second.table) == ["time", "cup.y", "cup.x", "cup.full"]
    np.testing.assert_array_equal(second.table["time"], np.arange(4) / 10)
    np.testing.assert_array_equal(second.table["cup.x"], [8, 10, 12, 14])
    np.testing.assert_array_equal(second.table["cup.y"], [9, 11, 13, 15])
    np.testing.assert_array_equal(second.table["cup.full"], [0, 0, 0, 1])
    assert second.units == {"cup.y": "mm"}


def test_the_map_may_name_the_time_or_the_rate(tmp_path: Path) -> None:
    folder = data_set(tmp_path / "set", fps="ten")
    with pytest.raises(InputError, match="fps 'ten' in meta/info.json; give rate in the map"):
        import_logs("lerobot", folder, MAP)
    fast = parse_map({"columns": {"done": "cup.full"}, "rate": 5}, "m")
    assert import_logs("lerobot", folder, fast)[0].period == pytest.approx(0.2)
    timed = parse_map({"columns": {"done": "cup.full"}, "rate": 5, "time": "timestamp"}, "m")
    assert import_logs("lerobot", folder, timed)[0].period == pytest.approx(0.1)


@pytest.mark.parametrize(
    ("source", "what"),
    [
        ("observation.velocity", "it has no column observation.velocity; the data set has observation.state"),
        ("observation.state", "has 2 numbers; say which"),
        ("observation.state[z]", "there are places 0 to 1, or x, y"),
    ],
)
def test_a_source_that_is_not_there_is_told(tmp_path: Path, source: str, what: str) -> None:
    with pytest.raises(InputError, match=what):
        import_logs("lerobot", data_set(tmp_path / "set"), parse_map({"columns": {source: "cup.x"}}, "m"))


def test_what_a_description_says_of_files_is_not_followed(tmp_path: Path) -> None:
    folder = data_set(tmp_path / "set", data_path="{chunk_index.__class__}/{file_index:0999999999d}/../../etc/passwd")
    assert len(import_logs("lerobot", folder, MAP)) == 2


def test_what_is_no_data_set_is_refused_in_one_line(tmp_path: Path) -> None:
    def told(folder: Path) -> str:
        with pytest.raises(InputError) as error:
            import_logs("lerobot", folder, MAP)
        assert "\n" not in str(error.value)
        return str(error.value)

    assert "no such folder" in told(tmp_path / "none")
    assert "codebase_version 'v9.9'; data sets of v2.0, v2.1, v3.0 are read" in told(data_set(tmp_path / "new", "v9.9"))
    folder = data_set(tmp_path / "set")
    (folder / "meta" / "info.json").write_text("[" * 10**5)
    assert "it is no JSON" in told(folder)
    (folder / "meta" / "info.json").write_text('["v3.0"]')
    assert "codebase_version 'None'" in told(folder)
    folder = data_set(tmp_path / "torn")
    (folder / "data" / "chunk-000" / "file-000.parquet").write_bytes(b"PAR1 and no more")
    assert "can't read the data set" in told(folder)
    for file in (folder / "data" / "chunk-000").iterdir():
        file.unlink()
    assert "data/*/*.parquet is missing" in told(folder)


def test_rows_without_an_episode_and_cells_of_all_sizes_are_refused(tmp_path: Path) -> None:
    folder = data_set(tmp_path / "set", files=1)
    file = folder / "data" / "chunk-000" / "file-000.parquet"
    columns = {"episode_index": [0, None], "frame_index": [0, 1], "done": [0, 1], "odd": [[1.0], [1.0, 2.0]]}
    pq.write_table(pa.table(columns), file)
    with pytest.raises(InputError, match="episode_index or frame_index is no number"):
        import_logs("lerobot", folder, parse_map({"columns": {"done": "cup.full"}}, "m"))
    with pytest.raises(InputError, match="cells of odd differ in size"):
        import_logs("lerobot", folder, parse_map({"columns": {"odd[0]": "cup.full"}}, "m"))
