"""What a script records is on disk while it is recorded: a kill takes a second of it, not the piece."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from ichain_drake.cli.main import main
from ichain_drake.demonstrations import TIME, Demonstration, read_demonstration
from ichain_drake.errors import InputError
from ichain_drake.runs import open_piece
from ichain_drake.runs.open_piece import OpenRecord, OpenScript, flags, left_behind
from ichain_drake.runs.pieces import record_pieces
from ichain_drake.simulation import noting
from ichain_drake.systems import load_scenario
from ichain_drake.timing import TICK

SMALL = ["car_game", "--physics", "ideal", "--set", "learning.samples=60"]


class KilledError(BaseException):
    """The end of the process."""


@pytest.fixture
def left(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder in which a script was killed in its first piece."""
    folder = tmp_path / "pieces"
    with monkeypatch.context() as patch:
        patch.setattr(noting, "_EVERY", 0.0)
        patch.setattr(OpenRecord, "remove", lambda self: self._stream.close())  # as the system does
        add = OpenScript.add

        def dying(self: OpenScript, piece: Demonstration) -> None:
            add(self, piece)
            if self.rows >= 20:
                raise KilledError

        patch.setattr(OpenScript, "add", dying)
        scenario = load_scenario("car_game", ("learning.samples=60",), "ideal", 0)
        with pytest.raises(KilledError):
            record_pieces(scenario, [], folder)
    return folder


def test_the_next_command_makes_a_piece_of_it(left: Path, tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    assert [f.name for f in left.iterdir()] == [".play.open"]
    assert main(["teach", *SMALL, "-o", str(left)]) == 2
    said = capsys.readouterr().err
    assert "play is what a process that ended unexpectedly had recorded: 20 rows" in said
    assert "holds 1 demonstrations already (play.parquet)" in said
    assert main(["teach", *SMALL, "-o", str(tmp_path / "whole")]) == 0
    kept, whole = read_demonstration(left / "play.parquet"), read_demonstration(tmp_path / "whole" / "play.parquet")
    assert kept.table.equals(whole.table[:20])
    assert kept.units == whole.units
    assert sorted(f.name for f in (tmp_path / "whole").iterdir()) == ["drive.parquet", "play.parquet"]


def test_nothing_takes_its_place(left: Path, tmp_path: Path) -> None:
    """One of another system, or that nothing can be made of, stays where it is, and is no hindrance."""
    for content in (b"{}\n[1]\n[2]\n", (left / ".play.open").read_bytes().replace(b"hand.x", b"hand.q")):
        (left / ".play.open").write_bytes(content)
        assert main(["teach", *SMALL, "-o", str(left), "--overwrite"]) == 0
        assert (left / ".play.open").read_bytes() == content
    assert sorted(f.name for f in left.iterdir()) == [".play.open", "drive.parquet", "play.parquet"]


def test_a_name_that_is_taken_gets_a_number(left: Path, capsys: pytest.CaptureFixture) -> None:
    (left / "play.parquet").write_bytes(b"mine")
    assert main(["teach", *SMALL, "-o", str(left)]) == 2
    assert len(read_demonstration(left / "play-2.parquet")) == 20
    assert (left / "play.parquet").read_bytes() == b"mine"
    assert "play-2 is what a process" in capsys.readouterr().err


def test_a_run_saves_what_a_killed_one_left(
    left: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    def nothing(*arguments: object, **options: object) -> None:
        raise InputError("not now")

    monkeypatch.setattr("ichain_drake.cli.run.carry_out", nothing)
    left.rename(tmp_path / "demonstrations")
    assert main(["run", *SMALL, "--paths", "eight", "-o", str(tmp_path)]) == 2
    assert len(read_demonstration(tmp_path / "demonstrations" / "play.parquet")) == 20
    assert "play is what a process that ended unexpectedly had recorded: 20 rows" in capsys.readouterr().err


def test_no_room_for_them_does_not_end_the_recording(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(self: OpenRecord, *arguments: object) -> None:
        raise InputError("No space left on device")

    monkeypatch.setattr(noting, "_EVERY", 0.0)
    monkeypatch.setattr(OpenRecord, "add", full)
    record_pieces(load_scenario("car_game", ("learning.samples=20",), "ideal", 0), [], tmp_path)
    assert sorted(f.name for f in tmp_path.iterdir()) == ["drive.parquet", "play.parquet"]


def test_what_was_marked_last_is_on_disk(tmp_path: Path) -> None:
    table = pd.DataFrame({TIME: TICK * np.arange(3), "car.x": [1.0, 2.0, 4.0]})
    record, marks = OpenRecord(tmp_path, "play"), [{}, {"a->b": [10]}, {"a->b": [10]}]
    for k, marked in enumerate(marks):
        record.add(Demonstration(table[k : k + 1], {"car.x": "px"}, "play"), 0, marked, {"a->b": True})
        assert record.rows == k + 1
    assert left_behind(tmp_path) == [], "it is being written"
    record._stream.close()
    ((file, piece),) = left_behind(tmp_path)
    assert (file.name, piece.name, dict(piece.units)) == (".play.open", "play", {"car.x": "px"})
    assert piece.table.equals(table.assign(**{"a->b": [1.0, 0.0, 0.0]}))
    assert file.read_text().count("marks") == 2, "written where they changed"
    assert OpenRecord(tmp_path, "play").file.name == ".play-2.open"


@pytest.mark.parametrize(
    ("before", "frames", "expected"),
    [
        (False, [], [0, 0, 0, 0]),
        (True, [], [1, 1, 1, 1]),
        (False, [10], [0, 1, 1, 1]),
        (False, [11], [0, 0, 1, 1]),
        (True, [1, 20, 30], [1, 0, 1, 0]),
        (False, [1, 9], [0, 0, 0, 0]),
    ],
)
def test_a_flag_flips_at_the_first_tick_from_a_mark_on(before: bool, frames: list[int], expected: list[int]) -> None:
    assert flags(before, frames, 4).tolist() == expected


def test_of_less_than_two_rows_nothing_is_made(tmp_path: Path) -> None:
    head = '{"columns": ["a.x"], "units": {}}'
    for lines, left in (([], False), ([head], False), ([head, "[1]"], False), ([head, "[1]", "[2]", "[3"], True)):
        (tmp_path / ".p.open").write_text("".join(f"{line}\n" for line in lines).removesuffix("[3\n") + "[3")
        found = left_behind(tmp_path)
        assert [(piece.name, len(piece)) for _, piece in found] == [("p", 2)] * left
        assert (tmp_path / ".p.open").exists() == left


def test_a_folder_that_can_not_be_made_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(InputError, match=r"file/\.play\.open: can't write the open piece: File exists"):
        OpenRecord(tmp_path / "file", "play")


def test_a_piece_after_one_for_which_there_was_no_room_is_noted_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    script = OpenScript(tmp_path)
    rows = Demonstration(pd.DataFrame({TIME: TICK * np.arange(3), "a.x": np.arange(3.0)}), {}, "first.parquet")
    with monkeypatch.context() as full:

        def add(*_: object) -> None:
            raise InputError("no space is left")

        full.setattr(OpenRecord, "add", add)
        script.add(rows)
    script.add(rows)
    assert (script.rows, list(tmp_path.iterdir())) == (0, []), "what was given up for a piece stays so"
    script.close()
    script.add(replace(rows, name="second.parquet"))
    assert (script.rows, [f.name for f in tmp_path.iterdir()]) == (3, [".second.open"])
    script.close()
    assert not list(tmp_path.iterdir())


def test_a_file_that_cannot_be_read_hides_none_of_the_others(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    files = [tmp_path / f".{name}{open_piece._ENDING}" for name in "ab"]
    for file in files:
        file.touch()

    def read(file: Path) -> str:
        if file == files[0]:
            raise ValueError("torn")
        return "a piece"

    monkeypatch.setattr(open_piece, "_is_written", lambda file: False)
    monkeypatch.setattr(open_piece, "_read", read)
    assert left_behind(tmp_path) == [(files[1], "a piece")]
    assert files[0].exists()
