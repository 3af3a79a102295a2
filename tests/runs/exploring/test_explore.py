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
    assert first["experiment"] == "touch dial"
    assert first["edges"]["lamp->pot"]["rivals"].keys() == {"dial"}  # either is as good
    assert second["experiment"] == "touch dial, then lamp"
    assert second["edges"].keys() == {"hand->dial", "dial->pot"}
    assert not second["edges"]["dial->pot"]["rivals"]
    assert not run.known
    assert run.reason == "the budget is spent"
    assert "open: what acts on lamp?" in run.lines()


def test_the_goal_is_tried_with_what_is_known(bath: Exploration) -> None:
    run = replace(bath, goal=None, history=list(bath.history), pieces=list(bath.pieces), done=list(bath.done))
    run.settings = replace(run.settings, budget=600.0)
    assert run.goal == ("0.5 <= basin.level <= 0.6", "not tap->basin", "not hand->tap")
    assert not run.over
    found = run.found
    explore(run)
    assert run.over
    assert run.reached
    assert run.report()["goal_reached"]
    assert run.reason.endswith(", and the goal was reached")
    assert [p.name[:10] for p in run.successes] == ["rehearsed_"]
    assert run.robot_seconds == pytest.approx(sum(len(p) - 1 for p in (*run.pieces, *run.successes)) / 3)
    assert run.history[-1]["experiment"] == "reach the goal"
    assert len(run.pieces) > len(bath.pieces) or run.found is found  # a goal that was reached changes no graph
