"""Copies of one machine are calculated as one batch, and each as if it were alone."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
import small_world

from ichain_drake.benchmarks.many_objects import copies
from ichain_drake.learning import InteractionModel, alike

COUNT = 5


@pytest.fixture
def batched(model: InteractionModel, monkeypatch: pytest.MonkeyPatch) -> Callable[[int], InteractionModel]:
    def made(from_on: int) -> InteractionModel:
        monkeypatch.setattr(alike, "_COPIES", from_on)
        whole = copies(model, COUNT)
        assert len(whole._groups)  # made under this setting
        return whole

    return made


def states_of(model: InteractionModel, demonstrations: list, rows: int) -> dict[str, np.ndarray]:
    """Each copy in the states of another row of the demonstrations."""
    out, root = {}, model.graph.root
    for name in model.graph.objects:
        old, _, copy = name.partition(".")
        states = np.vstack([p.states(old, small_world.GRAPH.objects[old]) for p in demonstrations])
        first = 17 * int(copy or 0)
        out[name] = states[first : first + 5 * rows : 5] if name != root else states[: 5 * rows : 5]
    return out


@pytest.mark.parametrize("rows", [1, 40])
def test_batched_copies_do_what_each_does_alone(
    batched: Callable[[int], InteractionModel], demonstrations: list, rows: int
) -> None:
    one_by_one, together = batched(COUNT + 1), batched(COUNT)
    assert all(len(group) == 1 for group in one_by_one._groups)
    assert {len(group) for group in together._groups} == {COUNT}
    now = states_of(together, demonstrations, rows)
    root = now[together.graph.root] + 0.01
    edge = together.graph.interactions[-1]
    shown = set()
    for given in ({}, {"previous": together.active(now)}, {"active": {edge: np.ones(rows, dtype=bool)}}):
        one, other = (m.step(now, root, strict=False, **given) for m in (one_by_one, together))
        for name, values in one[0].items():
            np.testing.assert_allclose(other[0][name], values, rtol=1e-12, atol=1e-12)
        for e, flags in one[1].items():
            assert np.array_equal(other[1][e], flags)
            shown |= set(flags.tolist())
    assert shown == {False, True} or rows == 1


def test_another_model_of_one_copy_is_no_copy(
    batched: Callable[[int], InteractionModel], model: InteractionModel
) -> None:
    whole = batched(2)
    name = next(n for n in whole.graph.objects if n.endswith(".3"))
    odd = replace(whole, passive={**whole.passive, name: replace(whole.passive[name])})
    assert [name in group[0].members for group in odd._groups if len(group) == 1].count(True) == 1
    edge = next(e for e in whole.graph.interactions if e.child.endswith(".2"))
    learned = whole.edges[edge]
    moved = replace(learned, status=replace(learned.status, offset=learned.status.offset + 0.1))
    odd = replace(whole, edges={**whole.edges, edge: moved})
    assert any(len(group) == 1 and edge.child in group[0].members for group in odd._groups)
