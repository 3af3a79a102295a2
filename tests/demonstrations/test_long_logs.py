"""Logs beyond memory: the same stretches as of a log in memory, with memory that doesn't depend on the log's length."""

from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from peak import taking_less_than

from ichain_drake.demonstrations import Demonstration, long_logs, read_demonstration, write_demonstration
from ichain_drake.demonstrations.long_logs import read_enough
from ichain_drake.demonstrations.parquet_claims import TooMuchError, read_claims
from ichain_drake.demonstrations.reading import prepare, read_demonstrations
from ichain_drake.demonstrations.thinning import Bound, thinned
from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.state import StateSpace, Variable

SPACE = StateSpace("thing", (Variable("x", "m"), Variable("y", "m")))
GRAPH = InteractionGraph({"hand": SPACE, "box": SPACE, "lid": SPACE}, ["hand->box", "box->lid"])
BOUND = Bound(1_000, 50)


def table(rows: int, seed: int = 0, period: float = 1 / 3) -> pd.DataFrame:
    random = np.random.default_rng(seed)
    data = {"time": period * np.arange(rows)}
    data |= {f"{o}.{v}": random.normal(size=rows) for o in GRAPH.objects for v in SPACE.names}
    for edge, every in (("hand->box", 97), ("box->lid", rows // 2)):
        data[edge] = (np.arange(rows) // every) % 2
    return pd.DataFrame(data)


def write(folder: Path, rows: int, name: str = "a.parquet", **how) -> Path:
    units = {c: "m" for c in table(2) if "." in c}
    write_demonstration(Demonstration(table(rows, **how), units, name), folder / name)
    return folder / name


@pytest.fixture(autouse=True)
def small_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(long_logs, "MOST_CELLS", 50_000)
    monkeypatch.setattr(long_logs, "MOST_AT_ONCE", 100_000)


def test_stretches_are_those_of_the_whole_log(tmp_path: Path) -> None:
    for name, rows in (("a.parquet", 40_000), ("b.csv", 3_000), ("c.parquet", 60)):
        write(tmp_path, rows, name)
    said: list[str] = []
    found = read_enough(tmp_path, GRAPH, BOUND, say=said.append)
    whole = [read_demonstration(tmp_path / name) for name in ("a.parquet", "b.csv", "c.parquet")]
    wanted = thinned(whole, GRAPH, BOUND)
    assert [p.name for p in found] == [p.name for p in wanted]
    for piece, other in zip(found, wanted, strict=True):
        pd.testing.assert_frame_equal(piece.table, other.table)
        assert (piece.units, piece.first_line) == (other.units, other.first_line)
    rows = sum(map(len, found))
    assert 0.9 * BOUND.rows < rows <= BOUND.rows
    assert said == [
        f"{tmp_path}: {rows} of 43060 rows are read: stretches that show every change of status, and evenly of the rest"
    ]
    assert {name.split(" ")[0] for name in (p.name for p in found)} >= {"a.parquet", "b.csv"}
    assert read_demonstrations(tmp_path, GRAPH, bound=BOUND)[0].name == found[0].name


def test_what_fits_is_read_as_it_is(tmp_path: Path) -> None:
    write(tmp_path, 2_000)
    (piece,) = read_enough(tmp_path, GRAPH, BOUND)
    assert len(piece) == 2_000  # noqa: PLR2004 - learning thins it
    assert piece.name == "a.parquet"
    write(tmp_path, 40_000)
    assert len(read_enough(tmp_path, GRAPH, None)[0]) == 40_000  # noqa: PLR2004 - all in any case


@pytest.mark.parametrize("group", [10_000, 10**6])
def test_memory_does_not_grow_with_the_log(group: int, tmp_path: Path) -> None:
    file = tmp_path / "long.parquet"
    with pq.ParquetWriter(file, pa.Table.from_pandas(table(2)).schema) as writer:
        for k in range(8):
            part = pa.Table.from_pandas(table(100_000, k).assign(time=(np.arange(100_000) + k * 100_000) / 3))
            writer.write_table(part, row_group_size=group)
    assert file.stat().st_size > 3 * 10**7
    read_enough(write(tmp_path, 40_000, "first.parquet"), GRAPH, BOUND)  # what libraries take once
    with taking_less_than(4 * 10**7):
        found = read_enough(file, GRAPH, BOUND)
    assert 0.9 * BOUND.rows < sum(map(len, found)) <= BOUND.rows
    assert {int(p.table["time"].iloc[0] * 3) // 100_000 for p in found} == set(range(8))


def test_a_bound_is_one_of_ticks(tmp_path: Path) -> None:
    write(tmp_path, 40_000, period=1 / 30)
    found = read_enough(tmp_path, GRAPH, BOUND, resampled=True)
    assert 9 * BOUND.rows < sum(map(len, found)) <= 10 * BOUND.rows
    ready = prepare(found, GRAPH, resampled=True)
    assert 0.8 * BOUND.rows < sum(map(len, ready)) <= BOUND.rows


@pytest.mark.parametrize(
    "times",
    [{}, {"time": 0.0}, {"time": "noon"}, {"time": 1e-320 * np.arange(40_000)}],
    ids=["none", "the same", "texts", "of no time"],
)
def test_times_that_tell_no_period_break_nothing(times: dict[str, object], tmp_path: Path) -> None:
    data = table(40_000).drop(columns="time").assign(**times)
    pq.write_table(pa.Table.from_pandas(data, preserve_index=False), tmp_path / "a.parquet")
    assert sum(map(len, read_enough(tmp_path, GRAPH, BOUND, resampled=True))) > 0.9 * BOUND.rows


def test_files_without_rows_are_left_out(tmp_path: Path) -> None:
    write(tmp_path, 0, "a.csv")
    write(tmp_path, 40_000, "b.parquet")
    for resampled in (False, True):
        found = read_enough(tmp_path, GRAPH, BOUND, resampled=resampled)
        assert all(p.name.startswith("b.parquet") for p in found)


def test_an_index_that_counts_rows_is_left_out_of_every_stretch(tmp_path: Path) -> None:
    data = table(40_000)
    data.index = pd.Index(np.arange(40_000).tolist())  # kept as a column, which a RangeIndex is not
    pq.write_table(pa.Table.from_pandas(data, preserve_index=True), tmp_path / "a.parquet")
    found = read_enough(tmp_path, GRAPH, BOUND)
    assert len(found) > 1
    for piece in found:
        assert list(piece.table.columns) == list(data.columns)


def test_a_column_that_holds_no_numbers_is_one_of_nothing(tmp_path: Path) -> None:
    data = table(40_000).assign(note="x" * 1000, pixels=[[1.0, 2.0]] * 40_000)
    pq.write_table(pa.Table.from_pandas(data, preserve_index=False), tmp_path / "a.parquet")
    found = read_enough(tmp_path, GRAPH, BOUND)
    assert all(p.table["note"].isna().all() and p.table["pixels"].isna().all() for p in found)
    with pytest.raises(InputError, match=r"rows .*: column note is no measured variable"):
        found[0].check(GRAPH)


def test_a_log_without_flags_or_objects_is_thinned_evenly(tmp_path: Path) -> None:
    data = table(40_000)[["time", "hand.x", "hand.y"]]
    pq.write_table(pa.Table.from_pandas(data, preserve_index=False), tmp_path / "a.parquet")
    found = read_enough(tmp_path, GRAPH, BOUND)
    assert np.ptp([p.table["time"].iloc[0] for p in found]) > 0.9 * 40_000 / 3


def test_damage_in_a_long_log_is_told_in_one_line(tmp_path: Path) -> None:
    file = write(tmp_path, 40_000)
    data = bytearray(file.read_bytes())
    data[20_000:30_000] = bytes(10_000)
    file.write_bytes(data)
    with pytest.raises(InputError, match=r"a.parquet: can't read the demonstration") as caught:
        read_enough(tmp_path, GRAPH, BOUND)
    assert len(str(caught.value).splitlines()) == 1


def test_claims_are_bounded_by_row_groups(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    file = tmp_path / "a.parquet"
    pq.write_table(pa.table({"a": np.random.default_rng(0).normal(size=10_000)}), file, row_group_size=1_000)
    data = file.read_bytes()
    monkeypatch.setattr("ichain_drake.demonstrations.parquet_claims._MOST_BYTES", 20_000)
    assert read_claims(data, by_parts=True).rows == 10_000  # noqa: PLR2004
    with pytest.raises(TooMuchError, match="it unpacks to more than"):
        read_claims(data)
    monkeypatch.setattr("ichain_drake.demonstrations.parquet_claims._MOST_BYTES", 5_000)
    with pytest.raises(TooMuchError, match="a row group of it unpacks to more than"):
        read_claims(data, by_parts=True)
    monkeypatch.setattr("ichain_drake.demonstrations.parquet_claims.MOST_CELLS", 99)
    with pytest.raises(TooMuchError, match="claims 10000 values, and 9900 are read"):
        read_claims(data, by_parts=True)
