"""Conformal intervals of a learned model: they cover what they say of further pieces, however wrong the spreads are."""

from dataclasses import replace

import numpy as np
import pytest
from small_world import GRAPH, pieces

from ichain_drake.demonstrations import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction
from ichain_drake.learning import InteractionModel
from ichain_drake.learning.calibration import normal_factor
from ichain_drake.learning.intervals import Intervals, conformal_intervals
from ichain_drake.learning.residuals import Part, tick_scores

FILL, OPEN = Interaction("tap", "box"), Interaction("valve", "tap")


def recorded(*seeds: int) -> list[Demonstration]:
    """Pieces of several seeds; each shows an interaction in a few starts of its own."""
    return [replace(p, name=f"{p.name} of {seed}") for seed in seeds for p in pieces(seed)]


NEW = recorded(5, 6, 7, 8)


@pytest.fixture(scope="module")
def aside() -> list[Demonstration]:
    return recorded(1, 2, 3, 4)


@pytest.fixture(scope="module")
def intervals(model: InteractionModel, aside: list[Demonstration]) -> Intervals:
    return conformal_intervals(model, aside)


def test_intervals_cover_what_they_say(intervals: Intervals, model: InteractionModel) -> None:
    raw = []
    for part, found in tick_scores(model, NEW).items():
        for level in (0.5, 0.9):
            assert np.mean(found.sizes <= intervals.factor(part, level)) == pytest.approx(level, abs=0.05), part
        raw.append(np.mean(found.sizes <= normal_factor(0.5)))
    assert max(raw) > 0.8, "by its spread alone, a mixture is told much better than it says"


def test_a_model_that_is_too_sure_is_corrected(
    intervals: Intervals, model: InteractionModel, aside: list[Demonstration]
) -> None:
    sure = model.passive["lamp"]
    sure = replace(sure, variables=tuple(replace(v, std=v.std / 5.0) for v in sure.variables))
    wrong = replace(model, passive={**model.passive, "lamp": sure})
    part = Part("lamp", 0, None)
    scores = tick_scores(wrong, NEW)[part].sizes
    assert np.mean(scores <= 1.645) < 0.4, "of what it takes for 90 %"
    corrected = conformal_intervals(wrong, aside)
    assert np.mean(scores <= corrected.factor(part, 0.9)) == pytest.approx(0.9, abs=0.05)
    same = intervals.half_width("lamp", [], 0.9)
    np.testing.assert_allclose(corrected.half_width("lamp", [], 0.9), same, rtol=0.02)


def test_half_widths_are_spreads_times_factors(intervals: Intervals, model: InteractionModel) -> None:
    found = intervals.half_width("box", [FILL], 0.9)
    spread, water = model.spread("box", [FILL]), GRAPH.objects["box"].observable.index("water")
    assert found.shape == spread.shape
    (source,) = {p.source for p in intervals.scores if p[:2] == ("box", water) and p.source == FILL}
    assert found[water] == spread[water] * intervals.factor(Part("box", water, source), 0.9)
    assert (intervals.half_width("box", [FILL], 0.5) < found).all()
    assert np.isnan(intervals.half_width("valve", [], 0.9)).all(), "a whole number has no interval"


def test_what_was_not_shown_has_no_bounds(intervals: Intervals) -> None:
    bare = replace(intervals, scores={})
    assert np.isinf(bare.half_width("lamp", [], 0.5)).all()


def test_the_pieces_that_were_learned_from_tell_nothing(
    model: InteractionModel, demonstrations: list[Demonstration]
) -> None:
    with pytest.raises(InputError, match="the model was learned from these pieces: .* give it others"):
        conformal_intervals(model, demonstrations)


@pytest.mark.parametrize(
    ("child", "active", "level", "words"),
    [
        ("box", [], 1.0, "level 1.0: a predictive interval covers a share between 0 and 1"),
        ("hand", [], 0.9, "hand: nothing predicts it; there are intervals of box, valve, tap, lamp"),
        ("box", [OPEN], 0.9, "valve->tap does not act on box; hand->box, tap->box do"),
        ("box", ["fill"], 0.9, "fill does not act on box"),
    ],
)
def test_what_has_no_interval_is_refused(
    intervals: Intervals, child: str, active: list, level: float, words: str
) -> None:
    with pytest.raises(InputError, match=words):
        intervals.half_width(child, active, level)
