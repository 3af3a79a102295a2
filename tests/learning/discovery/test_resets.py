"""Resets by likelihood: what an object does often is its motion, and no reset."""

import numpy as np
import pytest

from ichain_drake.learning.discovery.resets import find_resets
from ichain_drake.state import FloatArray, Role, StateSpace, Variable

SPACES = {
    n: StateSpace(n, tuple(Variable(a, "m", role=Role("position", "table", a)) for a in "xy"))
    for n in ("hand", "cup", "box")
} | {"key": StateSpace("key", (Variable("on", kind="binary", lower=0, upper=1),))}
ROWS, RESETS = 400, [90, 170, 171, 320]


def log(resets: list[int], seed: int = 0, anew: tuple[str, ...] = ("hand", "cup", "box")) -> dict[str, FloatArray]:
    """A hand that goes about and takes the cup with it half of the time; all are put somewhere at resets."""
    rng = np.random.default_rng(seed)
    place = {n: rng.uniform(0, 1, 2) for n in ("hand", "cup", "box")}
    out: dict[str, list[FloatArray]] = {n: [] for n in SPACES}
    for row in range(ROWS):
        step = rng.uniform(-0.05, 0.05, 2) * (row % 4 > 0)
        place["hand"] = place["hand"] + step
        if row // 20 % 2:
            place["cup"] = place["cup"] + step
        if row in resets:
            place |= {n: rng.uniform(0, 1, 2) for n in anew}
        for name, p in place.items():
            out[name].append(p + 1e-3 * rng.standard_normal(2))
        out["key"].append(np.array([float(row // 7 % 2)]))
    return {n: np.array(v) for n, v in out.items()}


def found(states: dict[str, FloatArray]) -> list[int]:
    (only,) = find_resets([states], SPACES)
    assert only.probability.shape == (ROWS - 1,)
    return (np.flatnonzero(only.probability > 0.5) + 1).tolist()


@pytest.mark.parametrize("seed", range(3))
def test_all_resets_are_found_and_no_other(seed: int) -> None:
    assert found(log(RESETS, seed)) == RESETS
    assert found(log([], seed)) == []


def test_one_thing_that_is_put_elsewhere_is_a_reset_too() -> None:
    assert found(log([120, 250], anew=("box",))) == [120, 250]
    (only,) = find_resets([log([120], anew=("box",))], SPACES)
    assert [n for n, jumps in only.jumped.items() if jumps[119]] == ["box"]


def test_what_is_thrown_about_all_the_time_is_not_reset() -> None:
    states = log(RESETS)
    wild = np.random.default_rng(5).uniform(0, 1, (ROWS, 2))
    assert found(states | {"box": wild}) == RESETS
    assert found(log([]) | {"box": wild}) == []


def test_motions_are_known_from_all_stretches() -> None:
    whole = log(RESETS)
    parts = [{n: x[a:b] for n, x in whole.items()} for a, b in ((0, 90), (90, 170), (171, 320), (320, ROWS))]
    assert all(r.probability.max() < 0.5 for r in find_resets(parts, SPACES))
    fewer = [parts[0], {n: parts[1][n] for n in ("hand", "cup")}, {n: x[:1] for n, x in parts[2].items()}]
    assert [len(r.probability) for r in find_resets(fewer, SPACES)] == [89, 79, 0]


def test_what_only_switches_tells_nothing() -> None:
    (only,) = find_resets([{"key": log([])["key"]}], SPACES)
    assert only.probability.tolist() == [0.0] * (ROWS - 1)
    assert find_resets([], SPACES) == []
