"""Names, order and the camera's turn don't matter."""

from dataclasses import replace

import numpy as np
import pytest
import small_world
from small_world import GRAPH, states_of

from ichain_drake.demonstrations import Demonstration, column
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning import InteractionModel, f1, learn_interactions
from ichain_drake.state import Role, StateSpace

WORDS = iter(f"w{k}q" for k in np.random.default_rng(3).permutation(1000))
OBJECTS = {n: next(WORDS) for n in GRAPH.objects}
VARIABLES = {(n, v): next(WORDS) for n, s in GRAPH.objects.items() for v in s.names}


def renamed_role(obj: str, role: Role | None) -> Role | None:
    return role if role is None or not role.of else replace(role, of=VARIABLES[obj, role.of])


def renamed_graph(rng: np.random.Generator) -> InteractionGraph:
    """The graph in random words and in another order of objects, variables and interactions."""
    objects = {}
    for name in rng.permutation(list(GRAPH.objects)):
        space = GRAPH.objects[str(name)]
        parts = [
            replace(v, name=VARIABLES[str(name), v.name], role=renamed_role(str(name), v.role)) for v in space.variables
        ]
        objects[OBJECTS[str(name)]] = StateSpace(next(WORDS), tuple(parts[i] for i in rng.permutation(len(parts))))
    edges = [Interaction(OBJECTS[e.parent], OBJECTS[e.child]) for e in GRAPH.interactions]
    return InteractionGraph(objects, [edges[i] for i in rng.permutation(len(edges))])


def renamed_piece(piece: Demonstration, name: str) -> Demonstration:
    names = {column(o, v): column(OBJECTS[o], w) for (o, v), w in VARIABLES.items()}
    names |= {e.name: Interaction(OBJECTS[e.parent], OBJECTS[e.child]).name for e in GRAPH.interactions}
    return Demonstration(piece.table.rename(columns=names), {}, name)


def test_random_words_and_another_order_give_the_same_predictions(
    model: InteractionModel, demonstrations: list[Demonstration]
) -> None:
    rng = np.random.default_rng(8)
    graph = renamed_graph(rng)
    pieces = [renamed_piece(demonstrations[i], next(WORDS)) for i in rng.permutation(len(demonstrations))]
    other = learn_interactions(pieces, graph)
    for number, piece in enumerate(small_world.pieces(6)[:6]):
        states, theirs = states_of(piece), renamed_piece(piece, str(number))
        same = {OBJECTS[n]: theirs.states(OBJECTS[n], graph.objects[OBJECTS[n]]) for n in GRAPH.objects}
        trace, status = model.rollout({n: s[0] for n, s in states.items()}, states["hand"][1:])
        root = same[graph.root]
        trace_2, status_2 = other.rollout({n: s[0] for n, s in same.items()}, root[1:])
        for n, space in GRAPH.objects.items():
            order = [graph.objects[OBJECTS[n]].index(VARIABLES[n, v]) for v in space.names]
            np.testing.assert_allclose(trace_2[OBJECTS[n]][:, order], trace[n], atol=1e-9)
        for e in GRAPH.interactions:
            edge = Interaction(OBJECTS[e.parent], OBJECTS[e.child])
            np.testing.assert_array_equal(status_2[edge], status[e])
            np.testing.assert_allclose(other.decide(edge, same), model.decide(e, states), atol=1e-9)


@pytest.mark.parametrize("degrees", [40.0])
def test_another_turn_of_the_camera_gives_the_same_scores(model: InteractionModel, degrees: float) -> None:
    yaw = 0.3 + np.radians(degrees)
    turned = learn_interactions(small_world.pieces(0, yaw), GRAPH)
    for e in GRAPH.interactions:
        scores = []
        for learned, angle in ((model, 0.3), (turned, yaw)):
            held_out = small_world.pieces(5, angle)
            truth = np.concatenate([p.table[e.name].to_numpy() > 0.5 for p in held_out])
            scores.append(f1(truth, np.concatenate([learned.decide(e, states_of(p)) >= 0 for p in held_out])))
        assert abs(scores[0] - scores[1]) <= 0.01, e.name
