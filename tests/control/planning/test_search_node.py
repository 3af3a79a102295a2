"""Which of two ways to the same state is better."""

from types import SimpleNamespace

import numpy as np
import pytest

from ichain_drake.control.planning.search_node import SearchNode, cheaper, mark_of
from ichain_drake.control.settings import PLANNING


def node(ticks: int, *chains: int, predicted: float = 0.0) -> SearchNode:
    """Steps with chains of so many interactions, of which each takes as long."""
    steps = [SimpleNamespace(ticks=3, chain=(None,) * n, predicted={"a": np.array([predicted, 1.0])}) for n in chains]
    return SearchNode({}, tuple(steps), ticks, ())  # type: ignore[arg-type]


def test_of_as_many_interactions_the_shorter_way_is_better_and_a_tie_goes_by_the_mark() -> None:
    assert cheaper(node(10, 2), node(11, 2))
    assert not cheaper(node(11, 2), node(10, 2))
    assert cheaper(node(10, 2, predicted=0.1), node(10, 2, predicted=0.2))
    assert not cheaper(node(10, 2), node(10, 2))


@pytest.mark.parametrize("ticks", [10, 25])
def test_of_nearly_equal_ways_that_which_watches_more_is_better(ticks: int) -> None:
    most = int(PLANNING.cheaper * ticks)
    for longer, better in ((ticks, True), (most, True), (most + 1, False)):
        assert cheaper(node(longer, 1, 3), node(ticks, 1, 2)) is better
        assert cheaper(node(ticks, 1, 2), node(longer, 1, 3)) is not better  # one of the two is
    assert cheaper(node(ticks, 2), node(ticks + 1, 1, 3))  # of another number of steps: the shorter one


def test_a_mark_has_each_steps_time_length_and_values_in_no_order_of_names() -> None:
    one = SimpleNamespace(
        ticks=4, chain=(None, None), predicted={"b": np.array([2.0]), "a": np.array([3.0, 1.00000004])}
    )
    assert mark_of(SearchNode({}, (one,), 4, ())) == (4.0, 2.0, 1.0, 2.0, 3.0)  # type: ignore[arg-type]
