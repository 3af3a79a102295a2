"""What is odd about pieces is said where they are recorded, too, before anything is learned from them."""

from pathlib import Path

from ichain_drake.runs.pieces import record_pieces
from ichain_drake.systems import load_scenario


def test_a_piece_that_is_recorded_twice_is_named(monkeypatch, tmp_path: Path) -> None:
    scenario = load_scenario("car_game", ["learning.samples=40"], "ideal", 0)
    record = type(scenario).record_demonstrations

    def twice(self, *arguments):
        first, *others = record(self, *arguments)
        return [first, *others, type(first)(first.table, first.units, "again")]

    monkeypatch.setattr(type(scenario), "record_demonstrations", twice)
    said: list[str] = []
    pieces: list = []
    record_pieces(scenario, pieces, tmp_path, said.append)
    assert len(pieces) == 3
    assert [line for line in said if line.startswith("odd: play, again: are the same; remove one")]
