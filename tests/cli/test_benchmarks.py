"""`ichain benchmarks`: which of its measurements is asked for."""

import pytest

from ichain_drake import benchmarks


def test_scaling_prints_its_tables(ichain, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(benchmarks, "run_scaling", lambda say: {"clusters": None})
    monkeypatch.setattr(benchmarks, "format_scaling", lambda results: f"measured {results}")
    done = ichain("benchmarks", "--scaling")
    assert done.status == 0
    assert "measured {'clusters': None}" in done.out


def test_two_measurements_at_once_and_settings_of_none_are_refused(ichain) -> None:
    done = ichain("benchmarks", "--scaling", "--profile", "car_game")
    assert done.status == 2  # noqa: PLR2004 - bad input
    assert "--profile and --scaling are two different things" in done.line
    done = ichain("benchmarks", "--scaling", "--set", "a=1")
    assert "--set is for --profile" in done.line
