"""A learned status on data: what is known to be active is let go later than it is taken up."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import small_job
from scipy.stats import norm

from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction
from ichain_drake.learning import InteractionModel
from ichain_drake.learning.chain.link import EstimatorSpec
from ichain_drake.learning.settings import LEARNING
from ichain_drake.learning.status.choice import Candidate, input_scales
from ichain_drake.learning.status.inputs import ValueInput
from ichain_drake.learning.status.status import (
    StatusModel,
    _fit,
    _held,
    _left_out,
    _of_ends,
    _with_memory,
    always_active,
    input_choice,
    left_out_folds,
)

EDGE = Interaction.parse("tap->box")


def with_hysteresis(margin: float) -> InteractionModel:
    model, _, _ = small_job.learned()
    learned = model.edges[EDGE]
    return replace(model, edges={**model.edges, EDGE: replace(learned, status=replace(learned.status, margin=margin))})


def along_a_line(model: InteractionModel) -> dict[str, np.ndarray]:
    """A box that is moved past the tap: no interaction, interaction, none again."""
    under = model.edges[EDGE].examples.active
    states = {n: np.repeat(np.median(under[n], axis=0)[None], 201, axis=0) for n in model.graph.objects}
    states["box"][:, 0] += np.linspace(-0.15, 0.15, 201)
    return states


def test_what_was_active_stays_so_a_little_longer_and_what_was_not_begins_where_it_always_does() -> None:
    model = with_hysteresis(0.2)
    states = along_a_line(model)
    plain = model.active(states)[EDGE]
    assert 20 < plain.sum() < 180
    before = {was: {e: np.full(201, was) for e in model.graph.interactions} for was in (False, True)}
    begins, lasts = (model.active(states, before[was])[EDGE] for was in (False, True))
    np.testing.assert_array_equal(begins, plain)
    assert (lasts >= plain).all()
    on, longer = np.flatnonzero(plain), np.flatnonzero(lasts)
    assert longer[0] < on[0], "on the way in"
    assert longer[-1] > on[-1], "on the way out"
    assert lasts.sum() < 200, "but not for ever"


def test_without_a_margin_the_past_does_not_count() -> None:
    model = with_hysteresis(0.0)
    states = along_a_line(model)
    was = {e: np.ones(201, dtype=bool) for e in model.graph.interactions}
    np.testing.assert_array_equal(model.active(states, was)[EDGE], model.active(states)[EDGE])


def test_a_status_that_holds_is_let_go_beyond_its_margin_alone() -> None:
    decisions = np.array([-0.1, -0.3, 0.2, -0.1, -0.2, -0.25, -0.1, 0.0])
    assert _held(decisions, 0.2).tolist() == [False, False, True, True, True, False, False, True]
    assert _held(decisions, 0.0).tolist() == (decisions >= 0).tolist()
    assert _held(np.array([0.0, -0.1]), 0.1).tolist() == [True, True]


def test_pieces_are_left_out_whole_with_the_active_rows_dealt_evenly() -> None:
    active = {0: 8, 1: 7, 2: 5, 3: 4, 4: 3, 5: 2, 6: 0, 7: 0}
    piece = np.repeat(list(active), 10)
    truth = np.concatenate([np.arange(10) < n for n in active.values()])
    fold = left_out_folds(truth, piece)
    of_piece = {int(p): {int(f) for f in fold[piece == p]} for p in active}
    assert all(len(f) == 1 for f in of_piece.values())
    assert [min(of_piece[p]) for p in range(6)] == [0, 1, 2, 3, 4, 4], "the most go to where fewest are"
    few = left_out_folds(truth & (piece < LEARNING.folds - 1), piece)
    assert set(few) == set(range(LEARNING.folds)), "blocks where few pieces show any"


def test_left_out_decisions_are_of_classifiers_that_have_not_seen_the_rows() -> None:
    """Two pieces that say the opposite of each other: each is decided as the other has it."""
    x = np.tile(np.linspace(-1.0, 1.0, 40), 2)[:, None]
    fold = np.repeat([0, 1], 40)
    y = (x[:, 0] > 0.0) ^ (fold == 1)
    box = EstimatorSpec.parse("box(reach=0.15)")
    decided = _left_out(box, x, np.full(1, 0.01), y, fold, EDGE) >= 0.0
    assert np.mean(decided == ~y) > 0.9
    alone = _left_out(box, x, np.full(1, 0.01), fold == 1, fold, EDGE)
    np.testing.assert_array_equal(alone, np.where(fold == 0, 1.0, -1.0), "the other piece shows nothing else")


def test_hysteresis_is_learned_where_what_holds_goes_on_holding_beyond_where_it_begins() -> None:
    piece = np.repeat(np.arange(4), 60)
    decisions = np.tile(np.concatenate([np.linspace(-1.0, 1.0, 30), np.linspace(1.0, -1.0, 30)]), 4)
    truth, before = np.zeros(240, dtype=bool), np.zeros(240, dtype=bool)
    for k, value in enumerate(decisions):
        before[k] = truth[k - 1] if k % 60 else False
        truth[k] = value >= (-0.5 if before[k] else 0.0)
    assert _with_memory(decisions, truth, before, piece)[0] > 0.0
    assert _with_memory(decisions, decisions >= 0.0, before, piece)[0] == 0.0


class Told:
    """A frozen model whose decision value is the sum of its columns."""

    n_out = 1

    def batch(self, x: np.ndarray) -> np.ndarray:
        return x.sum(axis=1, keepdims=True)


def status(margin: float = 0.2, spread: float = 0.5, slip: float = 0.1) -> StatusModel:
    model: Any = Told()
    inputs = (ValueInput("box", 0, "box.x"), ValueInput("hand", 1, "hand.y"))
    return StatusModel(
        inputs, np.array([1.0, 2.0]), np.array([2.0, 4.0]), model, margin, spread, slip, "told", 1, 1, 0, 0, 9, 4
    )


STATES = {
    "box": np.array([[1.0], [3.0], [0.0], [0.8]]),
    "hand": np.array([[9.0, 2.0], [9.0, 6.0], [9.0, 1.0], [9.0, 2.0]]),
}
VALUES = np.array([0.0, 2.0, -0.75, -0.1])


def test_inputs_are_scaled_and_decided_by() -> None:
    np.testing.assert_allclose(status().columns(STATES), [[0.0, 0.0], [1.0, 1.0], [-0.5, -0.25], [-0.1, 0.0]])
    np.testing.assert_allclose(status().decide(STATES), VALUES)
    assert status().active(STATES).tolist() == [True, True, False, False]
    was = np.array([True, False, True, True])
    assert status().active(STATES, was).tolist() == [True, True, False, True]
    assert status().active(STATES, ~was).tolist() == [True, True, False, False]
    assert status(margin=0.0).active(STATES, was).tolist() == [True, True, False, False]


def test_a_probability_is_that_of_a_slip_and_of_a_decision_within_its_spread() -> None:
    np.testing.assert_allclose(status().probability(STATES), 0.1 + 0.8 * norm.cdf(VALUES / 0.5))
    was = np.array([True, False, True, True])
    np.testing.assert_allclose(status().probability(STATES, was), 0.1 + 0.8 * norm.cdf((VALUES + 0.2 * was) / 0.5))
    assert status().probability(STATES)[0] == pytest.approx(0.5), "on its border"


def test_what_was_never_seen_inactive_is_always_active_but_for_a_slip() -> None:
    always = always_active(18)
    assert always.active(STATES).all()
    np.testing.assert_allclose(always.probability(STATES), 0.05 + 0.9 * norm.cdf(always.decide(STATES)))
    assert (always.inputs, always.slip, always.samples, always.positives) == ((), 0.05, 18, 18)
    assert always.likelihood == pytest.approx(np.log(0.95))


def test_ends_alone_are_looked_at_where_nothing_is_told_apart() -> None:
    found = [Candidate(ValueInput(n, 0, n), np.zeros((2, 1)), np.ones(1)) for n in ("tap", "lid", "box", "hand")]
    assert [c.item.label for c in _of_ends(found, EDGE)] == ["tap", "box"]


def test_a_row_may_begin_what_was_inactive_in_the_row_before_or_is_the_first_of_its_piece() -> None:
    flags = [np.array([c == "1" for c in text]) for text in ("0110", "1101")]
    data: Any = SimpleNamespace(flag=lambda e: np.concatenate(flags), piece_index=lambda: np.repeat([0, 1], 4))
    assert input_choice(data, EDGE).begins.tolist() == [True, True, False, False, True, False, False, True]


def test_few_pieces_are_left_out_in_blocks_and_more_than_folds_share_them() -> None:
    truth = np.tile([True, False], 30)
    two = left_out_folds(truth, np.repeat([0, 1], 30))
    assert len(set(two[:30])) > 1
    many = LEARNING.folds + 3
    piece = np.repeat(np.arange(many), 4)
    fold = left_out_folds(np.tile([True, False, False, False], many), piece)
    assert sorted(set(fold)) == list(range(LEARNING.folds))
    assert np.bincount(fold).max() <= 2 * 4


def test_an_estimator_that_can_not_be_fitted_is_named_with_its_interaction() -> None:
    x, y = np.linspace(-1, 1, 20)[:, None], np.arange(20) > 9
    with pytest.raises(InputError, match=r"tap->box, status: box\(reach=-1.0\): .*reach"):
        _fit(EstimatorSpec.parse("box(reach=-1.0)"), x, np.full(1, 0.01), y, EDGE)
    three = np.tile([0, 1, 2], 7)[:20]
    with pytest.raises(InputError, match="tap->box, status: "):
        _fit(EstimatorSpec.parse("box"), x, np.full(1, 0.01), three, EDGE)


def test_scales_lie_between_the_spread_of_active_rows_and_of_all() -> None:
    rng = np.random.default_rng(0)
    truth = np.arange(200) < 50
    raw = np.column_stack(
        [np.where(truth, 5.0 + 0.1 * rng.normal(size=200), 3.0 * rng.normal(size=200)), rng.normal(size=200)]
    )
    raw = np.column_stack([raw, np.where(truth, 2.0, rng.normal(size=200)), np.full(200, 4.0)])
    offset, scale = input_scales(raw, truth, np.array([0.01, 0.01, 0.2, 0.0]))
    np.testing.assert_allclose(offset, np.median(raw[:50], axis=0))
    every, inside = raw.std(axis=0), raw[:50].std(axis=0)
    np.testing.assert_allclose(scale[0], np.sqrt(inside[0] * every[0]))
    np.testing.assert_allclose(scale[1], np.sqrt(inside[1] * max(every[1], inside[1])))
    np.testing.assert_allclose(scale[2], np.sqrt(0.4 * every[2]), err_msg="no less than twice the noise")
    np.testing.assert_allclose(scale[3], 1e-9)
