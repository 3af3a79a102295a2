"""What fits warn of is told in one line, of which the count is right and the place is where they were called."""

import warnings
from pathlib import Path

import pytest

from ichain_drake.learning.estimators.warned import EstimatorWarning, collected_warnings


def told(*texts: str) -> list[str]:
    said: list[str] = []
    with collected_warnings(said.append):
        for text in texts:
            warnings.warn(text, RuntimeWarning, stacklevel=1)
    return said


def test_each_kind_is_told_by_its_first_sentence_and_how_often_it_came() -> None:
    assert told() == []
    assert told("odd. Do this") == ["estimators warned 1 times: RuntimeWarning: odd"]
    assert told("odd", "odd. Again") == ["estimators warned 2 times: RuntimeWarning: odd (2 times)"]
    assert told("a", "b", "b", "c", "c", "c", "d") == [
        "estimators warned 7 times: RuntimeWarning: c (3 times); RuntimeWarning: b (2 times); RuntimeWarning: a"
    ]


def test_a_line_from_inside_is_passed_on_as_it_is_and_two_are_counted() -> None:
    for times, start in ((1, "estimators warned 1 times: RuntimeWarning: a"), (2, "estimators warned 2 times: est")):
        said: list[str] = []
        with collected_warnings(said.append):
            for _ in range(times):
                with collected_warnings():
                    warnings.warn("a", RuntimeWarning, stacklevel=1)
        (line,) = said
        assert line.startswith(start)


def test_the_warning_points_at_the_caller() -> None:
    with pytest.warns(EstimatorWarning) as seen, collected_warnings():
        warnings.warn("a", RuntimeWarning, stacklevel=1)
    assert [Path(one.filename).name for one in seen] == [Path(__file__).name]
