"""One trial's row: how far its end was from the goal, and what it says when nothing is known."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from lamp import LampScenario

from ichain_drake.control.execution.memory import Memory
from ichain_drake.control.execution.tasks import Mode
from ichain_drake.control.planning.plan import Condition, Goal
from ichain_drake.runs.goals import trial as trials
from ichain_drake.runs.goals.run import GraphRun
from ichain_drake.runs.goals.trial import Trial, _miss, outcome, run_trial, summarise, timed_trial, without_roles
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


def trial(kind: Any = LampScenario, *, fresh: bool = False) -> Trial:
    return Trial("monitors", "slip", kind, ("a=1",), "ideal", 40, 7, ("lamp.light >= 0.5",), True, 8, fresh)


def test_a_row_says_which_demonstrations_and_which_run_it_is_of() -> None:
    row, own = trial().row(), trial(fresh=True).row()
    assert (row["seed"], row["demonstrations"]) == (7, "seed 40")
    assert (own["seed"], own["demonstrations"]) == (40, "fresh")
    assert (row["method"], row["physics"], row["case"], row["pieces"]) == ("monitors", "ideal", "slip", 8)
    assert (row["success"], row["silent"], row["error"], row["control_steps"], row["replans"]) == (
        False,
        False,
        None,
        0,
        0,
    )


def test_what_could_not_be_learned_or_breaks_off_is_a_row_too() -> None:
    assert run_trial(trial(), "too few pieces") == trial().row() | {"reason": "too few pieces", "cause": "learning"}

    def broken(*args: object) -> None:
        raise ValueError("it came apart")

    model: Any = SimpleNamespace()
    row, seconds = timed_trial(trial(broken), model)
    assert (row["cause"], row["success"], seconds) == ("error", False, 0.0)
    assert "it came apart" in row["reason"]


def test_a_trial_runs_what_it_says_with_what_was_learned(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Any] = []

    def made(settings: tuple[str, ...], physics: str, seed: int) -> LampScenario:
        asked.append((settings, physics, seed))
        return LampScenario()

    def run_graph(run: GraphRun, *, known: object, settings: Any) -> None:
        asked.append((run.number, run.expressions, known, settings.monitors))
        finished = ended(0.7, BRIGHT)
        run.log, run.goal, run.model, run.plan_seconds = finished.log, finished.goal, finished.model, 2.5
        run.memory = Memory(np.zeros(3), tick=9, replans=1, mode=Mode.REACHED)

    monkeypatch.setattr(trials, "run_graph", run_graph)
    model: Any = SimpleNamespace()
    row, seconds = timed_trial(trial(made), model)
    assert asked == [(("a=1",), "ideal", 40), (7, ("lamp.light >= 0.5",), model, True)]
    assert (row["success"], row["error"], row["reason"], row["cause"], seconds) == (True, 0.0, "", "", 2.5)
    assert (row["control_steps"], row["replans"], row["silent"]) == (9, 1, False)


@pytest.mark.parametrize(
    ("mode", "wrong", "reason", "silent"),
    [
        (Mode.REACHED, "", "goal reached", False),
        (Mode.REACHED, "it is dark", "taken as reached", True),
        (Mode.STOPPED, "it is dark", "too slow", False),
        (Mode.STOPPED, "", "", True),
    ],
)
def test_a_failure_is_silent_where_nobody_noticed_or_said_why(
    mode: Mode, wrong: str, reason: str, *, silent: bool
) -> None:
    run = ended(0.3, BRIGHT)
    run.memory = Memory(np.zeros(3), tick=9, replans=1, mode=mode)
    run.wrong, run.reason, run.cause = wrong, reason, "drive"
    found = outcome(run)
    success = mode == Mode.REACHED and not wrong
    assert (found["success"], bool(found["silent"])) == (success, silent)
    assert (found["reason"], found["cause"]) == (("", "") if success else (reason, "drive"))
    assert found["error"] == pytest.approx(0.1)


def test_a_line_sums_up_rows_of_one_kind() -> None:
    def row(seed: int, success: bool, **more: Any) -> dict[str, Any]:
        return {
            "method": "m", "case": "none", "demonstrations": "fresh", "success": success, "silent": False, "seed": seed,
            "control_steps": 10 * seed, "replans": seed, "cause": "", **more,
        }  # fmt: skip

    rows = [row(1, True), row(2, True), row(4, False, silent=True), row(3, True), row(5, True, case="slip")]
    first, second = summarise(rows)
    assert (first["case"], first["runs"], first["reached"], first["silent"], first["seeds"]) == ("none", 4, 3, 1, "1-4")
    assert (first["median_steps"], first["mean_replans"], first["causes"]) == (20.0, 2.5, {"unknown": 1})
    assert first["interval"][0] < 0.75 < first["interval"][1]
    assert (second["case"], second["runs"], second["causes"]) == ("slip", 1, {})
    (none,) = summarise([row(1, False)])
    assert none["median_steps"] is None
