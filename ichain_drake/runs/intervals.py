"""How sure a share of successes is, and which seeds it is of: what every table says beside it."""

from __future__ import annotations

from collections.abc import Iterable

from scipy.stats import binomtest

CONFIDENCE = 0.95
"""Of all intervals that are printed."""


def success_interval(reached: int, runs: int) -> list[float] | None:
    """Wilson's interval of the share of successes, lowest and highest, each in [0, 1]; None without a run.

    Args:
        reached: successes.
        runs: of how many.
    """
    if not runs:
        return None
    found = binomtest(reached, runs).proportion_ci(CONFIDENCE, method="wilson")
    return [round(float(found.low), 6), round(float(found.high), 6)]


def success_words(reached: int, runs: int, interval: list[float] | None) -> str:
    """As in `17/20 (.64-.95)`: successes, runs, and their interval."""
    if interval is None:
        return "-"
    low, high = (f"{x:.2f}".removeprefix("0") for x in interval)
    return f"{reached}/{runs} ({low}-{high})"


def seed_words(seeds: Iterable[int]) -> str:
    """Seeds in words: `3, 7-9`."""
    parts: list[list[int]] = []
    for seed in sorted({int(s) for s in seeds}):
        if parts and seed == parts[-1][1] + 1:
            parts[-1][1] = seed
        else:
            parts.append([seed, seed])
    return ", ".join(str(a) if a == b else f"{a}-{b}" for a, b in parts)
