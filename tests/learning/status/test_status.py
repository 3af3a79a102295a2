"""A learned status on data: what is known to be active is let go later than it is taken up."""

from dataclasses import replace

import numpy as np
import small_job

from ichain_drake.graph import Interaction
from ichain_drake.learning import InteractionModel
from ichain_drake.learning.chain.link import EstimatorSpec
from ichain_drake.learning.settings import LEARNING
from ichain_drake.learning.status.status import _held, _left_out, _with_memory, left_out_folds

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
