"""Resets by likelihood: what an object does often is its motion, and no reset."""

import numpy as np
import pytest

from ichain_drake.learning.discovery.resets import _telling, _tells, find_resets
from ichain_drake.learning.settings import LEARNING
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


def test_what_turns_on_and_on_is_not_reset_where_its_angle_wraps() -> None:
    yaw = StateSpace("wheel", (Variable("yaw", "rad", -np.pi, np.pi, "angle"),))
    turned = 0.4 * np.arange(ROWS)[:, None] + 1e-3 * np.random.default_rng(0).standard_normal((ROWS, 1))
    wheel = (turned + np.pi) % (2 * np.pi) - np.pi
    for resets in ([], RESETS):
        (only,) = find_resets([log(resets) | {"wheel": wheel}], SPACES | {"wheel": yaw})
        assert (np.flatnonzero(only.probability > 0.5) + 1).tolist() == resets
        assert not only.jumped["wheel"].any()


def test_what_springs_there_and_back_is_not_reset() -> None:
    """A lid that is open for some rows, and then shut again, ten times in all."""
    lid = np.where(np.arange(ROWS)[:, None] % 40 < 8, 1.0, 0.0) * [1.0, 0.5]
    lid = lid + 1e-3 * np.random.default_rng(1).standard_normal(lid.shape)
    assert found(log([]) | {"box": lid}) == []
    assert found(log(RESETS, anew=("hand", "cup")) | {"box": lid}) == RESETS


def test_what_is_dissolved_in_next_to_nothing_tells_nothing() -> None:
    space = StateSpace(
        "jug", (Variable("water", role=Role("amount")), Variable("heat", role=Role("intensive", of="water")))
    )
    rng = np.random.default_rng(2)
    heat = np.ones(ROWS)
    for row in range(5, ROWS, 9):
        heat[row:] = rng.uniform(0.0, 5.0)
    jug = np.column_stack([np.zeros(ROWS), heat]) + 1e-3 * rng.standard_normal((ROWS, 2))
    (only,) = find_resets([log(RESETS) | {"jug": jug}], SPACES | {"jug": space})
    assert (np.flatnonzero(only.probability > 0.5) + 1).tolist() == RESETS
    noise = np.array([0.01, 0.01])
    before, after = np.array([[0.2, 0.0], [0.2, 0.0], [0.1, 0.0]]), np.array([[0.2, 9.0], [0.14, 9.0], [0.2, 9.0]])
    least = LEARNING.empty * 0.01
    expected = [[True, min(a, b) >= least] for a, b in ((0.2, 0.2), (0.2, 0.14), (0.1, 0.2))]
    assert _telling(space, noise, before, after).tolist() == expected == [[True, True], [True, False], [True, False]]


def test_what_switches_counts_or_follows_is_not_looked_at() -> None:
    space = StateSpace(
        "thing",
        (
            Variable("x"),
            Variable("yaw", "rad", kind="angle"),
            Variable("on", kind="binary", lower=0, upper=1),
            Variable("count", kind="integer", lower=0, upper=9),
            Variable("water", role=Role("amount")),
            Variable("flow", role=Role("change", of="water")),
            Variable("drops", kind="integer", lower=0, upper=9, role=Role("amount")),
            Variable("step", kind="integer", lower=0, upper=9, role=Role("level")),
        ),
    )
    assert [space.names[i] for i in range(8) if _tells(space, i)] == ["x", "yaw", "water", "drops"]


def test_a_reset_is_one_where_several_are_at_once_where_none_of_them_comes_by_itself() -> None:
    """A box that jumps now and then by itself, and one that never does."""
    states = log([])
    rng = np.random.default_rng(6)
    for row in range(5, ROWS, 8):
        states["box"][row:] = rng.uniform(0.0, 1.0, 2) + 1e-3 * rng.standard_normal((ROWS - row, 2))
    assert found(states) == [], "that is how it moves"
    (only,) = find_resets([log([120])], SPACES)
    assert only.probability[119] > 0.99
    assert np.delete(only.probability, 119).max() < 0.5
    assert {n: jumps[119] for n, jumps in only.jumped.items()} == dict.fromkeys(("hand", "cup", "box"), True)
    assert all(np.delete(jumps, 119).sum() == 0 for jumps in only.jumped.values())
