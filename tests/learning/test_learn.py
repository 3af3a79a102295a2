"""The second graph is learned from unordered pieces: its dynamics, its statuses and what the data don't show."""

import json

import numpy as np
import pytest
import small_world
from small_world import COOLING, FLOW, GRAPH, states_of

from ichain_drake.demonstrations import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning import InteractionModel, InteractionSpec, event_f1, f1, learn_interactions
from ichain_drake.learning.chain.link import EstimatorSpec
from ichain_drake.learning.data import GraphData, Piece, collect
from ichain_drake.learning.learn import _active_step
from ichain_drake.learning.noise import measurement_std
from ichain_drake.state import StateSpace, Variable

HELD_OUT = small_world.pieces(5)
CARRY, PRESS, OPEN, FILL, LIGHT = (Interaction.parse(e.name) for e in GRAPH.interactions)


@pytest.mark.parametrize("edge", GRAPH.interactions, ids=lambda e: e.name)
def test_status_and_switching_on_other_pieces(model: InteractionModel, edge: Interaction) -> None:
    truths = [p.table[edge.name].to_numpy() > 0.5 for p in HELD_OUT]
    decided = [model.decide(edge, states_of(p)) >= 0 for p in HELD_OUT]
    assert sum(t.sum() for t in truths) > 50
    assert f1(np.concatenate(truths), np.concatenate(decided)) >= 0.97
    assert event_f1(truths, decided) >= 0.9


def test_which_variables_an_edge_affects(model: InteractionModel) -> None:
    affected = {
        e.name: {GRAPH.objects[e.child].names[f.variable] for f in model.edges[e].effects} for e in GRAPH.interactions
    }
    assert affected["hand->box"] == {"x", "y", "z"}
    assert affected["hand->valve"] == {"level"}
    assert affected["valve->tap"] == {"stock"}
    assert affected["tap->box"] == {"water", "heat"}
    assert affected["valve->lamp"] == {"glow"}


def test_passive_dynamics(model: InteractionModel) -> None:
    assert {v.kind for v in model.passive["box"].variables[:5]} == {"hold"}
    assert model.passive["box"].variables[5].kind == "change"
    assert model.passive["valve"].variables[0].kind == "constant"
    lamp = model.passive["lamp"]
    assert lamp.variables[0].kind == "learned"
    np.testing.assert_allclose(lamp(np.array([[1.0]])), 1.0 - COOLING, atol=0.01)


def test_the_cameras_turn_is_learned(model: InteractionModel) -> None:
    alignment = model.edges[CARRY].alignment
    assert alignment is not None
    c, s = np.cos(0.3), np.sin(0.3)
    np.testing.assert_allclose(alignment.turn, [[c, -s, 0], [s, c, 0], [0, 0, 1]], atol=0.01)


def test_a_whole_piece_is_predicted_from_its_first_row(model: InteractionModel) -> None:
    """Open loop, with every interaction found by the classifiers: noise is 0.003, and nothing drifts away."""
    for piece in HELD_OUT:
        states = states_of(piece)
        trace, status = model.rollout({n: s[0] for n, s in states.items()}, states["hand"][1:])
        assert trace["box"].shape == states["box"].shape
        np.testing.assert_allclose(trace["box"][:, :3], states["box"][:, :3], atol=0.02)
        np.testing.assert_allclose(trace["box"][:, 3:5], states["box"][:, 3:5], atol=0.05)
        np.testing.assert_allclose(trace["tap"], states["tap"], atol=0.04)
        np.testing.assert_allclose(trace["lamp"], states["lamp"], atol=0.1)
        assert f1(piece.table["hand->box"].to_numpy()[1:] > 0.5, status[CARRY]) > 0.95


def test_mixing_goes_by_volume_and_the_amount_that_left_arrives(model: InteractionModel) -> None:
    tap, later = np.array([0.7, 0.9, 0.0]), np.array([0.7 - FLOW, 0.9, -FLOW])
    box = np.array([0.8, 0.0, 0.4, 0.3, 0.2, 0.0])
    effect = model.effect(FILL, {"tap": tap, "box": box}, later)
    np.testing.assert_allclose(effect[3], FLOW, rtol=0.1)
    np.testing.assert_allclose(effect[4], FLOW / (0.3 + FLOW) * 0.7, rtol=0.15)


def test_noise_is_estimated(demonstrations: list[Demonstration]) -> None:
    data = collect(demonstrations, GRAPH)
    np.testing.assert_allclose(measurement_std(data, "box")[3:5], 3e-3, rtol=0.25)


def test_the_report_is_json_and_names_what_was_chosen(model: InteractionModel) -> None:
    report = json.loads(json.dumps(model.report()))
    assert report["pieces"] == [f"piece_{k}" for k in range(9)]
    status = report["interactions"]["valve->tap"]["status"]
    assert status["columns"] == ["valve.level"]
    assert status["samples"] == sum(len(p) for p in small_world.pieces(0))
    fill = report["interactions"]["tap->box"]["effects"]["water"]
    assert fill["columns"] == ["received from parent stock"]
    assert fill["score"] > 0.9
    assert report["passive"]["lamp"]["glow"]["kind"] == "learned"


def test_warnings_name_the_edge_and_the_piece_to_add(demonstrations: list[Demonstration]) -> None:
    few = learn_interactions([demonstrations[0], demonstrations[1]], GRAPH)
    warnings = few.report()["warnings"]
    assert any(w.startswith("hand->box: activated only 1 times") and "add a piece in which hand" in w for w in warnings)
    assert any("shows in 1 piece(s); add one from another start" in w for w in warnings)


def test_examples_of_switching(model: InteractionModel, demonstrations: list[Demonstration]) -> None:
    events = model.edges[CARRY].examples.activations
    assert len(events) == sum(int((np.diff(p.table["hand->box"]) > 0).sum()) for p in demonstrations)
    np.testing.assert_array_equal(events.before["hand"][:, 3], 0.0)
    np.testing.assert_array_equal(events.after["hand"][:, 3], 1.0)


def test_estimators_by_name(demonstrations: list[Demonstration]) -> None:
    spec = InteractionSpec(
        effect_estimators=(EstimatorSpec.parse("Ridge(alpha=0.001)"),),
        status_estimators=(EstimatorSpec.parse("DecisionTreeClassifier(max_depth=8, random_state=0)"),),
    )
    learned = learn_interactions(demonstrations, GRAPH, spec)
    assert learned.edges[OPEN].status.estimator.startswith("DecisionTreeClassifier")
    assert learned.edges[PRESS].effects[0].regression.estimator.startswith("Ridge")


@pytest.mark.parametrize(
    ("text", "message"),
    [("SVC(C=-1.0)", "C"), ("GaussianNB", "GaussianNB can't be frozen")],
)
def test_a_bad_classifier_is_refused_with_the_edge(
    demonstrations: list[Demonstration], text: str, message: str
) -> None:
    spec = InteractionSpec(effect_estimators=(), status_estimators=(EstimatorSpec.parse(text),))
    with pytest.raises(InputError, match=f"->.*, status: .*{message}"):
        learn_interactions(demonstrations[:3], GRAPH, spec)


def test_an_unknown_parameter_of_the_box_is_refused(demonstrations: list[Demonstration]) -> None:
    spec = InteractionSpec(effect_estimators=(), status_estimators=(EstimatorSpec.parse("box(width=1)"),))
    with pytest.raises(InputError, match="box has no parameter 'width'; it has reach"):
        learn_interactions(demonstrations[:3], GRAPH, spec)


def test_how_far_a_parent_goes_in_a_tick_is_told_by_ticks_in_which_it_acts_all_along() -> None:
    """It takes hold with a jump, goes on by .1 and .3, and lets go with another jump; its noise is no motion."""
    spaces = {"hand": StateSpace("hand", (Variable("x"), Variable("y"))), "cup": StateSpace("cup", (Variable("x"),))}
    graph = InteractionGraph(spaces, ["hand->cup"])
    edge = graph.interactions[0]
    x = np.array([0.0, 5.0, 5.1, 4.8, 9.0, 9.0])
    states = {"hand": np.c_[x, 0.01 * np.array([0, 1, 0, 1, 0, 1])], "cup": x[:, None]}
    flags = {edge: np.array([0, 1, 1, 1, 0, 0], dtype=bool)}

    def step(on: dict[Interaction, np.ndarray]) -> np.ndarray:
        data = GraphData(graph, spaces, (Piece("p", states, on),), (edge,), {"hand": (0, 1), "cup": (0,)})
        return _active_step(data, edge, np.array([0.01, 0.01]))

    np.testing.assert_allclose(step(flags), [0.3, 0.0])
    np.testing.assert_array_equal(step({edge: np.arange(6) == 1}), [0.0, 0.0])
