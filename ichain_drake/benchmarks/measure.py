"""Measuring processor time: repeatedly, one thread, medians."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence

import numpy as np


def processor_seconds(call: Callable[[], object]) -> float:
    """Processor time of one call [s]."""
    begin = time.process_time()
    call()
    return time.process_time() - begin


def seconds_a_call(call: Callable[[], object], repeats: int = 5, number: int = 20) -> float:
    """Median over `repeats` of the mean processor time of `number` calls [s], after one call that doesn't count."""

    def several() -> None:
        for _ in range(number):
            call()

    call()
    return float(np.median([processor_seconds(several) / number for _ in range(repeats)]))


def interleaved(runs: Mapping[str, Callable[[], float]], repeats: int) -> dict[str, list[float]]:
    """Times of several things to be compared, in turns, so that a disturbance hits all of them alike.

    Args:
        runs: each sets itself up and returns its processor time [s].
        repeats: rounds.

    Returns:
        Per name, one time a round [s].
    """
    times: dict[str, list[float]] = {name: [] for name in runs}
    for _ in range(repeats):
        for name, run in runs.items():
            times[name].append(run())
    return times


def line_fit(x: Sequence[float], y: Sequence[float]) -> dict[str, float]:
    """Least-squares line: `slope`, `intercept`, and `r_squared` (1: exactly linear; 0 if y is constant)."""
    slope, intercept = np.polyfit(x, y, 1)
    residual = np.asarray(y) - (slope * np.asarray(x) + intercept)
    total = float(np.sum((np.asarray(y) - np.mean(y)) ** 2))
    r_squared = 1.0 - float(np.sum(residual**2)) / total if total > 0 else 0.0
    return {"slope": float(slope), "intercept": float(intercept), "r_squared": r_squared}
