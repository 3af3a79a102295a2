"""Intervals and seeds as tables say them."""

import pytest

from ichain_drake.runs.intervals import seed_words, success_interval, success_words


def test_wilsons_interval():
    # Wilson 1927; figures from his formula by hand.
    for reached, runs, low, high in ((17, 20, 0.6396, 0.9476), (0, 10, 0.0, 0.2775), (10, 10, 0.7225, 1.0)):
        assert success_interval(reached, runs) == pytest.approx([low, high], abs=1e-3)
    assert success_interval(0, 0) is None


def test_in_words():
    assert success_words(17, 20, success_interval(17, 20)) == "17/20 (.64-.95)"
    assert success_words(5, 5, success_interval(5, 5)) == "5/5 (.57-1.00)"
    assert success_words(0, 0, None) == "-"
    assert seed_words([9, 3, 7, 8, 7]) == "3, 7-9"
    assert seed_words([]) == ""
