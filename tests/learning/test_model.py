"""The learned model in batches, with forced status, and its inverse."""

from dataclasses import replace
from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from small_world import FLOW, GRAPH, states_of

from ichain_drake.demonstrations import Demonstration
from ichain_drake.errors import ActiveCycleError, InputError
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning import InteractionModel
from ichain_drake.learning.status.customary import Customary
from ichain_drake.learning.status.inputs import ValueInput
from ichain_drake.learning.tick import advance
from ichain_drake.state import FloatArray

CARRY, PRESS, OPEN, FILL, LIGHT = GRAPH.interactions
BOX, VALVE = GRAPH.objects["box"], GRAPH.objects["valve"]


@pytest.fixture
def states(demonstrations: list[Demonstration]) -> dict[str, FloatArray]:
    """Rows of a piece that carries and presses, shape (n, ...)."""
    return states_of(demonstrations[5])


def test_a_batch_is_its_rows(model: InteractionModel, states: dict[str, FloatArray]) -> None:
    rows = {n: s[:24].reshape(4, 6, -1) for n, s in states.items()}
    root = states["hand"][1:25].reshape(4, 6, -1)
    after, active = model.step(rows, root)
    assert after["box"].shape == (4, 6, 6)
    assert active[CARRY].shape == (4, 6)
    assert model.decide(FILL, rows).shape == (4, 6)
    for i in (0, 3):
        for j in (0, 5):
            one, on = model.step({n: s[i, j] for n, s in rows.items()}, root[i, j])
            for n in one:
                np.testing.assert_allclose(one[n], after[n][i, j], atol=1e-12)
            assert all(on[e] == active[e][i, j] for e in on)


def test_the_root_alone_can_be_a_batch(model: InteractionModel, states: dict[str, FloatArray]) -> None:
    one = {n: s[10] for n, s in states.items()}
    after, _ = model.step(one, states["hand"][10:15])
    assert after["tap"].shape == (5, 3)


def test_a_forced_status_is_kept(model: InteractionModel, states: dict[str, FloatArray]) -> None:
    one = {n: s[0] for n, s in states.items()}
    off = dict.fromkeys(GRAPH.interactions, False)
    after, active = model.step(one, one["hand"], active={**off, OPEN: True})
    assert {e for e, on in active.items() if on} == {OPEN}
    np.testing.assert_allclose(after["tap"][0] - one["tap"][0], -FLOW, rtol=0.1)
    assert after["tap"][2] == after["tap"][0] - one["tap"][0]  # the change is computed from the amount
    still, _ = model.step(one, one["hand"], active=off)
    np.testing.assert_array_equal(still["tap"][:2], one["tap"][:2])


def test_a_held_box_stays_held_however_far_the_hand_goes(model: InteractionModel, demonstrations: list) -> None:
    """Within a tick the hand goes further than it may be from the box to grasp it."""
    piece = demonstrations[2]
    row = int(np.flatnonzero(piece.table["hand->box"].to_numpy() > 0.5)[3])
    one = {n: s[row] for n, s in states_of(piece).items()}
    there = one["hand"] + [0.1, 0.05, 0.1, 0.0]
    after, active = model.step(one, there)
    assert active[CARRY]
    alignment = model.edges[CARRY].alignment
    assert alignment is not None
    np.testing.assert_allclose(after["box"][:3] - one["box"][:3], alignment.turn @ [0.1, 0.05, 0.1], atol=0.01)
    _, released = model.step(one, [*there[:3], 0.0])
    assert not released[CARRY]


def test_predictions_stay_within_declared_bounds(model: InteractionModel, states: dict[str, FloatArray]) -> None:
    one = {n: s[0] for n, s in states.items()}
    one["tap"] = np.array([0.01, 0.8, 0.0])
    trace, _ = model.rollout(one, np.repeat(one["hand"][None], 5, axis=0), active={OPEN: True, FILL: True})
    assert trace["tap"][:, 0].min() == 0.0
    np.testing.assert_allclose(trace["box"][-1, 3] - one["box"][3], 0.01, atol=0.004)  # no more than there was


def test_active_and_decide_agree(model: InteractionModel, states: dict[str, FloatArray]) -> None:
    active = model.active(states)
    for e in GRAPH.interactions:
        np.testing.assert_array_equal(active[e], model.decide(e, states) >= 0)
    again = model.active(states, previous=active)
    for e in GRAPH.interactions:
        assert (again[e] | ~active[e]).all()


def test_the_spread_covers_the_residual(model: InteractionModel) -> None:
    spread = model.spread("box", [FILL])
    assert 2e-3 < spread[3] < 0.02
    assert np.isfinite(spread).all()


def test_a_cycle_of_active_interactions_is_refused_with_its_edges_and_the_time(
    model: InteractionModel, states: dict[str, FloatArray]
) -> None:
    back = Interaction("lamp", "valve")
    graph = InteractionGraph(GRAPH.objects, [*GRAPH.interactions, back])
    ring = replace(
        model, graph=graph, edges=model.edges | {back: replace(model.edges[LIGHT], effects=())},
        order=(*model.order, back),
    )  # fmt: skip
    three = {n: s[:3] for n, s in states.items()}
    once = {LIGHT: True, back: np.array([False, False, True])}
    edges = r"(valve->lamp, lamp->valve|lamp->valve, valve->lamp); deactivate one of them"
    with pytest.raises(ActiveCycleError, match=rf"form a cycle at t = 2\.500 s in row 2: {edges}"):
        ring.step(three, three["hand"], once, time=2.5)
    one = {n: s[0] for n, s in states.items()}
    with pytest.raises(ActiveCycleError, match=rf"form a cycle at t = 0\.333 s: {edges}"):
        ring.rollout(one, one["hand"][None], {LIGHT: True, back: True})
    with pytest.raises(ActiveCycleError, match=rf"form a cycle: {edges}"):
        ring.step(one, one["hand"], {LIGHT: True, back: True})
    after, active = ring.step(three, three["hand"], once, strict=False)
    assert active[back].tolist() == [False, False, True]
    assert np.isfinite(after["lamp"]).all()
    assert not ring.step(three, three["hand"], {LIGHT: True, back: False})[1][back].any()


class Leak:
    """An effect: a tenth of what is in the box comes back."""

    variable = 0

    def __call__(self, parent: FloatArray, parent_next: FloatArray, child: FloatArray) -> FloatArray:
        return np.asarray(0.1 * parent_next[..., 3])


def test_in_a_cycle_only_what_news_reached_is_calculated_again_and_all_is_as_if_everything_was(
    model: InteractionModel, states: dict[str, FloatArray], monkeypatch: pytest.MonkeyPatch
) -> None:
    back = Interaction("box", "tap")
    ring = replace(
        model,
        graph=InteractionGraph(GRAPH.objects, [*GRAPH.interactions, back]),
        edges=model.edges | {back: replace(model.edges[FILL], effects=(Leak(),))},
        order=(*model.order, back),
    )
    calculated: list[str] = []

    def counted(*arguments: Any) -> FloatArray:
        calculated.append(arguments[1][0].child)
        return advance(*arguments)

    monkeypatch.setattr("ichain_drake.learning.model.advance", counted)
    rows, root = {name: s[:-1] for name, s in states.items()}, states["hand"][1:]
    n = len(root)
    given = {e: np.full(n, e in (FILL, back)) for e in ring.graph.interactions}
    found, _ = ring.step(rows, root, given, strict=False)
    after = {"hand": root, "valve": found["valve"]}
    for _ in range(2):  # plainly: everything, as often as there are members
        for child in ring._sweep(("box", "tap")):
            incoming = ring._incoming[child]
            after[child] = advance(ring.edges, incoming, ring.passive[child], rows, after, given, {}, {})
    assert np.array_equal(found["box"], after["box"])
    assert np.array_equal(found["tap"], after["tap"])
    assert not np.array_equal(found["box"], rows["box"])
    assert sorted(calculated) == sorted(["valve", "lamp", *["box", "tap"] * 2])
    calculated.clear()
    ring.step(found, root, dict.fromkeys(ring.graph.interactions, False), strict=False)
    assert calculated.count("tap") < 2 or calculated.count("box") < 2, "where nothing goes round, once is enough"


def test_bad_arguments_are_refused(model: InteractionModel, states: dict[str, FloatArray]) -> None:
    one = {n: s[0] for n, s in states.items()}
    with pytest.raises(InputError, match="the state of lamp is missing"):
        model.step({n: s for n, s in one.items() if n != "lamp"}, one["hand"])
    with pytest.raises(InputError, match="state of hand: shape .2,. given, 4 values needed"):
        model.step(one, [0.0, 1.0])
    with pytest.raises(InputError, match="a->b is no interaction of the graph"):
        model.step(one, one["hand"], active={Interaction("a", "b"): True})
    with pytest.raises(InputError, match="no learned interaction a->b; learned are hand->box"):
        model.decide(Interaction("a", "b"), one)


def test_a_spread_is_the_largest_of_what_acts_and_a_changes_that_of_its_amount_and_one_reading() -> None:
    fills, cools = (
        SimpleNamespace(effects=[SimpleNamespace(variable=i, regression=SimpleNamespace(std=std))])
        for i, std in ((0, 0.5), (2, 0.01))
    )
    kinds = [("hold", 0.3, 0), ("change", 9.0, 0), ("hold", 0.1, 0)]
    passive = SimpleNamespace(variables=[SimpleNamespace(kind=k, std=s, amount=a) for k, s, a in kinds])
    edges = {Interaction("tap", "cup"): fills, Interaction("fan", "cup"): cools, Interaction("fan", "lid"): fills}
    cup = SimpleNamespace(passive={"cup": passive}, noise={"cup": np.array([0.1, 0.4, 0.2])}, _edge=edges.__getitem__)
    spread = partial(InteractionModel.spread, cup, "cup")
    # Both readings of the amount, with a noise of 0.1, are in its residual, and neither in that of its change.
    np.testing.assert_allclose(spread([]), [0.3, np.sqrt(0.3**2 - 2 * 0.1**2 + 0.4**2), 0.1])
    np.testing.assert_allclose(spread(list(edges)), [0.5, np.sqrt(0.5**2 - 2 * 0.1**2 + 0.4**2), 0.1])
    np.testing.assert_allclose(spread([Interaction("fan", "lid")]), spread([]))


def test_who_may_be_to_blame_is_who_is_looked_at_where_anything_was_customary(model: InteractionModel) -> None:
    parents = GRAPH.parents(FILL.child)
    assert len(parents) > 1
    assert model.suspects(FILL) == (FILL.child, *parents)
    learned, one = model.edges[FILL], ValueInput(parents[-1], 0, f"{parents[-1]}.x")
    custom = Customary((one,), np.zeros(1), np.ones(1))
    looked = replace(learned, status=replace(learned.status, inputs=()), customary=custom)
    assert replace(model, edges={**model.edges, FILL: looked}).suspects(FILL) == (FILL.child, parents[-1])
    with pytest.raises(InputError, match="no learned interaction"):
        model.suspects(Interaction(FILL.child, FILL.child))
