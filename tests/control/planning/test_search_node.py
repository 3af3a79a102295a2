"""Of two ways to the same state: which is kept."""

from types import SimpleNamespace

import numpy as np
import pytest

from ichain_drake.control.planning.search_node import SearchNode, cheaper, mark_of
from ichain_drake.control.settings import PLANNING


def node(ticks: float, *chains: int, end: float = 0.0) -> SearchNode:
    """After one step per chain length, with a mark by where it ends."""
    steps = [SimpleNamespace(chain=(None,) * n, ticks=7, predicted={"a": np.array([end])}) for n in chains]
    return SearchNode({}, tuple(steps), ticks, ())  # type: ignore[arg-type]


def test_the_shorter_way_is_cheaper_and_of_equal_ones_that_of_the_smaller_mark() -> None:
    assert cheaper(node(10, 1, 1), node(11, 1))
    assert not cheaper(node(11, 1), node(10, 1, 1))
    assert cheaper(node(10, 1, end=0.1), node(10, 1, end=0.2))
    assert not cheaper(node(10, 1, end=0.2), node(10, 1, end=0.1))
    assert not cheaper(node(10, 1), node(10, 1)), "one is kept for good"


@pytest.mark.parametrize("share", [0.9, 1.0])
def test_a_longer_chain_may_take_a_little_longer(share: float) -> None:
    most = PLANNING.cheaper * 100.0
    assert cheaper(node(share * most, 1, 3), node(100.0, 1, 2))
    assert not cheaper(node(100.0, 1, 2), node(share * most, 1, 3)), "nor is the other one at the limit"


def test_a_longer_chain_that_takes_much_longer_is_not_cheaper() -> None:
    much = PLANNING.cheaper * 101.0
    assert not cheaper(node(much, 1, 3), node(100.0, 1, 2))
    assert cheaper(node(100.0, 1, 2), node(much, 1, 3))


def test_marks_do_not_depend_on_the_order_of_objects() -> None:
    one, other = ({"a": np.array([2.0]), "b": np.array([1.0])}, {"x": np.array([1.0]), "y": np.array([2.0 + 1e-9])})
    marks = [
        mark_of(SearchNode({}, (SimpleNamespace(chain=(None,), ticks=3, predicted=p),), 0, ()))  # type: ignore[arg-type]
        for p in (one, other)
    ]
    assert marks[0] == marks[1] == (3.0, 1.0, 1.0, 2.0)
