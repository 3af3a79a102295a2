"""Each interaction of a graph can be learned anew while the others stay as they are known, to the last bit."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
import small_world

from ichain_drake.demonstrations import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction
from ichain_drake.learning import (
    InteractionModel,
    KnownObject,
    KnownParts,
    contradicted,
    f1,
    learn_interactions,
)
from ichain_drake.learning.known import typical_row
from ichain_drake.learning.settings import LEARNING

GRAPH = small_world.GRAPH
EDGES = GRAPH.interactions
FRESH = small_world.pieces(7)


def parts_of(model: InteractionModel) -> KnownParts:
    """All of a model."""
    about = {
        n: KnownObject(
            model.passive.get(n), model.low[n], model.high[n], model.step_limit[n], model.noise[n],
            model.edges[EDGES[0]].examples.inactive[n][0],
        )
        for n in GRAPH.objects
    }  # fmt: skip
    return KnownParts(model.edges, about)


def less(parts: KnownParts, edges=(), objects=()) -> KnownParts:
    """Without some of them."""
    return replace(
        parts,
        edges={e: known for e, known in parts.edges.items() if e not in edges},
        objects={n: known for n, known in parts.objects.items() if n not in objects},
    )


def showing(edge: Interaction) -> list[Demonstration]:
    """Fresh pieces that show an interaction."""
    return [p for p in FRESH if (p.table[edge.name] > 0.5).any()]


def told(model: InteractionModel, edge: Interaction, pieces: list[Demonstration]) -> float:
    """F1 of a status in pieces."""
    states = [small_world.states_of(p) for p in pieces]
    truth = np.concatenate([p.table[edge.name].to_numpy() > 0.5 for p in pieces])
    return f1(truth, np.concatenate([model.decide(edge, s) >= 0.0 for s in states]))


@pytest.mark.parametrize("edge", EDGES, ids=lambda e: e.name)
def test_one_is_learned_from_the_pieces_that_show_it_and_the_others_stay(model: InteractionModel, edge: Interaction):
    pieces = showing(edge)
    found = learn_interactions(pieces, GRAPH, known=less(parts_of(model), [edge]))
    judged = small_world.pieces(11)
    assert told(found, edge, judged) > 0.85
    assert {e.variable for e in found.edges[edge].effects} == {e.variable for e in model.edges[edge].effects}
    rows = {n: np.vstack([small_world.states_of(p)[n] for p in judged]) for n in GRAPH.objects}
    for other in EDGES:
        if other != edge:
            assert found.edges[other].status is model.edges[other].status
            np.testing.assert_array_equal(found.decide(other, rows), model.decide(other, rows))
    ends = [found.edges[other].examples for other in EDGES if other != edge]
    assert all(set(e.active) == set(GRAPH.objects) and len(e.active["hand"]) <= LEARNING.examples for e in ends)


def test_where_all_is_known_no_piece_is_needed(model: InteractionModel):
    found = learn_interactions([], GRAPH, known=parts_of(model))
    start = {n: s[:1] for n, s in small_world.states_of(FRESH[0]).items()}
    path = FRESH[0].states("hand", GRAPH.objects["hand"])[1:, None]
    for ours, theirs in zip(found.rollout(start, path), model.rollout(start, path), strict=True):
        for key in theirs:
            np.testing.assert_array_equal(ours[key], theirs[key])  # type: ignore[index]
    assert parts_of(model).is_whole(GRAPH)
    for part in (less(parts_of(model), [EDGES[0]]), less(parts_of(model), objects=["lamp"]), KnownParts()):
        assert not part.is_whole(GRAPH)
        with pytest.raises(InputError, match="no demonstration piece"):
            learn_interactions([], GRAPH, known=part)


def test_a_known_interaction_need_not_be_shown_an_unknown_one_must_be(model: InteractionModel):
    edge = Interaction("valve", "lamp")
    pieces = [p for p in FRESH if not (p.table["hand->box"] > 0.5).any()]
    assert pieces
    assert learn_interactions(pieces, GRAPH, known=less(parts_of(model), [edge])).edges[edge].effects
    with pytest.raises(InputError, match="hand->box: never active"):
        learn_interactions(pieces, GRAPH, known=less(parts_of(model), [edge, EDGES[0]]))


def test_ranges_are_those_of_both(model: InteractionModel):
    found = learn_interactions(showing(EDGES[0]), GRAPH, known=less(parts_of(model), [EDGES[0]]))
    for n in GRAPH.objects:
        here = np.vstack([small_world.states_of(p)[n] for p in showing(EDGES[0])])
        np.testing.assert_array_equal(found.low[n], np.minimum(here.min(axis=0), model.low[n]))
        np.testing.assert_array_equal(found.high[n], np.maximum(here.max(axis=0), model.high[n]))
        assert (found.step_limit[n] >= model.step_limit[n]).all()
        np.testing.assert_array_equal(found.noise[n], model.noise[n])


def test_places_of_another_scene_are_used_only_where_none_is_shown_here(model: InteractionModel):
    edge, other = EDGES[0], Interaction("valve", "lamp")
    known = less(parts_of(model), [other])
    here = learn_interactions(FRESH, GRAPH, known=known).edges[edge].examples.deactivations
    there = learn_interactions(FRESH, GRAPH, known=replace(known, elsewhere=[edge])).edges[edge].examples.deactivations
    before = model.edges[edge].examples.deactivations
    assert len(here) == len(there) + len(before)
    assert set(there.pieces) <= {p.name for p in FRESH}
    unshown = [p for p in FRESH if not (p.table[edge.name] > 0.5).any()]
    kept = learn_interactions(unshown, GRAPH, known=replace(known, elsewhere=[edge])).edges[edge].examples
    np.testing.assert_array_equal(kept.deactivations.after["box"], before.after["box"])


def _changed(column: str, change) -> list[Demonstration]:
    out = []
    for p in FRESH:
        table: pd.DataFrame = p.table.copy()
        table[column] = change(table)
        out.append(Demonstration(table, {}, p.name))
    return out


def test_fresh_pieces_of_the_same_world_contradict_nothing(model: InteractionModel):
    assert contradicted(FRESH, GRAPH, parts_of(model)) == {}
    assert contradicted([], GRAPH, parts_of(model)) == {}
    part = less(parts_of(model), [Interaction("tap", "box")])  # acts in some rows, and isn't known: they tell nothing
    assert contradicted(FRESH, GRAPH, part) == {}


def test_a_status_that_is_another_now_is_found(model: InteractionModel):
    pieces = _changed("valve->tap", lambda t: (t["valve.level"] > 0).astype(float))
    found = contradicted(pieces, GRAPH, parts_of(model))
    assert list(found) == [Interaction("valve", "tap")]
    assert "its status is told with F1 0." in found[Interaction("valve", "tap")]
    assert contradicted(pieces, GRAPH, parts_of(model).without(found)) == {}


def test_an_effect_that_is_another_now_is_found(model: InteractionModel, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(small_world, "PUSH", 0.15)
    found = contradicted(small_world.pieces(7), GRAPH, parts_of(model))
    assert list(found) == [Interaction("valve", "lamp")]
    assert found[Interaction("valve", "lamp")].startswith("what it does to lamp.glow is off by 0.")


def test_an_object_that_changes_by_itself_in_another_way_is_found(
    model: InteractionModel, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(small_world, "COOLING", 0.3)
    found = contradicted(small_world.pieces(7), GRAPH, parts_of(model))
    assert list(found) == [Interaction("valve", "lamp")]
    assert found[Interaction("valve", "lamp")].startswith("left alone, lamp.glow changes by 0.")


def test_a_typical_row_is_near_the_medians_in_every_variable_as_a_share_of_its_range():
    far, narrow = [0.0, 10.0, 5.0, 6.0, 4.9], [0.0, 0.1, 0.1, 0.05, 0.0]  # medians 5 and 0.05
    still = np.full(5, 3.0)
    np.testing.assert_array_equal(typical_row(np.column_stack([far, narrow, still])), [6.0, 0.05, 3.0])
