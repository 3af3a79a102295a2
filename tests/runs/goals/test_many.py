"""Many trials: together where that is possible, else one by one; rows are the same to the last bit."""

from dataclasses import replace
from typing import Any

import pytest

from ichain_drake.errors import InputError
from ichain_drake.learning import InteractionModel
from ichain_drake.runs.goals import many
from ichain_drake.runs.goals.trial import Trial, timed_trial
from ichain_drake.simulation.goals_together import act_together
from ichain_drake.simulation.watching import watched_by
from ichain_drake.systems.water_dispenser.scenario import WaterDispenser

TRIAL = Trial("monitors", "none", WaterDispenser, (), "ideal", 3, 0, ("tank.amount >= 0.2",), True, 8)


@pytest.fixture
def alone(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Numbers of the trials that were run alone."""
    numbers: list[int] = []

    def counted(trial: Trial, model: InteractionModel | str) -> Any:
        numbers.append(trial.number)
        return timed_trial(trial, model)

    monkeypatch.setattr(many, "timed_trial", counted)
    return numbers


def rows(trials: list[Trial], models: list[InteractionModel | str]) -> list[dict[str, Any]]:
    return [row for row, _ in many.timed_trials(trials, models)]


def numbered(count: int, **changes: Any) -> list[Trial]:
    return [replace(TRIAL, number=k, **changes) for k in range(count)]


def test_rows_are_those_of_each_alone(dispenser_model: InteractionModel, alone: list[int]) -> None:
    trials = numbered(3)
    found = many.timed_trials(trials, [dispenser_model] * 3)
    assert alone == []
    own = [timed_trial(trial, dispenser_model) for trial in trials]
    assert [row for row, _ in found] == [row for row, _ in own]
    assert all(row["success"] for row, _ in found)
    assert all(seconds > 0 for _, seconds in found)


def test_what_was_not_learned_is_no_run(dispenser_model: InteractionModel, alone: list[int]) -> None:
    found = rows(numbered(3), [dispenser_model, "too few", dispenser_model])
    assert alone == [1]
    assert [(r["success"], r["reason"], r["cause"]) for r in found] == [
        (True, "", ""), (False, "too few", "learning"), (True, "", ""),
    ]  # fmt: skip


@pytest.mark.parametrize(("count", "changes"), [(1, {}), (2, {"overrides": ("fault.kind=dropout",)})])
def test_one_or_what_can_not_be_calculated_together_is_run_alone(
    dispenser_model: InteractionModel, alone: list[int], count: int, changes: dict[str, Any]
) -> None:
    found = rows(numbered(count, **changes), [dispenser_model] * count)
    assert alone == list(range(count))
    assert all(row["control_steps"] > 0 for row in found)


def test_with_somebody_who_looks_each_is_run_alone(dispenser_model: InteractionModel, alone: list[int]) -> None:
    assert many.nobody_looks()
    with watched_by(object()):  # type: ignore[arg-type] # who sees nothing of these
        rows(numbered(2), ["too few"] * 2)
        assert not many.nobody_looks()
    assert alone == [0, 1]


def test_a_run_that_raises_does_so_alone(
    dispenser_model: InteractionModel, alone: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    def second_raises(*given: Any) -> list[Any]:
        first, _, *others = act_together(*given)
        return [first, None, *others]

    monkeypatch.setattr(many, "act_together", second_raises)
    assert [row["success"] for row in rows(numbered(3), [dispenser_model] * 3)] == [True] * 3
    assert alone == [1]


@pytest.mark.parametrize("error", [InputError("no such goal"), ZeroDivisionError("by nought")])
def test_what_ends_all_of_them_ends_none_alone(
    dispenser_model: InteractionModel, alone: list[int], monkeypatch: pytest.MonkeyPatch, error: Exception
) -> None:
    def broken(*given: Any) -> None:
        raise error

    monkeypatch.setattr(many, "act_together", broken)
    if isinstance(error, InputError):
        found = rows(numbered(2), [dispenser_model] * 2)
    else:
        with pytest.warns(UserWarning, match="one by one: together they end in ZeroDivisionError: by nought"):
            found = rows(numbered(2), [dispenser_model] * 2)
    assert alone == [0, 1]
    assert all(row["success"] for row in found)
