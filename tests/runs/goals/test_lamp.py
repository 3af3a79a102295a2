"""A second graph is learned, planned and driven by the same code, and by the public interface alone."""

import json

import pytest
from lamp import LampScenario

import ichain_drake as ic


@pytest.fixture(scope="module")
def knowledge() -> ic.Knowledge:
    scenario = LampScenario()
    return ic.learn_graph(list(scenario.record_demonstrations()), scenario.graph)


def run(knowledge: ic.Knowledge, *goal: str, number: int = 0) -> dict:
    ran = ic.GraphRun(LampScenario(), goal, number=number)
    ic.run_graph(ran, knowledge=knowledge)
    report = ran.report()
    json.dumps(report, allow_nan=False)
    return report


def test_what_acts_when_is_learned(knowledge: ic.Knowledge) -> None:
    edges = knowledge.model.report()["interactions"]
    for name, edge in edges.items():
        assert edge["status"]["f1"] >= 0.9, name
    # Both act while the switch is on; how bright the lamp is then says nothing about it.
    for name in ("dimmer->lamp", "switch->lamp"):
        assert edges[name]["status"]["columns"] == ["position of switch"]


@pytest.mark.parametrize("number", [0, 1])
@pytest.mark.parametrize(
    "goal", [("0.55 <= lamp.light <= 0.65",), ("lamp.light >= 0.7", "not hand->dimmer", "not hand->switch")]
)
def test_a_wanted_brightness_needs_both(knowledge: ic.Knowledge, goal: tuple[str, ...], number: int) -> None:
    report = run(knowledge, *goal, number=number)
    assert report["goal_reached"], report["reason"]
    assert sorted(step["chain"][-1] for step in report["metrics"]["plan"]) == ["hand->dimmer", "hand->switch"]


def test_brighter_than_bright_is_refused(knowledge: ic.Knowledge) -> None:
    report = run(knowledge, "lamp.light >= 1.5")
    assert not report["goal_reached"]
    assert "lamp.light goes from 0 to 1 and is bounded there" in report["reason"]
