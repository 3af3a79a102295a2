"""Inputs of a status: evidence that is conditional, that more demonstrations never take away, and honest borders."""

from collections.abc import Sequence
from types import SimpleNamespace

import numpy as np
import pytest

from ichain_drake.learning.selection import calibrated, calibration_error, clearly
from ichain_drake.learning.status.box import BoxClassifier
from ichain_drake.learning.status.choice import Candidate, InputChoice
from ichain_drake.learning.status.inputs import ValueInput
from ichain_drake.learning.status.status import left_out_folds

NOISE = 0.01
NAMES = ("near", "locked", "level", "elsewhere")


def rows(kind: str, rng: np.random.Generator, n: int = 240) -> tuple[np.ndarray, np.ndarray]:
    """A piece about one condition, the others met: near, unlocked and full enough; the last input is idle."""
    x = np.column_stack(
        [
            np.repeat(rng.uniform(-1, 1, n // 12), 12),
            np.zeros(n) if kind != "locked" else np.repeat(rng.integers(0, 2, n // 12), 12),
            np.full(n, rng.uniform(0.7, 1.0)) if kind != "level" else np.repeat(rng.uniform(0, 1, n // 12), 12),
            np.full(n, rng.uniform(-1, 1)),
        ]
    )
    if kind != "near":
        x[:, 0] *= 0.5
    truth = (np.abs(x[:, 0]) < 0.4) & (x[:, 1] < 0.5) & (x[:, 2] > 0.6)
    return x + NOISE * rng.normal(size=x.shape), truth


def of_parts(
    parts: Sequence[tuple[np.ndarray, np.ndarray]], names: Sequence[str]
) -> tuple[InputChoice, list[Candidate]]:
    """The choice among the columns of some pieces, and a candidate for each."""
    x, truth = np.vstack([p[0] for p in parts]), np.concatenate([p[1] for p in parts])
    piece = np.repeat(np.arange(len(parts)), [len(p[0]) for p in parts])
    candidates = [Candidate(ValueInput("thing", i, n), x[:, [i]], np.full(1, NOISE)) for i, n in enumerate(names)]
    return InputChoice(truth, piece, left_out_folds(truth, piece), np.ones(len(truth), dtype=bool)), candidates


def chosen(kinds: list[str], seed: int = 0) -> set[str]:
    rng = np.random.default_rng(seed)
    parts = [rows(kind, rng) for kind in kinds]
    choice, candidates = of_parts(parts, NAMES)
    return {c.item.label for c in choice.choose(candidates)}


NEEDED = ["near"] * 3 + ["locked"] * 4 + ["level"] * 4


@pytest.mark.parametrize("seed", range(4))
def test_every_condition_is_found_and_nothing_else(seed: int) -> None:
    assert chosen(NEEDED, seed) == {"near", "locked", "level"}


@pytest.mark.parametrize("seed", range(8))
def test_pieces_about_other_conditions_never_take_an_input_away(seed: int) -> None:
    rng = np.random.default_rng(seed)
    more = list(rng.choice(["near", "near", "locked", "level"], rng.integers(1, 9)))
    assert chosen(NEEDED + more, seed) >= chosen(NEEDED, seed)


def test_parts_that_tell_nothing_change_nothing_and_one_alone_is_not_clear() -> None:
    assert clearly([3.0, 2.0])
    assert clearly([3.0, 2.0, *np.zeros(50)])
    assert not clearly([3.0, *np.zeros(50)])
    assert not clearly([3.0, 2.0], tried=200)


def test_a_face_lies_where_the_truth_switches_though_readings_are_noisy() -> None:
    rng = np.random.default_rng(3)
    true = np.concatenate([np.linspace(-1.0, 1.0, 400), rng.uniform(-1, 1, 200)])
    read = true + 0.1 * rng.normal(size=len(true))
    on = np.abs(true) < 0.5
    box = BoxClassifier(noise=0.1).fit(read[:, None], on)
    np.testing.assert_allclose([box.lower_[0], box.upper_[0]], [-0.5, 0.5], atol=0.03)


def test_probabilities_are_those_of_rows_left_out() -> None:
    rng = np.random.default_rng(4)
    decisions = rng.normal(size=4000)
    truth = decisions + 0.3 * rng.normal(size=4000) > 0
    spread, slip, likelihood = calibrated(decisions, truth, 1e-3)
    assert spread == pytest.approx(0.3, rel=0.3)
    assert slip < 0.02
    assert likelihood.mean() > np.log(0.8)
    assert calibration_error(np.full(100, 0.7), np.arange(100) < 70) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(("gains", "chosen"), [([1.3, 1.6], False), ([2.6, 3.2], True)])
def test_what_one_wrong_flag_would_make_up_chooses_no_input(
    gains: list[float], *, chosen: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two pieces agree, but in 100 rows with a switch a flag is wrong with a probability of one in 51: 3.9 nat."""
    truth, rows = np.arange(100) >= 50, np.arange(100)
    choice = InputChoice(truth, rows // 50, rows % 5, ~truth)
    monkeypatch.setattr(choice, "_gains", lambda *_, **__: np.array(gains))
    one = Candidate(SimpleNamespace(), np.zeros((100, 1)), np.ones(1))  # type: ignore[arg-type]
    assert choice._further([], [one], by_role=True) == ([one] if chosen else [])


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_of_two_that_tell_about_the_same_the_one_that_is_listed_first_is_taken(order: tuple[int, int]) -> None:
    rng = np.random.default_rng(5)
    near = np.concatenate([np.repeat(rng.uniform(-1, 1, 20), 12) for _ in range(6)])
    truth, piece = np.abs(near) < 0.4, np.repeat(np.arange(6), 240)
    first = near[:, None] + NOISE * rng.normal(size=(len(near), 1))
    readings = [first, first + 0.1 * NOISE * rng.normal(size=first.shape)]
    candidates = [Candidate(ValueInput("thing", i, str(i)), readings[i], np.full(1, NOISE)) for i in order]
    choice = InputChoice(truth, piece, left_out_folds(truth, piece), np.ones(len(truth), dtype=bool))
    assert [c.item.label for c in choice.choose(candidates)] == [str(order[0])]


@pytest.mark.parametrize("hopeful", [True, False])
def test_two_that_only_add_something_together_are_taken_if_what_is_seen_promises_it(
    *, hopeful: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With one of two conditions alone, the piece about the other is unlike all others when it is left out."""
    truth, rows = np.arange(100) >= 50, np.arange(100)
    choice = InputChoice(truth, rows // 50, rows % 5, ~truth)

    def gains(chosen: list[Candidate], further: tuple[Candidate, ...], *, seen: bool = False) -> np.ndarray:
        told = len(further) == 2 or (seen and hopeful)
        return np.array([7.0, 6.0]) if told else np.array([1.0, -20.0])

    monkeypatch.setattr(choice, "_gains", gains)
    two = [Candidate(SimpleNamespace(), np.zeros((100, 1)), np.ones(1)) for _ in range(2)]  # type: ignore[arg-type]
    assert choice._further([], two, by_role=True) == (two if hopeful else [])


def test_of_inputs_that_tell_the_same_the_one_that_is_missed_least_goes(monkeypatch: pytest.MonkeyPatch) -> None:
    """A third mends a little of what the second left, and tells by chance most of what that tells in one piece."""
    switch, place, water = (Candidate(SimpleNamespace(), np.zeros((100, 1)), np.ones(1)) for _ in range(3))  # type: ignore[arg-type]
    gains = {
        ((), switch): [400.0, 400.0],
        ((switch,), place): [35.0, 62.0],
        ((switch,), water): [0.0, 70.0],
        ((switch, place), water): [4.1, 8.1],
        ((switch, water), place): [35.0, 0.0],
        ((place,), switch): [300.0, 300.0],
        ((place, water), switch): [300.0, 300.0],
    }

    def gained(self: InputChoice, chosen: list[Candidate], further: tuple[Candidate, ...], **more: bool) -> np.ndarray:
        return np.array(gains.get((tuple(chosen), further[0]), [0.0, 0.0]))

    monkeypatch.setattr(InputChoice, "_gains", gained)
    order = iter([[switch], [place], [water], [], []])
    monkeypatch.setattr(InputChoice, "_further", lambda self, chosen, free, **more: next(order, []))
    truth = np.arange(100) % 50 < 25
    made = InputChoice(truth, np.repeat([0, 1], 50), np.repeat([0, 1], 50), ~truth)
    assert made._searched([switch, place, water], by_role=True) == [switch, place]


def a_choice(x: np.ndarray, truth: np.ndarray, piece: np.ndarray) -> tuple[InputChoice, list[Candidate]]:
    columns = [Candidate(ValueInput("thing", i, f"x{i}"), x[:, [i]], np.full(1, NOISE)) for i in range(x.shape[1])]
    return InputChoice(truth, piece, piece, np.ones(len(truth), dtype=bool)), columns


def test_readings_of_one_state_are_one_observation_of_its_flag() -> None:
    x = np.array([[0.0, 0.0], [0.02, 0.0], [-0.02, 5.0], [1.0, 5.0], [1.01, 5.0], [1.0, 5.0], [1.0, 5.0]])
    truth = np.array([0, 0, 0, 0, 0, 1, 1], dtype=bool)
    choice, (one, other) = a_choice(x, truth, np.array([0, 0, 0, 0, 0, 0, 1]))
    np.testing.assert_allclose(choice._share([one]), [1 / 3] * 3 + [1 / 2] * 2 + [1, 1])
    np.testing.assert_allclose(choice._share([other]), [1 / 2] * 2 + [1 / 3] * 3 + [1, 1])
    np.testing.assert_allclose(choice._share([one, other]), [1 / 2] * 2 + [1] + [1 / 2] * 2 + [1, 1])
    slow, (drift,) = a_choice(np.arange(8.0)[:, None] * 3 * NOISE, np.zeros(8, dtype=bool), np.zeros(8, dtype=int))
    np.testing.assert_allclose(slow._share([drift]), 1 / 2, err_msg="what goes on slowly is not one state")


def test_who_stands_longer_tells_no_more() -> None:
    rng = np.random.default_rng(3)
    x, piece = rng.uniform(-1, 1, (60, 2)), np.repeat(np.arange(6), 10)
    truth = (np.abs(x[:, 0]) < 0.5) & (x[:, 1] < 0.3)
    (once, (a, b)), (often, (c, d)) = (
        a_choice(*(np.repeat(v, n, axis=0) for v in (x, truth, piece))) for n in (10, 40)
    )
    for new, old in (((b,), (a,)), ((a,), ())):
        there = {id(a): c, id(b): d}
        gains = once._gains(old, new), often._gains([there[id(k)] for k in old], [there[id(k)] for k in new])
        assert gains[0].sum() > 3
        assert gains[1].sum() < 1.5 * gains[0].sum(), "a wrong flag is less likely among many, and that is all"


@pytest.mark.parametrize("seed", range(3))
def test_what_was_taken_before_a_switch_was_known_gives_way_to_what_tells_more_beside_it(seed: int) -> None:
    """A switch is pressed in a few pieces, with a pot on or off its plate; in most others a jug is moved about."""
    rng, parts = np.random.default_rng(seed), []
    for kind in ["on"] * 6 + ["off"] * 8 + ["jug"] * 9:
        n = 60
        pot = np.full(n, rng.uniform(-0.3, 0.3) if kind == "on" else rng.choice([-1, 1]) * rng.uniform(0.6, 1.0))
        jug = np.full(n, rng.uniform(-0.1, 0.1) if kind == "on" else rng.uniform(-0.3, 0.3))
        if kind == "jug":
            pot, jug = np.full(n, rng.uniform(-0.3, 0.3)), np.cumsum(rng.normal(scale=0.3, size=n)) + 0.5
        switch = (np.arange(n) % 12 < 6).astype(float) * (kind != "jug")
        truth = (np.abs(pot) < 0.45) & (switch > 0.5)
        parts.append((np.column_stack([pot, jug, switch]) + NOISE * rng.normal(size=(n, 3)), truth))
    choice, candidates = of_parts(parts, ("pot", "jug", "switch"))
    item, other, switch_item = (candidates[k] for k in (0, 1, 2))
    assert choice._exchanged([other, switch_item], candidates, by_role=True) == [item, switch_item]
    assert choice._exchanged([item, switch_item], candidates, by_role=True) == [item, switch_item]
    assert {c.item.label for c in choice.choose(candidates)} == {"pot", "switch"}


@pytest.mark.parametrize("seed", range(4))
def test_what_changes_all_the_time_is_worth_no_more_than_a_switch_that_tells_as_much_of_it(seed: int) -> None:
    """A hand points down while a switch is pressed, and just before; in most pieces it turns, and no switch is."""
    rng, parts = np.random.default_rng(seed), []
    for kind in ["long"] + ["on"] * 3 + ["off"] * 4 + ["carry"] * 12:
        n = 60
        pot = np.full(n, rng.uniform(-0.3, 0.3) if kind != "off" else rng.choice([-1, 1]) * rng.uniform(0.6, 1.0))
        pitch, switch = np.zeros(n), (np.arange(n) >= 6).astype(float)
        if kind == "long":
            switch = (np.arange(n) % 8 < 4).astype(float)
        if kind == "carry":
            pitch, switch = 0.3 + np.abs(np.cumsum(rng.normal(scale=0.3, size=n))), np.zeros(n)
        truth = (np.abs(pot) < 0.45) & (switch > 0.5)
        parts.append((np.column_stack([pot, pitch, switch]) + NOISE * rng.normal(size=(n, 3)), truth))
    choice, candidates = of_parts(parts, ("pot", "pitch", "switch"))
    pitch_input, switch_input = candidates[1:]
    own = [choice._gains([], (c,)).sum() for c in (pitch_input, switch_input)]
    assert own[0] > own[1], "by its own stays"
    assert choice._more([], (switch_input,), (pitch_input,)).sum() > 0.0
    assert {c.item.label for c in choice.choose(candidates)} == {"pot", "switch"}
