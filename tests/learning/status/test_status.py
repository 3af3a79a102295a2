"""A learned status on data: what is known to be active is let go later than it is taken up."""

from dataclasses import replace

import numpy as np
import small_job

from ichain_drake.graph import Interaction
from ichain_drake.learning import InteractionModel

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
