"""What a rule is worth: pairs of trials with it and without it, of the same models."""

from typing import Any

import pytest

from ichain_drake import rules
from ichain_drake.errors import InputError
from ichain_drake.runs.goals.fresh import FreshSeed
from ichain_drake.runs.goals.variants import GoalVariant
from ichain_drake.runs.runner import run_jobs
from ichain_drake.runs.scoreboard.ablation import rule_lines, with_ablations
from ichain_drake.runs.scoreboard.cases import Case


def row(name: str, seed: int, without: str = "", steps: int = 100, **given: Any) -> dict[str, Any]:
    return {
        "row": name, "seed": seed, "without": without, "success": True, "reason": "", "control_steps": steps,
        "replans": 0, "error": 0.0, "silent": False,
    } | given  # fmt: skip


def test_lines_count_pairs_of_the_same_trial() -> None:
    rows = [
        *(row("cup/goal/ideal/none", seed) for seed in (1, 2, 3)),
        row("cup/goal/ideal/stiff", 1),
        row("cup/goal/ideal/none", 1, "a", success=False, reason="dropped", silent=True, replans=2),
        row("cup/goal/ideal/none", 2, "a", steps=200),
        row("cup/goal/ideal/none", 3, "a"),
        row("cup/goal/ideal/stiff", 1, "a", success=False),
        row("cup/goal/ideal/none", 9, "a", success=False),  # nothing to compare with
        row("cup/goal/ideal/none", 1, "b", steps=50),
    ]
    a, b, c = rule_lines(rows, ["a", "b", "c"])
    assert (a["pairs"], a["differ"], a["lost"], a["won"], a["silent"]) == (4, 3, 2, 0, 1)
    assert a["p"] == 0.5  # two of two, from either side
    assert a["steps"] == pytest.approx(2**0.5)
    assert a["replans"] == 0.5
    assert a["need"] == ["cup/goal/ideal/none", "cup/goal/ideal/stiff"]
    assert (b["pairs"], b["lost"], b["won"], b["p"], b["need"]) == (1, 0, 0, 1.0, [])
    assert b["steps"] == pytest.approx(0.5)
    assert (c["pairs"], c["steps"], c["replans"]) == (0, None, None)


def test_what_is_won_without_a_rule_speaks_against_it() -> None:
    rows = [
        row("cup/goal/ideal/none", 1), row("cup/goal/ideal/none", 2, success=False),
        row("cup/goal/ideal/none", 1, "a", success=False), row("cup/goal/ideal/none", 2, "a"),
    ]  # fmt: skip
    (line,) = rule_lines(rows, ["a"])
    assert (line["lost"], line["won"], line["p"], line["need"]) == (1, 1, 1.0, [])


def test_rows_with_a_goal_are_run_without_each_rule() -> None:
    goal, path = (Case("cup", object, task, "ideal", "none", (), 2) for task in ("goal", "eight"))  # type: ignore[arg-type]
    found = with_ablations([goal, path], ["a", "b"])
    assert [case.without for case in found] == ["", "a", "b"]
    assert {case.name for case in found} == {"cup/goal/ideal/none"}
    assert len({case.trial(3) for case in found}) == 3
    with pytest.raises(InputError, match="none of these rows has a goal"):
        with_ablations([path], ["a"])


class Shown:
    """A scenario with nothing to record."""

    graph = object()

    def __init__(self, overrides: Any = (), physics: str = "ideal", seed: int = 0) -> None:
        self.config = None

    def record_demonstrations(self) -> list[Any]:
        return []


def test_only_rules_that_were_asked_for_are_tried_and_they_are_off(monkeypatch: pytest.MonkeyPatch) -> None:
    def trials(*arguments: Any) -> list[tuple[dict[str, Any], float]]:
        return [({"success": rules.enabled("deviation"), "off": sorted(rules.switched_off())}, 0.25)]

    monkeypatch.setattr("ichain_drake.runs.goals.fresh.timed_trials", trials)
    monkeypatch.setattr("ichain_drake.runs.goals.fresh.graph_spec", lambda config: None)
    monkeypatch.setattr("ichain_drake.runs.goals.fresh.learn", lambda *arguments, **named: object())
    lines = tuple(GoalVariant("monitors", "none", without=name) for name in ("", "deviation", "subsumed"))
    job = FreshSeed(Shown, (), "ideal", 3, ("a.b >= 1",), lines, ("with", "no deviation", "not subsumed"))  # type: ignore[arg-type]
    with_it, no_deviation, not_subsumed = run_jobs([job])
    assert (with_it["success"], no_deviation["success"], not_subsumed["success"]) == (True, False, True)
    assert (with_it["off"], no_deviation["off"]) == ([], ["deviation"])
    assert not_subsumed["off"] == []  # not run: it is the run with all rules
    assert not_subsumed["plan_seconds"] == 0.25
    assert rules.switched_off() == frozenset()
