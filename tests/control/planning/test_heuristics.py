"""States of a search that differ little are alike."""

from types import SimpleNamespace

import numpy as np

from ichain_drake.control.planning.heuristics import Alike
from ichain_drake.graph import InteractionGraph
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import Role, StateSpace, Variable


def vessel(name: str, *more: Variable) -> StateSpace:
    contents = (Variable("amount", role=Role("amount")), Variable("salt", role=Role("intensive", of="amount")))
    return StateSpace(name, (*contents, *more))


def test_states_are_alike_within_a_small_part_of_what_was_shown() -> None:
    spaces = {"robot": StateSpace("robot", (Variable("x", "m"),)), "jug": vessel("jug"), "bowl": vessel("bowl")}
    graph = InteractionGraph(spaces, ["robot->jug", "jug->bowl"])
    low, high = ({n: np.full(len(s.observable), v) for n, s in spaces.items()} for v in (0.0, 2.0))
    passive = {n: SimpleNamespace(variables=(SimpleNamespace(kind="hold"),) * 2) for n in ("jug", "bowl")}
    learned = SimpleNamespace(graph=graph, low=low, high=high, passive=passive)
    first, small, large = (
        {"robot": np.array([x]), "jug": np.array([1.0 + x, 0.5]), "bowl": np.array([0.0, 1.0])}
        for x in (0.0, 0.2 * LEARNING.near, 2.2 * LEARNING.near)
    )
    all_of, bowls = Alike(learned), Alike(learned, ["bowl"])  # type: ignore[arg-type]
    assert all_of.key(first) == all_of.key(small) != all_of.key(large)
    assert bowls.key(first) == bowls.key(large)
