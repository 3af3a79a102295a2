"""`ichain label` without a browser: a table of marks becomes flags of pieces."""

from pathlib import Path

import bath_log
import pytest

from ichain_drake.cli.main import main
from ichain_drake.demonstrations import read_folder

PIECES = bath_log.pieces(2)


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return bath_log.write_log(PIECES, tmp_path_factory.mktemp("logs"))


def label(log: Path, text: str, folder: Path, *more: str) -> int:
    marks = folder / "marks.csv"
    marks.write_text("piece,interaction,from,to,active,name\n" + text)
    return main(["label", str(log), "--marks", str(marks), "--robot", "hand", *more])


def test_intervals_become_flags(log: Path, tmp_path: Path) -> None:
    text = "log.csv,hand->lever,2,4,1,\nlog.csv,cut,0,,1,begin\n"
    assert label(log, text, tmp_path, "-o", str(tmp_path / "demos")) == 0
    first, second = read_folder(tmp_path / "demos")
    assert (first.name, len(first)) == ("begin.parquet", len(PIECES[0]))
    assert first.table["hand->lever"].sum() == first.table["hand->lever"].notna().sum() == 7
    assert second.table["hand->lever"].isna().all()


@pytest.mark.parametrize(
    ("text", "more", "message"),
    [
        ("log.csv,hand->lever,2,1,1,\n", ("-o", "demos"), "marks.csv: line 2: it ends at 1 s"),
        ("log.csv,fork->lever,1,2,1,\n", ("-o", "demos"), "line 2: 'fork->lever' is no interaction of the graph"),
        ("", (), "give -o DEMOS for pieces"),
    ],
)
def test_mistakes_are_named(
    text: str, more: tuple[str, ...], message: str, log: Path, tmp_path: Path, capsys: pytest.CaptureFixture,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    assert label(log, text, tmp_path, *more) == 2
    error = capsys.readouterr().err.strip().splitlines()[-1]
    assert error.startswith("ichain: ") and message in error  # noqa: PT018
    assert main(["label", str(log), "--marks", "nowhere.csv", "-o", "out"]) == 2
    assert main(["label", str(log), "--marks", "marks.txt", "--browser"]) == 2
    assert "marks end in .csv" in capsys.readouterr().err
