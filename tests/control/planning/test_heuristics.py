"""Landmarks follow from roles: who gives what mixes must have it first; states that differ little are alike."""

from types import SimpleNamespace

import numpy as np
import pytest
from toy_models import LAMP_START, lamp

from ichain_drake import rules
from ichain_drake.control.planning.heuristics import Alike, Landmarks
from ichain_drake.control.planning.plan import Condition
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import Role, StateSpace, Variable

INF = float("inf")


def vessel(name: str, *more: Variable) -> StateSpace:
    contents = (Variable("amount", role=Role("amount")), Variable("salt", role=Role("intensive", of="amount")))
    return StateSpace(name, (*contents, *more))


def model(*, stirred: bool = False) -> SimpleNamespace:
    """Two jugs that give to a bowl; and, if stirred, a spoon that changes its salt."""
    spaces = {
        "robot": StateSpace("robot", (Variable("x", "m"),)),
        "jug": vessel("jug"),
        "other": vessel("other"),
        "bowl": vessel("bowl"),
        "spoon": StateSpace("spoon", (Variable("level"),)),
    }
    edges = ["robot->jug", "robot->other", "robot->spoon", "jug->bowl", "other->bowl", "spoon->bowl"]
    graph = InteractionGraph(spaces, edges)
    both, none = [SimpleNamespace(variable=i) for i in (0, 1)], list[SimpleNamespace]()
    acts = {"jug->bowl": both, "other->bowl": both, "spoon->bowl": both[1:] if stirred else none}
    learned = {e: SimpleNamespace(effects=acts.get(e.name, none)) for e in graph.interactions}
    noise = {n: np.full(len(s.observable), 0.004) for n, s in spaces.items()}
    return SimpleNamespace(graph=graph, edges=learned, noise=noise)


def states(jug: tuple[float, float], other: tuple[float, float]) -> dict[str, np.ndarray]:
    return {
        "robot": np.zeros(1),
        "spoon": np.zeros(1),
        "jug": np.array(jug),
        "other": np.array(other),
        "bowl": np.zeros(2),
    }


SALTY = [Condition("bowl", "amount", 0.5, INF), Condition("bowl", "salt", 0.9, INF)]


@pytest.mark.parametrize(
    ("jug", "other", "expected"),
    [
        ((0.8, 0.2), (0.0, 0.0), (1,)),  # nobody is salty
        ((0.8, 0.95), (0.0, 0.0), ()),
        ((0.8, 0.2), (0.3, 0.95), ()),
        ((0.01, 0.95), (0.0, 0.0), (1,)),  # salty, but all but empty
    ],
)
def test_one_of_the_givers_must_have_it(
    jug: tuple[float, float], other: tuple[float, float], expected: tuple[int, ...]
) -> None:
    assert Landmarks(model(), SALTY).open(states(jug, other), (0, 1)) == expected  # type: ignore[arg-type]


def test_they_can_be_switched_off() -> None:
    with rules.without(["landmarks"]):
        assert Landmarks(model(), SALTY).open(states((0.8, 0.2), (0.0, 0.0)), (0, 1)) == ()  # type: ignore[arg-type]


def test_what_is_met_needs_no_landmark() -> None:
    assert Landmarks(model(), SALTY).open(states((0.0, 0.0), (0.0, 0.0)), (0,)) == ()  # type: ignore[arg-type]


def test_there_is_none_where_something_else_changes_it() -> None:
    assert Interaction.parse("spoon->bowl") in model().edges
    assert Landmarks(model(stirred=True), SALTY).open(states((0.0, 0.0), (0.0, 0.0)), (0, 1)) == ()  # type: ignore[arg-type]


def test_there_is_none_without_roles() -> None:
    assert Landmarks(lamp(), [Condition("lamp", "light", 0.5, INF)]).open(LAMP_START, (0,)) == ()


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
