"""Trying a task with what was found."""

from dataclasses import replace
from pathlib import Path

from ichain_drake.learning.discovery.edges import DiscoveredGraph
from ichain_drake.runs.exploring.rehearsing import Rehearsal, rehearse
from ichain_drake.systems import load_scenario

BATH = str(Path(__file__).parents[3] / "examples" / "own_system" / "bath.py")


def test_a_goal_about_what_was_not_found_is_not_tried() -> None:
    scenario = load_scenario(BATH, (), "ideal", 41000)
    spaces = {n: s.observable for n, s in scenario.graph.objects.items()}
    nothing = DiscoveredGraph(spaces, "hand", (), (), ())
    attempt = rehearse(scenario, scenario.config.goal, [], nothing, 900, 100, lambda line: None)
    assert not attempt.reached
    assert attempt.piece is None
    assert attempt.reason
    assert replace(attempt, reason="") == Rehearsal(False, "")
