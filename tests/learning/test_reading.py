"""Long recordings without flags are cut when they are read; those with flags, and those cut before, are not."""

from dataclasses import replace
from pathlib import Path

import bath_log
import pytest

from ichain_drake.demonstrations import long_logs, write_demonstration
from ichain_drake.errors import InputError
from ichain_drake.learning import enough, read_pieces
from ichain_drake.learning.discovery.raw import read_logs, read_raw
from ichain_drake.learning.settings import LEARNING
from ichain_drake.runs.discovery_scores import joined

PIECES = bath_log.pieces()


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    units = {f"{o}.{v.name}": v.unit for o, s in bath_log.GRAPH.objects.items() for v in s.variables}
    write_demonstration(replace(joined(PIECES, "log"), units=units), tmp_path / "log.parquet")
    return tmp_path


def test_a_long_recording_is_cut_and_it_is_said(folder: Path) -> None:
    said: list[str] = []
    pieces = read_pieces(folder, bath_log.GRAPH, unlabelled=True, say=said.append)
    assert [len(p) for p in pieces] == [len(p) for p in PIECES]
    assert sum("reset: " in line for line in said) == len(PIECES) - 1
    alone = read_pieces(folder / "log.parquet", bath_log.GRAPH, unlabelled=True)
    assert [p.name for p in alone] == [p.name for p in pieces]


def test_what_was_cut_before_is_left_as_it_is(folder: Path) -> None:
    (folder / "cuts.json").write_text("{}")
    (piece,) = read_pieces(folder, bath_log.GRAPH, unlabelled=True)
    assert len(piece) == sum(map(len, PIECES))


def test_with_flags_nothing_is_cut(folder: Path) -> None:
    with pytest.raises(InputError, match="log.parquet: has no active flags"):
        read_pieces(folder, bath_log.GRAPH)


def test_of_logs_beyond_memory_as_much_is_read_as_is_learned_from(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(long_logs, "MOST_CELLS", 100)
    monkeypatch.setattr(enough, "LEARNING", replace(LEARNING, most_learned=100, examples=20))
    spaces, root = dict(bath_log.GRAPH.objects), bath_log.GRAPH.root
    said: list[str] = []
    parts = read_raw(folder, spaces, root, say=said.append)
    assert sum(len(next(iter(p.states.values()))) for p in parts) <= 100  # noqa: PLR2004
    assert f" of {sum(map(len, PIECES))} rows are read" in said[0]
    assert sum(map(len, read_pieces(folder, bath_log.GRAPH, unlabelled=True))) <= 100  # noqa: PLR2004
    whole = sum(map(len, PIECES))
    assert sum(map(len, read_logs(folder, bath_log.GRAPH).pieces)) == whole  # to be cut, nothing may be lost
