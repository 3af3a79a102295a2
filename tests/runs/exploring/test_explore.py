"""From nothing to a graph."""

from dataclasses import replace
from pathlib import Path

import pytest

from ichain_drake.runs.exploring.explore import Exploration, explore
from ichain_drake.runs.exploring.settings import EXPLORING
from ichain_drake.systems import load_scenario

HELPERS, SEED = Path(__file__).parents[2] / "helpers", 41000
BATH = str(Path(__file__).parents[3] / "examples" / "own_system" / "bath.py")


def explored(system: str, budget: float, goal: tuple[str, ...] | None = (), pieces: int = 2) -> Exploration:
    """As far as the budget goes."""
    settings = replace(EXPLORING, budget=budget, pieces=pieces)
    run = Exploration(load_scenario(system, (), "ideal", SEED), goal, settings)
    explore(run)
    return run


@pytest.fixture(scope="module")
def bath() -> Exploration:
    """Until two pieces leave nothing open."""
    return explored(BATH, 210.0)


def test_a_chain_is_found_from_nothing(bath: Exploration) -> None:
    assert bath.known
    assert bath.reason == "the graph is known"
    assert bath.found is not None
    assert {f.edge.name for f in bath.found.found} == {"hand->tap", "tap->basin"}
    assert not bath.unsure()


def test_what_it_cost_is_reported(bath: Exploration) -> None:
    report = bath.report()
    assert report["pieces"] == len(bath.pieces) == len(report["history"])
    assert report["samples"] == 90 * len(bath.pieces)
    assert report["robot_seconds"] == pytest.approx(30.0 * len(bath.pieces))
    assert report["history"][-1]["edges"] == report["edges"]
    assert report["history"][-1]["sure"] and report["open"] == []
    assert bath.lines()[-1].startswith("the graph is known: ")


def test_pieces_hold_states_alone(bath: Exploration) -> None:
    assert not [c for p in bath.pieces for c in p.table.columns if "->" in str(c)]


def test_a_lamp_is_a_rival_until_one_of_the_two_is_withheld() -> None:
    run = explored(str(HELPERS / "stove.py"), 60.0)
    first, second = run.history
    said = {name for name, e in first["edges"].items() for _ in e["rivals"]} | set(first["edges"])
    assert first["experiment"] == "touch dial"
    rivals = {*first["edges"]["dial->pot"]["rivals"], *first["edges"]["lamp->pot"]["rivals"]} if {
        "dial->pot", "lamp->pot"
    } <= said else {r for e in first["edges"].values() for r in e["rivals"]}  # fmt: skip
    assert {"lamp", "dial"} & rivals
    assert second["experiment"] == "touch dial, then lamp"
    assert "dial->pot" in second["edges"] and "lamp->pot" not in second["edges"]
    assert not run.known
    assert run.reason == "the budget is spent"
    assert any(line.startswith("open: ") for line in run.lines())
