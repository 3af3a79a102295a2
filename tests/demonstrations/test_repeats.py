"""Stretches that are in a recording twice."""

import numpy as np
import pandas as pd

from ichain_drake.demonstrations import Demonstration
from ichain_drake.demonstrations.repeats import FEWEST, repeats

RNG = np.random.default_rng(0)


def table(rows: list[int]) -> Demonstration:
    """Rows of one noisy recording, in this order."""
    values = np.random.default_rng(1).standard_normal(60)
    return Demonstration(pd.DataFrame({"time": np.arange(len(rows)) / 3.0, "a.x": values[rows], "b.on": 0.0}))


def test_a_stretch_written_twice_is_found() -> None:
    assert repeats(table([*range(30), *range(10, 20), *range(30, 40)]), ["a.x"]) == [(30, 39, 10)]
    assert repeats(table([*range(20), *range(20)]), ["a.x"]) == [(20, 39, 0)]


def test_what_is_no_repetition() -> None:
    assert repeats(table(list(range(40))), ["a.x"]) == []
    assert repeats(table([*range(30), *range(10, 10 + FEWEST - 1), *range(30, 40)]), ["a.x"]) == []
    assert repeats(table([0] * 20 + list(range(20))), ["a.x"]) == []  # a feed that froze
    assert repeats(table([*range(20), *range(20)]), []) == []  # without noise equal readings mean nothing
    assert repeats(table([*range(20), *range(20)]), ["c.x"]) == []
