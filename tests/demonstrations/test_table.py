"""Demonstration tables: a lossless life on disk, and errors that name file, column and line."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from ichain_drake.demonstrations import (
    Demonstration,
    read_demonstration,
    read_demonstrations,
    write_demonstration,
    write_demonstrations,
)
from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.state import StateSpace, Variable
from ichain_drake.timing import TICK

ARM = StateSpace("arm", (Variable("x", "m"), Variable("grip")))
KART = StateSpace("kart", (Variable("place", "px"), Variable("slip", "px/s", hidden=True)))
GRAPH = InteractionGraph({"arm": ARM, "kart": KART}, ["arm->kart"])
UNITS = {"arm.x": "m", "arm.grip": "1", "kart.place": "px", "command.x": "m", "command.grip": "1"}


def table(rows: int = 6) -> pd.DataFrame:
    rng = np.random.default_rng(0)
    columns = {"time": TICK * np.arange(rows), **{c: rng.standard_normal(rows) for c in UNITS}}
    return pd.DataFrame({**columns, "arm->kart": np.ones(rows)})


Change = Callable[[pd.DataFrame], pd.DataFrame]


def piece(change: Change = lambda t: t, **units: str) -> Demonstration:
    return Demonstration(change(table()), UNITS | units, "push.csv")


@pytest.mark.parametrize("suffix", [".parquet", ".csv"])
def test_a_piece_comes_back_as_it_was(tmp_path: Path, suffix: str) -> None:
    """Every bit of every number, the columns' order, and the units."""
    original = piece()
    write_demonstration(original, tmp_path / f"push{suffix}")
    back = read_demonstration(tmp_path / f"push{suffix}")
    pd.testing.assert_frame_equal(back.table, original.table, check_exact=True)
    assert back.units == UNITS
    assert back.name == f"push{suffix}"
    back.check(GRAPH, ["arm", "kart"])


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(value=st.floats(allow_nan=False, allow_infinity=False))
def test_csv_loses_no_bit_of_any_number(tmp_path: Path, value: float) -> None:
    write_demonstration(piece(add("arm.x", value)), tmp_path / "push.csv")
    assert read_demonstration(tmp_path / "push.csv").table["arm.x"][0] == value


def test_a_csv_header_carries_units(tmp_path: Path) -> None:
    write_demonstration(piece(), tmp_path / "push.csv")
    header = (tmp_path / "push.csv").read_text().splitlines()[0]
    assert header == "time,arm.x [m],arm.grip [1],kart.place [px],command.x [m],command.grip [1],arm->kart"


def test_a_table_written_by_hand_needs_no_units(tmp_path: Path) -> None:
    (tmp_path / "mine.csv").write_text("time [s],kart.place\n0,1\n0.3333,2\n0.6667,4\n")
    mine = read_demonstration(tmp_path / "mine.csv")
    mine.check(GRAPH)
    assert len(mine) == 3
    assert mine.period == pytest.approx(TICK, abs=1e-3)
    assert mine.states("kart", KART).tolist() == [[1], [2], [4]]
    assert not mine.has("arm", ARM)


def test_a_folder_is_read_in_order_of_name_and_checked(tmp_path: Path) -> None:
    pieces = [Demonstration(table(), UNITS, name) for name in ("b", "a.csv", "c.parquet")]
    files = write_demonstrations(pieces, tmp_path / "new" / "folder")
    assert [f.name for f in files] == ["b.parquet", "a.parquet", "c.parquet"]
    assert [p.name for p in read_demonstrations(files[0].parent, GRAPH)] == ["a.parquet", "b.parquet", "c.parquet"]
    (files[0].parent / "d.csv").write_text("time,kart.place\n0,1\n")
    with pytest.raises(InputError, match=r"d\.csv: 1 rows; a piece needs at least 2"):
        read_demonstrations(files[0].parent, GRAPH)


def at(row: int, column: str, value: object) -> Change:
    return lambda t: t.assign(**{column: [value if i == row else v for i, v in enumerate(t[column])]})


def drop(*columns: str) -> Change:
    return lambda t: t.drop(columns=list(columns))


def add(column: str, value: float = 0.0) -> Change:
    return lambda t: t.assign(**{column: value})


# Lines are those of a CSV file: the header is line 1, the first row line 2.
BAD_TABLES = [
    (piece(drop("time")), "column time is missing"),
    (piece(drop("arm.grip")), r"column arm\.grip is missing"),
    (piece(drop("command.grip")), r"column command\.grip is missing"),
    (piece(add("kart.slip")), r"column kart\.slip is no measured variable; known are .*kart\.place"),
    (piece(add("kart->arm")), "kart->arm is no interaction of the graph; it has arm->kart"),
    (piece(**{"kart.place": "m"}), r"column kart\.place is in m, but px is needed"),
    (piece(time="ms"), "column time is in ms, but s is needed"),
    (piece(at(3, "arm.x", np.nan)), r"line 5, column arm\.x: not a finite number"),
    (piece(at(0, "arm.x", "fast")), r"line 2, column arm\.x: not a finite number"),
    (piece(at(4, "kart.place", np.inf)), r"line 6, column kart\.place: not a finite number"),
    (piece(at(2, "time", np.nan)), "line 4, column time: not a finite number"),
    (piece(at(2, "time", 0.0)), "line 4, column time: a time before the previous one"),
    (piece(at(2, "time", TICK)), "line 4, column time: a doubled time"),
    (piece(at(5, "time", 6 * TICK)), r"line 7, column time: 0\.6667 s since the previous row, 0\.3333 s needed"),
    (piece(lambda t: t.assign(time=t["time"] / 10)), r"line 3, column time: 0\.03333 s since"),
    (piece(at(1, "arm->kart", 2)), "line 3, column arm->kart: 2 given; an active flag is 0 or 1"),
    (piece(at(1, "arm->kart", 0.5)), "line 3, column arm->kart: 0.5 given"),
    (piece(lambda t: t[:1]), "1 rows; a piece needs at least 2"),
    (Demonstration(table()[["time", "arm->kart"]], {}, "push.csv"), "holds no object of the graph"),
    (Demonstration(pd.concat([table(), table()[["arm.x"]]], axis=1), {}, "push.csv"), r"column arm\.x appears twice"),
]


@pytest.mark.parametrize(("bad", "message"), BAD_TABLES, ids=[m[:40] for _, m in BAD_TABLES])
def test_a_bad_table_is_refused_with_file_column_and_line(bad: Demonstration, message: str) -> None:
    with pytest.raises(InputError, match=rf"^push\.csv: {message}"):
        bad.check(GRAPH)


def test_required_objects_must_be_there() -> None:
    lone = piece(drop("arm.x", "arm.grip", "command.x", "command.grip"))
    lone.check(GRAPH)
    with pytest.raises(InputError, match=r"push\.csv: column arm\.x is missing"):
        lone.check(GRAPH, ["arm"])
    with pytest.raises(InputError, match=r"column arm\.x is missing; it has time, kart\.place"):
        lone.states("arm", ARM)
    with pytest.raises(InputError, match="no object 'boat'"):
        lone.check(GRAPH, ["boat"])


def test_an_object_can_not_be_called_like_the_commands() -> None:
    clash = InteractionGraph({"arm": ARM, "command": KART}, ["arm->command"])
    with pytest.raises(InputError, match="'command' stands for the hand's commands"):
        piece().check(clash)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.csv", b"", "can't read the demonstration"),
        ("a.csv", b"\xff\xfe\x00\x81garbage", "can't read the demonstration"),
        ("a.csv", b'time,"x\n1,2', "can't read the demonstration"),
        ("a.parquet", b"PAR1 no parquet", "can't read the demonstration"),
        ("a.parquet", b"", "can't read the demonstration"),
        ("a.xlsx", b"", r"ends in \.parquet or \.csv"),
        ("missing.csv", None, "can't read the demonstration"),
        ("missing.parquet", None, "can't read the demonstration"),
    ],
)
def test_a_file_that_is_no_table_is_refused_by_name(
    tmp_path: Path, name: str, content: bytes | None, message: str
) -> None:
    if content is not None:
        (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError, match=f"{name}: .*{message}"):
        read_demonstration(tmp_path / name)


def test_folders_that_can_not_be_used(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="nowhere: no such folder"):
        read_demonstrations(tmp_path / "nowhere", GRAPH)
    with pytest.raises(InputError, match=r"holds no demonstration \(\.parquet or \.csv\)"):
        read_demonstrations(tmp_path, GRAPH)
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="can't make the folder"):
        write_demonstrations([piece()], tmp_path / "file")
    with pytest.raises(InputError, match="can't write the demonstration"):
        write_demonstration(piece(), tmp_path / "nowhere" / "a.parquet")
    with pytest.raises(InputError, match=r"ends in \.parquet or \.csv"):
        write_demonstration(piece(), tmp_path / "a.txt")


def test_two_pieces_of_one_name_do_not_overwrite_each_other(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"push\.parquet: two pieces have this name"):
        write_demonstrations([piece(), piece()], tmp_path)
