"""Pieces that no graph can be learned from: `run` and `plan` name piece, edge and remedy in one line."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from ichain_drake.demonstrations import write_demonstration
from ichain_drake.simulation.commands import Commands
from ichain_drake.simulation.recorder import record
from ichain_drake.systems.water_dispenser.demonstrations import script_pieces
from ichain_drake.systems.water_dispenser.scenario import WaterDispenser

SHOWN = ("pour_all", "dispense_long", "heat_levels")  # every edge becomes active in one of them
Table = pd.DataFrame


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three pieces as CSV."""
    folder, scenario = tmp_path_factory.mktemp("good"), WaterDispenser((), "ideal")
    for piece in script_pieces(np.random.default_rng(0)):
        if piece.name in SHOWN:
            world = scenario.build_world(piece.start, 900)
            commands = Commands(piece.commands)
            shown = record(world, commands, len(piece.commands), list(scenario.graph.objects), piece.name)
            write_demonstration(shown, folder / f"{piece.name}.csv")
    return folder


def _without_flags(table: Table) -> Table:
    return table[[c for c in table.columns if "->" not in c]]


def _without_one(table: Table) -> Table:
    return table.drop(columns="power->tank")


def _extra(table: Table) -> Table:
    return table.assign(**{"power->cup": 0})


def _slow(table: Table) -> Table:
    return table.assign(time=0.5 * np.arange(len(table)))


def _odd_flag(table: Table) -> Table:
    table.loc[4, "hand->power"] = 2
    return table


def _lost_flag(table: Table) -> Table:
    table.loc[4, "hand->power"] = np.nan
    return table


def _no_times(table: Table) -> Table:
    return table.assign(time="late")


ONE: dict[str, tuple[Callable[[Table], Table], list[str]]] = {
    "no flags": (_without_flags, ["piece heat_levels.csv: has no active flags; add a column hand->cup of 0 and 1"]),
    "one flag": (_without_one, ["piece heat_levels.csv: lacks some active flags; add a column power->tank"]),
    "extra flag": (
        _extra,
        ["piece heat_levels.csv: flags for power->cup, an edge that the graph lacks; remove the column"],
    ),
    "period": (
        _slow,
        [
            "piece heat_levels.csv: its period is 0.5 s, but that of dispense_long.csv is 0.3333 s; hand->power",
            "at 3 Hz",
        ],
    ),
    "odd flag": (_odd_flag, ["heat_levels.csv: line 6, column hand->power: 2 given; an active flag is 0 or 1"]),
    "lost flag": (_lost_flag, ["heat_levels.csv: line 6, column hand->power: not a finite number"]),
    "no times": (_no_times, ["heat_levels.csv: line 2, column time: not a finite number"]),
}
EVERY: dict[str, tuple[float, str]] = {
    "never": (0, "power->tank: never active in any of the 3 pieces (dispense_long.csv, heat_levels.csv, pour_all.csv)"),
}


@pytest.fixture
def refused(ichain, good: Path, tmp_path: Path) -> Callable[..., str]:
    """Runs and plans on changed pieces; gives the one line that both end with."""

    def call(change: Callable[[Table], Table], names: tuple[str, ...] = ("heat_levels",)) -> str:
        folder = tmp_path / "pieces"
        folder.mkdir()
        for file in good.glob("*.csv"):
            table = pd.read_csv(file)
            (change(table) if file.stem in names else table).to_csv(folder / file.name, index=False)
        lines = []
        for command in (["run", "-o", tmp_path / "out"], ["plan"]):
            done = ichain(command[0], "water_dispenser", "--physics", "ideal", "--demos", folder, *command[1:])
            assert (done.status, done.out) == (2, "")
            lines.append(done.line)
        assert lines[0] == lines[1]
        return lines[0]

    return call


@pytest.mark.parametrize("fault", ONE)
def test_one_bad_piece(fault: str, refused: Callable[..., str]) -> None:
    change, words = ONE[fault]
    line = refused(change)
    assert all(word in line for word in words), line


@pytest.mark.parametrize("fault", EVERY)
def test_an_edge_that_never_changes(fault: str, refused: Callable[..., str]) -> None:
    value, words = EVERY[fault]
    line = refused(lambda table: table.assign(**{"power->tank": value}), SHOWN)
    assert words in line
    assert "; record a piece" in line


def test_contradictory_flags(ichain, good: Path, tmp_path: Path) -> None:
    folder = tmp_path / "pieces"
    folder.mkdir()
    for file in good.glob("*.csv"):
        (folder / file.name).write_text(file.read_text())
    table = pd.read_csv(good / "heat_levels.csv")
    table.assign(**{"power->tank": 1 - table["power->tank"]}).to_csv(folder / "once_more.csv", index=False)
    done = ichain("plan", "water_dispenser", "--physics", "ideal", "--demos", folder)
    assert done.status == 2
    assert "power->tank: contradictory flags: piece " in done.line
    assert "heat_levels.csv line" in done.line
    assert "once_more.csv line" in done.line
    assert "in the same state; correct one of them or remove the piece" in done.line


def test_the_first_piece_can_be_the_odd_one(refused: Callable[..., str]) -> None:
    line = refused(_slow, ("dispense_long",))
    assert "piece dispense_long.csv: its period is 0.5 s, but that of heat_levels.csv is 0.3333 s" in line


def test_no_pieces_at_all(ichain, tmp_path: Path) -> None:
    done = ichain("plan", "water_dispenser", "--physics", "ideal", "--demos", tmp_path)
    assert (done.status, done.line.endswith("holds no demonstration (.parquet or .csv)")) == (2, True)
