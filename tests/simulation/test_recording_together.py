"""Pieces that are recorded together are, in every bit, what each is in a Diagram of its own."""

import os
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ichain_drake.demonstrations import Demonstration
from ichain_drake.objects.rows import NotTogetherError
from ichain_drake.objects.vessels.cup import Cup
from ichain_drake.scenarios import graph_scenario
from ichain_drake.scenarios.graph_scenario import GraphScenario
from ichain_drake.simulation import recording_together
from ichain_drake.simulation.commands import Commands
from ichain_drake.simulation.noting import noted_in
from ichain_drake.simulation.recorder import RecordingInterrupted, record
from ichain_drake.simulation.recording_together import nobody_looks, record_together
from ichain_drake.simulation.watching import watched_by
from ichain_drake.systems import load_scenario
from ichain_drake.world.rows import WorldRows
from ichain_drake.world.world import World

OUTSIDE = Path(__file__).parents[1] / "helpers" / "outside"
SYSTEMS = ["water_dispenser", "two_dispensers", "kettle", "microwave", "lidded_pot"]
SYSTEMS += [str(OUTSIDE / "crane.py"), str(OUTSIDE / "lock_place.py")]


class Some:
    """Some of a script's pieces, long and short ones.

    Args:
        name: of the system.
        count: of pieces.
        settings: of the system.
    """

    def __init__(self, name: str, count: int, *settings: str) -> None:
        scenario = load_scenario(name, list(settings), "ideal", 5)
        assert isinstance(scenario, GraphScenario)
        self.scenario, self.objects = scenario, tuple(scenario.graph.objects)
        pieces = list(scenario.script(np.random.default_rng(5)))
        pieces = [pieces[k] for k in np.linspace(0, len(pieces) - 1, count).astype(int)]
        self.starts = [p.start for p in pieces]
        self.commands, self.names = [p.commands for p in pieces], [p.name for p in pieces]

    def worlds(self) -> list[World]:
        """One for each piece."""
        return [self.scenario.build_world(start, 900 + k) for k, start in enumerate(self.starts)]

    def together(self) -> Iterator[Demonstration]:
        """All at once."""
        return record_together(self.worlds(), self.commands, self.objects, self.names)

    def alone(self, k: int) -> Demonstration:
        """One by itself."""
        world, commands = self.worlds()[k], self.commands[k]
        return record(world, Commands(commands), len(commands), self.objects, self.names[k])


def check(one: Demonstration, other: Demonstration) -> None:
    assert (one.name, one.units, one.period) == (other.name, other.units, other.period)
    assert one.table.equals(other.table)


@pytest.mark.parametrize("name", SYSTEMS, ids=[Path(s).stem for s in SYSTEMS])
def test_pieces_recorded_together_are_to_the_last_bit_what_each_is_alone(name: str) -> None:
    some = Some(name, 4, *(["noise.scale=2"] if name == "kettle" else []))
    assert len({len(c) for c in some.commands}) > 1, "of several lengths"
    found = list(some.together())
    assert len(found) == 4
    for k, piece in enumerate(found):
        check(piece, some.alone(k))
    flags = [c for c in found[0].table.columns if "->" in c]
    assert any(piece.table[flags].to_numpy().any() for piece in found), "something was active"


def test_what_was_whole_when_somebody_stopped_it_is_there_and_what_there_is_of_the_next(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    some = Some("water_dispenser", 4)
    order = np.argsort([len(c) for c in some.commands], kind="stable")  # the shortest first
    for part in ("starts", "commands", "names"):
        setattr(some, part, [getattr(some, part)[k] for k in order])
    ticks, frames = len(some.commands[0]), WorldRows.frames

    def pressed(rows: WorldRows, command: np.ndarray) -> Any:
        calls.append(len(calls))
        if len(calls) == ticks + 3:
            os.kill(os.getpid(), signal.SIGINT)
        return frames(rows, command)

    calls: list[int] = []
    monkeypatch.setattr(WorldRows, "frames", pressed)
    found = some.together()
    monkeypatch.undo()
    check(next(found), some.alone(0))
    with pytest.raises(RecordingInterrupted) as stopped:
        next(found)
    piece, whole = stopped.value.piece, some.alone(1)
    assert (piece.name, len(piece.table)) == (whole.name, ticks + 4)
    commands = [c for c in whole.table.columns if c.startswith("command")]
    same, last = whole.table.iloc[: ticks + 4], ticks + 3
    assert piece.table.drop(columns=commands).equals(same.drop(columns=commands))
    assert piece.table[commands].iloc[:last].equals(same[commands].iloc[:last])


def test_a_script_is_recorded_together_unless_somebody_looks(monkeypatch: pytest.MonkeyPatch) -> None:
    scenario = Some("water_dispenser", 1).scenario
    asked: list[int] = []

    def together(worlds: list[World], *rest: Any) -> Iterator[Demonstration]:
        asked.append(len(worlds))
        return recording_together.record_together(worlds, *rest)

    monkeypatch.setattr(graph_scenario, "record_together", together)
    told: list[str] = []
    pieces = list(scenario.record_demonstrations(told.append))
    assert asked == [len(pieces)]
    assert [line.split(":")[0] for line in told] == [p.name for p in pieces]
    assert nobody_looks()
    with watched_by(object()):  # type: ignore[arg-type] # who never sees a frame here
        assert not nobody_looks()
    with noted_in(object()):  # type: ignore[arg-type]
        assert not nobody_looks()
    monkeypatch.setattr(graph_scenario, "nobody_looks", lambda: False)
    check(next(iter(scenario.record_demonstrations())), pieces[0])
    assert len(asked) == 1


def test_a_script_whose_objects_take_one_row_at_a_time_is_recorded_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    some, settle = Some("water_dispenser", 2), Cup.settle
    whole = next(iter(some.scenario.record_demonstrations()))

    def one_row(cup: Cup, state: np.ndarray, parents: Any, active: Any) -> np.ndarray:
        assert state.ndim == 1
        return settle(cup, state, parents, active)

    monkeypatch.setattr(Cup, "settle", one_row)
    with pytest.raises(NotTogetherError, match="cup: settle takes no rows"):
        some.together()
    check(next(iter(some.scenario.record_demonstrations())), whole)


def test_worlds_of_other_robots_are_not_calculated_together() -> None:
    one, other = Some("water_dispenser", 1), Some("lidded_pot", 1)
    with pytest.raises(NotTogetherError, match="worlds with the same robots"):
        WorldRows([*one.worlds(), *other.worlds()])
