"""A graph may have cycles; one that is active as a whole is refused with its place."""

import numpy as np
import pytest

from ichain_drake.errors import ActiveCycleError
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.cycles import refuse_active, rings_of
from ichain_drake.state import StateSpace, Variable

SPACES = {n: StateSpace(n, (Variable("x"),)) for n in ("hand", "a", "b", "c")}
GRAPH = InteractionGraph(SPACES, ["hand->a", "a->b", "b->a", "b->c", "c->a"])
AB, BA, BC, CA = (Interaction.parse(t) for t in ("a->b", "b->a", "b->c", "c->a"))


def test_every_cycle_is_found_once() -> None:
    rings = {frozenset(ring) for ring in rings_of(GRAPH)}
    assert rings == {frozenset({AB, BA}), frozenset({AB, BC, CA})}
    assert len(rings_of(GRAPH)) == 2
    for ring in rings_of(GRAPH):
        assert all(one.child == other.parent for one, other in zip(ring, [*ring[1:], ring[0]], strict=True))


def test_a_cycle_that_is_never_whole_is_none() -> None:
    rings = rings_of(GRAPH)
    refuse_active(rings, {AB: np.array([True, False]), BA: np.array([False, True]), BC: np.ones(2, bool),
                          CA: np.array([False, True])}, 0.0)  # fmt: skip
    refuse_active(rings, {}, None)  # nothing is known of them


def test_an_active_cycle_is_named_with_time_and_row() -> None:
    rings = [r for r in rings_of(GRAPH) if len(r) == 2]
    on = {AB: np.array([False, True, True]), BA: np.array([True, True, True])}
    with pytest.raises(ActiveCycleError, match=r"form a cycle at t = 1\.333 s in row 1: .*a->b.*; deactivate one"):
        refuse_active(rings, on, 4 / 3)
    one = {e: flags[-1:] for e, flags in on.items()}
    with pytest.raises(ActiveCycleError, match=r"form a cycle: "):
        refuse_active(rings, one, None)
