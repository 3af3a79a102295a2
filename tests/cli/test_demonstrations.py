"""`teach`, `learn` and `run --demos`: demonstrations go out, come back as Parquet or CSV, and bad ones are refused."""

import json
from collections.abc import Callable
from pathlib import Path

import pandas as pd
import pytest

from ichain_drake.cli.main import main
from ichain_drake.demonstrations import read_demonstration, write_demonstration


@pytest.fixture(scope="session")
def taught(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("taught")
    small = ["--physics", "ideal", "--set", "learning.samples=120"]
    assert main(["teach", "car_game", *small, "-o", str(folder)]) == 0
    return folder


def as_csv(folder: Path, target: Path) -> Path:
    target.mkdir()
    for file in folder.glob("*.parquet"):
        write_demonstration(read_demonstration(file), target / f"{file.stem}.csv")
    return target


def results(folder: Path) -> dict:
    report = json.loads((folder / "report.json").read_text())
    for key in ("wall_seconds", "versions"):
        del report[key]
    return report


def test_teach_writes_what_a_run_would_record(taught, ran):
    for name in ("play.parquet", "drive.parquet"):
        pd.testing.assert_frame_equal(
            pd.read_parquet(taught / name), pd.read_parquet(ran / "demonstrations" / name), check_exact=True
        )
    play = read_demonstration(taught / "play.parquet")
    assert list(play.table.columns) == [
        "time", "hand.x", "hand.y", "joystick.x_axis", "joystick.y_axis", "command.x", "command.y", "hand->joystick",
    ]  # fmt: skip
    assert play.units["hand.x"] == "m"


def test_a_run_on_taught_demonstrations_is_the_run_that_records_them(taught, ran, ichain, bend_csv, small, tmp_path):
    done = ichain("run", "car_game", *small, "--demos", taught, "--path", bend_csv, "-o", tmp_path)
    assert done.status == 0
    assert results(tmp_path) == results(ran)
    assert not (tmp_path / "demonstrations").exists()


def test_csv_demonstrations_give_the_same_run(taught, ran, ichain, bend_csv, small, tmp_path):
    folder = as_csv(taught, tmp_path / "csv")
    assert "hand.x [m]" in (folder / "play.csv").read_text().splitlines()[0]
    done = ichain("run", "car_game", *small, "--demos", folder, "--path", bend_csv, "-o", tmp_path / "out")
    assert done.status == 0
    assert results(tmp_path / "out") == results(ran)


def test_a_learned_library_gives_the_same_models(taught, ran, ichain, bend_csv, small, tmp_path):
    """Links from the library, the drive still recorded for validation paths; only the models' source differs."""
    library = tmp_path / "library"
    learned = ichain("learn", "car_game", "--demos", taught, "-o", library, "--set", "learning.samples=120")
    assert learned.status == 0
    assert "hand->joystick: 120 samples" in learned.out
    done = ichain("run", "car_game", *small, "--library", library, "--path", bend_csv, "-o", tmp_path / "out")
    assert done.status == 0
    again, before = results(tmp_path / "out"), results(ran)
    for name, model in again["models"].items():
        assert model.pop("source") != before["models"][name].pop("source")
    assert again == before
    assert [f.name for f in (tmp_path / "out" / "demonstrations").iterdir()] == ["drive.parquet"]


def _drop(table: pd.DataFrame) -> pd.DataFrame:
    return table.drop(columns="joystick.y_axis [1]")


def _unit(table: pd.DataFrame) -> pd.DataFrame:
    return table.rename(columns={"hand.x [m]": "hand.x [kg]"})


def _swap(table: pd.DataFrame) -> pd.DataFrame:
    order = list(range(len(table)))
    order[5], order[6] = order[6], order[5]
    return table.iloc[order]


def _double(table: pd.DataFrame) -> pd.DataFrame:
    return pd.concat([table.iloc[:8], table.iloc[7:]])


def _gap(table: pd.DataFrame) -> pd.DataFrame:
    return table.drop(index=4)


def _nan(table: pd.DataFrame) -> pd.DataFrame:
    table.loc[3, "hand.y [m]"] = float("nan")
    return table


def _text(table: pd.DataFrame) -> pd.DataFrame:
    table = table.astype({"hand.y [m]": object})
    table.loc[2, "hand.y [m]"] = "left"
    return table


def _flag(table: pd.DataFrame) -> pd.DataFrame:
    table.loc[2, "hand->joystick"] = 0.5
    return table


def _unknown(table: pd.DataFrame) -> pd.DataFrame:
    return table.rename(columns={"hand.y [m]": "hand.why [m]"})


def _no_time(table: pd.DataFrame) -> pd.DataFrame:
    return table.drop(columns="time")


def _one_row(table: pd.DataFrame) -> pd.DataFrame:
    return table.iloc[:1]


SPOILT: dict[str, tuple[Callable[[pd.DataFrame], pd.DataFrame], list[str]]] = {
    "missing column": (_drop, ["play.csv", "joystick.y_axis is missing"]),
    "wrong unit": (_unit, ["play.csv", "hand.x is in kg, but m is needed", "there is no way from kg to m"]),
    "unsorted": (_swap, ["play.csv", "line 8, column time", "before the previous one"]),
    "doubled time": (_double, ["play.csv", "line 10, column time: a doubled time"]),
    "gap": (_gap, ["play.csv", "line 6, column time", "0.3333 s needed"]),
    "NaN": (_nan, ["play.csv", "line 5, column hand.y: not a finite number"]),
    "text": (_text, ["play.csv", "line 4, column hand.y: not a finite number"]),
    "flag": (_flag, ["play.csv", "line 4, column hand->joystick: 0.5", "an active flag is 0 or 1"]),
    "unknown column": (_unknown, ["play.csv", "column hand.why is no measured variable"]),
    "no time": (_no_time, ["play.csv", "column time is missing"]),
    "one row": (_one_row, ["play.csv", "1 rows; a piece needs at least 2"]),
}


@pytest.mark.parametrize("fault", SPOILT)
def test_a_bad_demonstration_is_refused(fault, taught, ichain, small, tmp_path):
    spoil, words = SPOILT[fault]
    folder = as_csv(taught, tmp_path / "csv")
    spoil(pd.read_csv(folder / "play.csv")).to_csv(folder / "play.csv", index=False)
    done = ichain("run", "car_game", *small, "--demos", folder, "--paths", "eight", "-o", tmp_path / "out")
    assert done.status == 2
    assert all(word in done.line for word in words), done.line
    learned = ichain("learn", "car_game", "--demos", folder, "-o", tmp_path / "library")
    assert (learned.status, learned.line) == (2, done.line)


def test_a_folder_that_lacks_a_piece_or_all(taught, ichain, small, tmp_path):
    only = tmp_path / "only"
    only.mkdir()
    empty = ichain("run", "car_game", *small, "--demos", only, "--paths", "eight", "-o", tmp_path / "out")
    assert empty.status == 2 and "holds no demonstration" in empty.line
    (only / "drive.parquet").write_bytes((taught / "drive.parquet").read_bytes())
    lacking = ichain("run", "car_game", *small, "--demos", only, "--paths", "eight", "-o", tmp_path / "out")
    assert lacking.status == 2
    assert "hand->joystick: no demonstration holds hand and joystick" in lacking.line
    (only / "play.parquet").write_text("no parquet")
    broken = ichain("run", "car_game", *small, "--demos", only, "--paths", "eight", "-o", tmp_path / "out")
    assert broken.status == 2 and "play.parquet: can't read the demonstration" in broken.line


def test_teach_refuses_before_it_records(ichain, tmp_path):
    (tmp_path / "file").write_text("")
    blocked = ichain("teach", "car_game", "-o", tmp_path / "file" / "x")
    assert blocked.status == 2 and "can't write there" in blocked.line
    estimator = ichain("teach", "car_game", "-o", tmp_path / "t", "--set", "learning.estimator=nix")
    assert estimator.status == 2 and "no estimator 'nix'" in estimator.line
    assert "playing" not in estimator.err
    assert ichain("teach", "car_game").status == 2
