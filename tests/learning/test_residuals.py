"""Residuals of one tick in units of their spread: equal to a loop over rows, of graphs and of chains."""

import numpy as np
import pytest
from linked_library import CHAIN
from small_world import GRAPH, pieces

from ichain_drake.demonstrations import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction
from ichain_drake.learning import InteractionModel, KnownParts
from ichain_drake.learning.residuals import Part, tick_scores
from ichain_drake.learning.spreads import acted_on

FILL = Interaction("tap", "box")


@pytest.fixture(scope="module")
def others() -> list[Demonstration]:
    return pieces(1)


def test_scores_are_those_of_one_row_after_another(model: InteractionModel, others: list[Demonstration]) -> None:
    found = tick_scores(model, others[:4])
    space = GRAPH.objects["box"].observable
    sizes: dict[Part, list[float]] = {}
    for piece in others[:4]:
        states = {n: piece.states(n, s) for n, s in GRAPH.objects.items()}
        flags = {e: piece.table[e.name].to_numpy() > 0.5 for e in GRAPH.interactions}
        for k in range(len(piece) - 1):
            on = {e: f[k + 1] for e, f in flags.items()}
            ahead, _ = model.step({n: s[k] for n, s in states.items()}, states["hand"][k + 1], on)
            into = [e for e in GRAPH.incoming("box") if on[e]]
            spread = model.spread("box", into)
            off = np.abs(space.difference(states["box"][k + 1], ahead["box"])) / spread
            i = space.index("water")
            effects = {e: f for e in into for f in model.edges[e].effects if f.variable == i}
            most = max(effects, key=lambda e: effects[e].regression.std, default=None)
            if most is not None and effects[most].regression.std <= model.passive["box"].variables[i].std:
                most = None
            sizes.setdefault(Part("box", i, most), []).append(off[i])
    for part, values in sizes.items():
        np.testing.assert_allclose(np.sort(found[part].sizes), np.sort(values), rtol=1e-9)
    assert sum(len(found[p].sizes) for p in found if p[:2] == ("box", i)) == sum(len(p) - 1 for p in others[:4])


def test_rows_in_which_an_effect_acts_are_told_and_what_jumps_is_left_out(
    model: InteractionModel, others: list[Demonstration]
) -> None:
    found = tick_scores(model, others)
    assert not any(part.child == "valve" for part in found), "its level is a whole number"
    filled = sum(int(p.table[FILL.name].to_numpy()[1:].sum()) for p in others)
    water, change = (GRAPH.objects["box"].observable.index(n) for n in ("water", "change"))
    for i in (water, change):
        assert sum(s.acting.sum() for p, s in found.items() if p[:2] == ("box", i)) == filled
    changed = acted_on(model.passive["box"], GRAPH.incoming("box"), model.edges)
    assert {water, change} <= changed[FILL]
    assert change not in changed[Interaction("hand", "box")]


def test_the_change_of_an_amount_is_no_less_sure_than_its_own_reading(
    model: InteractionModel, others: list[Demonstration]
) -> None:
    """Neither reading of the amount is in the residual of its change; with both, 99 % would lie within 90 %."""
    change = GRAPH.objects["box"].observable.index("change")
    quiet = tick_scores(model, others)[Part("box", change, None)].sizes
    assert np.mean(quiet <= 1.645) == pytest.approx(0.9, abs=0.04)
    assert np.mean(quiet <= 0.674) == pytest.approx(0.5, abs=0.08)


def test_without_pieces_there_is_nothing_to_compare_with(model: InteractionModel) -> None:
    with pytest.raises(InputError, match="no pieces to compare predictions with; give some that"):
        tick_scores(model, [])
    with pytest.raises(InputError, match="no pieces to compare predictions with"):
        tick_scores(InteractionModel.of_chain(CHAIN, [], KnownParts()), [])
