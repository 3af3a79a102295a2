"""One trial's row: how far its end was from the goal, and what it says when nothing is known."""

from types import SimpleNamespace

import numpy as np
import pytest
from lamp import LampScenario

from ichain_drake.control.planning.plan import Condition, Goal
from ichain_drake.runs.goals.run import GraphRun
from ichain_drake.runs.goals.trial import _miss, summarise, without_roles
from ichain_drake.simulation.episode import EpisodeLog


def ended(light: float, *conditions: Condition) -> GraphRun:
    """A run whose lamp is so bright at its end; it was demonstrated from 0 to 2."""
    run = GraphRun(LampScenario(), ["lamp.light >= 0.5"])
    graph = LampScenario.graph
    states = {n: np.zeros((2, len(space))) for n, space in graph.objects.items()}
    states["lamp"][-1, 0] = light
    run.log = EpisodeLog(np.arange(2) / 30, states, {}, {}, np.zeros((2, 3)))
    run.goal = Goal(conditions, ())
    sizes = {n: len(s.observable) for n, s in graph.objects.items()}
    run.model = SimpleNamespace(  # type: ignore[assignment]
        graph=graph, low={n: np.zeros(k) for n, k in sizes.items()}, high={n: np.full(k, 2.0) for n, k in sizes.items()}
    )
    return run


BRIGHT, DIM = Condition("lamp", "light", 0.5, np.inf), Condition("dimmer", "x", 0.4, 0.5)


def test_the_miss_is_the_worst_conditions_share_of_what_was_demonstrated() -> None:
    assert _miss(ended(0.3, BRIGHT)) == pytest.approx(0.1)
    assert _miss(ended(0.3, BRIGHT, DIM)) == pytest.approx(0.2)
    assert _miss(ended(0.7, BRIGHT)) == 0.0
    assert _miss(ended(0.0)) == 0.0, "nothing asked for is nothing missed"


def test_nothing_is_known_of_a_run_that_never_was() -> None:
    run = ended(0.3, BRIGHT)
    run.log = None
    assert _miss(run) is None
    without_goal, without_model = ended(0.3, BRIGHT), ended(0.3, BRIGHT)
    without_goal.goal, without_model.model = None, None
    assert _miss(without_goal) is None
    assert _miss(without_model) is None


def test_without_roles_all_else_of_a_variable_stays() -> None:
    graph = LampScenario.graph
    bare = without_roles(graph)
    assert bare.interactions == graph.interactions
    for name, space in graph.objects.items():
        for v, w in zip(space.variables, bare.objects[name].variables, strict=True):
            assert w.role is None
            assert (v.name, v.unit, v.lower, v.upper, v.kind) == (w.name, w.unit, w.lower, w.upper, w.kind)


def test_causes_are_told_the_most_frequent_first_and_then_by_name() -> None:
    row = {"method": "m", "case": "none", "demonstrations": "8", "success": False, "silent": 0, "control_steps": 9}
    rows = [
        {**row, "seed": k, "replans": 0, "cause": cause} for k, cause in enumerate(["reach", "drive", "lost", "lost"])
    ]
    (line,) = summarise(rows)
    assert list(line["causes"].items()) == [("lost", 2), ("drive", 1), ("reach", 1)]
