"""What is written as ONNX gives, in onnxruntime, what it gives here."""

import json
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from linked_library import CHAIN, GRAPH, HASH, LINK
from portable_models import ESTIMATORS, RNG, X, Y, frozen_bytes
from sklearn.ensemble import GradientBoostingRegressor
from sklearn.linear_model import Ridge
from sklearn.svm import SVR
from small_models import chain

from ichain_drake.cli.main import main
from ichain_drake.errors import InputError
from ichain_drake.graph import Origin
from ichain_drake.learning import InteractionModel
from ichain_drake.learning.chain.models import ForwardModel, InverseModel
from ichain_drake.learning.effects.columns import Column
from ichain_drake.learning.features import StateFeatures
from ichain_drake.learning.frozen import FrozenModel, freeze
from ichain_drake.learning.frozen.scaling import InputScaling
from ichain_drake.learning.frozen.stacked import Stacked
from ichain_drake.learning.library import load_links, save_chain
from ichain_drake.learning.portable import (
    effect_bytes,
    export_item,
    forward_bytes,
    inverse_bytes,
    passive_bytes,
    status_bytes,
)
from ichain_drake.learning.portable.frozen import add_frozen
from ichain_drake.learning.portable.graph import OnnxGraph
from ichain_drake.learning.portable.interaction import _column, _status_input
from ichain_drake.learning.status.box import Box
from ichain_drake.learning.status.inputs import DifferenceInput
from ichain_drake.runs.library import save
from ichain_drake.state import Role, StateSpace, Variable

pytest.importorskip("onnx", reason="onnx is missing: pip install 'ichain_drake[onnx]'")
runtime = pytest.importorskip("onnxruntime", reason="onnxruntime is missing: pip install 'ichain_drake[dev]'")


def run(content: bytes, **tables: np.ndarray) -> dict[str, np.ndarray]:
    session = runtime.InferenceSession(content, providers=["CPUExecutionProvider"])
    assert {i.name for i in session.get_inputs()} <= set(tables)
    names = [o.name for o in session.get_outputs()]
    return dict(zip(names, session.run(None, {i.name: tables[i.name] for i in session.get_inputs()}), strict=True))


def about(content: bytes) -> dict[str, object]:
    session = runtime.InferenceSession(content, providers=["CPUExecutionProvider"])
    return json.loads(session.get_modelmeta().custom_metadata_map["ichain_drake"])


@pytest.mark.parametrize("name", ESTIMATORS)
@pytest.mark.filterwarnings("ignore::sklearn.exceptions.ConvergenceWarning")
def test_every_kind_of_model_gives_the_same(name: str) -> None:
    model = freeze(ESTIMATORS[name].fit(X, Y))
    rows = np.concatenate([X[:5], RNG.normal(size=(30, 3)) * 2])
    np.testing.assert_allclose(run(frozen_bytes(model), x=rows)["y"], model.batch(rows), rtol=1e-9, atol=1e-9)
    one = run(frozen_bytes(model), x=rows[:1])["y"]
    np.testing.assert_allclose(one[0], model.value(rows[0]), rtol=1e-9, atol=1e-9)


def test_models_side_by_side_and_bounds_give_the_same() -> None:
    parts = [freeze(GradientBoostingRegressor(n_estimators=5).fit(X, Y[:, 0])), freeze(SVR().fit(X, Y[:, 1]))]
    clipped = InputScaling(np.ones(3), np.full(3, 2.0), 0.4)
    box = Box(inputs=clipped, middle=np.zeros(3), half=np.ones(3), gain=np.array([2.0]), offset=np.array([0.1]))
    for model in (Stacked(inputs=InputScaling.identity(3), parts=[*parts, box]), box):
        np.testing.assert_allclose(run(frozen_bytes(model), x=X)["y"], model.batch(X), rtol=1e-9, atol=1e-9)


def test_links_take_and_give_states() -> None:
    graph, models = chain()
    for edge, model in models.items():
        child = RNG.uniform(-3, 3, size=(20, len(graph.objects[edge.child].observable)))
        parent, after = RNG.uniform(-1, 1, size=(2, 20, len(graph.objects[edge.parent].observable)))
        found = run(forward_bytes(model), child=child, parent=parent, parent_next=after)["child_next"]
        np.testing.assert_allclose(found, model.predict(child, parent, after), rtol=1e-9, atol=1e-9)


POSED = StateSpace(
    "kart",
    (
        Variable("x", "m", role=Role("position", "floor", "x")),
        Variable("y", "m", role=Role("position", "floor", "y")),
        Variable("heading", "rad", -np.pi, np.pi, "angle", Role("orientation", "floor", "z")),
        Variable("speed", "m/s"),
    ),
)
STICK = StateSpace(
    "stick", (Variable("a", "m", role=Role("position", "desk", "x")), Variable("turn", "rad", kind="angle"))
)


def linear(n_in: int, n_out: int) -> FrozenModel:
    return freeze(Ridge().fit(RNG.normal(size=(50, n_in)), RNG.normal(size=(50, n_out))))


@pytest.mark.parametrize("features", ["none", "raw", "body"])
@pytest.mark.parametrize("action", ["next", "current", "both"])
def test_codes_angles_and_origins(features: str, action: str) -> None:
    origin = Origin("desk", (0.3, 0.0, 0.0))
    child = RNG.uniform(-3, 3, size=(30, 4))
    parent, after = RNG.uniform(-3, 3, size=(2, 30, 2))
    n_in = len(StateFeatures(POSED, features)) + 3 * (2 if action == "both" else 1)
    forward = ForwardModel(POSED, STICK, features, action, linear(n_in, 4), origin)
    content = forward_bytes(forward)
    found = run(content, child=child, parent=parent, parent_next=after)["child_next"]
    np.testing.assert_allclose(found, forward.predict(child, parent, after), rtol=1e-9, atol=1e-9)
    assert about(content)["parent"] == [
        {"name": "a", "unit": "m", "kind": "real"},
        {"name": "turn", "unit": "rad", "kind": "angle"},
    ]
    for targets in ((0, 1), (2,), (0, 2, 3)):
        lower, upper = np.array([-0.5, -1.0]), np.array([0.9, 1.0])
        frozen = linear(len(StateFeatures(POSED, features)) + len(targets), 2)
        inverse = InverseModel(POSED, STICK, targets, features, 2, frozen, lower, upper, origin)
        wanted = RNG.uniform(-3, 3, size=(30, len(targets)))
        content = inverse_bytes(inverse)
        answer = run(content, child=child, wanted=wanted)["parent"]
        np.testing.assert_allclose(answer, inverse(child, wanted), rtol=1e-9, atol=1e-9)
        assert about(content)["ticks_ahead"] == 2


def test_the_parts_of_a_graph_take_and_give_states(dispenser_model: InteractionModel) -> None:
    model = dispenser_model
    low, high = model.low, model.high
    states = {n: low[n] + RNG.random((50, len(low[n]))) * (high[n] - low[n]) for n in low}
    later = {n: s + 0.05 * RNG.normal(size=s.shape) for n, s in states.items()}
    used: set[str] = set()
    for edge in model.graph.interactions:
        status = run(status_bytes(model, edge), **states)
        np.testing.assert_allclose(status["decision"][:, 0], model.decide(edge, states), rtol=1e-9, atol=1e-9)
        sure = model.edges[edge].status.probability(states)
        np.testing.assert_allclose(status["probability"][:, 0], sure, atol=1e-6)
        ends = {"parent": states[edge.parent], "parent_next": later[edge.parent], "child": states[edge.child]}
        change = run(effect_bytes(model, edge), **ends)["change"]
        np.testing.assert_allclose(change, model.effect(edge, states, later[edge.parent]), rtol=1e-9, atol=1e-9)
        used |= {c.source for e in model.edges[edge].effects for c in e.columns}
        assert about(status_bytes(model, edge))["interaction"] == edge.name
    assert {"aligned_change", "received", "mixing"} <= used
    for name, passive in model.passive.items():
        found = run(passive_bytes(passive), state=states[name])["next_state"]
        np.testing.assert_allclose(found, passive(states[name]), rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("angle", [False, True])
def test_differences_of_two_ends_are_written_as_they_are_read(angle: bool) -> None:
    item = DifferenceInput("a", "b", (2, 1), angle, "b.y - a.z")
    states = {n: RNG.uniform(-6, 6, size=(20, 3)) for n in "ab"}
    graph = OnnxGraph("difference")
    graph.output("y", _status_input(graph, item, {n: graph.input(n, 3) for n in "ab"}), 1)
    np.testing.assert_allclose(run(graph.to_bytes({}), **states)["y"], item(states), atol=1e-12)


def test_links_of_a_library_as_files(tmp_path: Path) -> None:
    save_chain(CHAIN, tmp_path / "lib", "scenario", HASH)
    files = export_item(tmp_path / "lib", LINK, tmp_path / "out")
    assert [f.name for f in files] == ["forward.onnx", "inverse-0.onnx"]
    (link,) = load_links(tmp_path / "lib", GRAPH, ("hand", "stick"), ("a", "b")).values()
    child, wanted = RNG.normal(size=(2, 7, 2))
    answer = run(files[1].read_bytes(), child=child, wanted=wanted)["parent"]
    np.testing.assert_allclose(answer, link.best_inverse.model(child, wanted), rtol=1e-9, atol=1e-9)
    with pytest.raises(InputError, match=r"forward.onnx: is there already"):
        export_item(tmp_path / "lib", LINK, tmp_path / "out")
    with pytest.raises(InputError, match="no"):
        export_item(tmp_path / "lib", "../lib", tmp_path / "out2")
    assert not (tmp_path / "out2").exists()


def test_a_graph_of_a_library_as_files(dispenser_model: InteractionModel, tmp_path: Path) -> None:
    save(dispenser_model, tmp_path / "lib", "water_dispenser")
    assert (
        main(["library", "export", "graph.water_dispenser", "--library", f"{tmp_path}/lib", "-o", f"{tmp_path}/out"])
        == 0
    )
    edges = [e.name.replace("->", "-") for e in dispenser_model.graph.interactions]
    wanted = {f"{e}.{part}.onnx" for e in edges for part in ("status", "effect")}
    wanted |= {f"{n}.passive.onnx" for n in dispenser_model.passive}
    assert {f.name for f in (tmp_path / "out").iterdir()} == wanted


def test_what_has_no_form_in_onnx_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    own = SimpleNamespace(kind="own", n_in=0, inputs=InputScaling.identity(0))
    with pytest.raises(InputError, match="a frozen own model can't be written as ONNX"):
        add_frozen(OnnxGraph("g"), own, "x")
    none = np.zeros(0)
    empty = Box(inputs=own.inputs, middle=none, half=none, gain=np.ones(1), offset=np.zeros(1))
    with pytest.raises(InputError, match="a box without inputs"):
        add_frozen(OnnxGraph("g"), empty, "x")
    monkeypatch.setitem(sys.modules, "onnx", None)
    with pytest.raises(InputError, match=r"writing ONNX needs onnx; .*pip install 'ichain_drake\[onnx\]'"):
        OnnxGraph("g")


@pytest.mark.parametrize("view", ["plain", "cos", "sin"])
@pytest.mark.parametrize("source", ["parent", "child"])
def test_columns_of_an_effect_are_seen_as_they_are_here(view: str, source: str) -> None:
    column = Column(source, "it", 1, view)  # type: ignore[arg-type]
    graph = OnnxGraph("column")
    tables = {n: RNG.normal(size=(5, 2)) for n in ("parent", "parent_next", "child")}
    names = [graph.input(n, 2) for n in tables]
    graph.output("y", _column(graph, column, *names), 1)
    here = column(*tables.values())
    wanted = {"plain": lambda v: v, "cos": np.cos, "sin": np.sin}[view]
    np.testing.assert_allclose(here, wanted(tables["parent_next" if source == "parent" else "child"][:, 1]))
    used = {k: v for k, v in tables.items() if k == ("parent_next" if source == "parent" else "child")}
    (there,) = run_graph_of(graph, used).values()
    np.testing.assert_allclose(there[:, 0], here, atol=1e-12)


def run_graph_of(graph: OnnxGraph, tables: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    session = runtime.InferenceSession(graph.to_bytes({}), providers=["CPUExecutionProvider"])
    given = {i.name: tables.get(i.name, np.zeros((5, 2))) for i in session.get_inputs()}
    return dict(zip([o.name for o in session.get_outputs()], session.run(None, given), strict=True))
