"""A learned graph comes back from a library as it was, to the last bit, or is refused with the field that is wrong."""

import copy
import io
import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import small_world
from hypothesis import given, settings
from hypothesis import strategies as st

from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning import (
    InteractionModel,
    InteractionSpec,
    SwitchingWindow,
    learn_interactions,
)
from ichain_drake.learning.chain.link import EstimatorSpec
from ichain_drake.learning.library import (
    add_to_library,
    check_library,
    graph_name,
    link_name,
    list_graphs,
    list_library,
    load_graph,
    load_links,
    save_graph,
    show_graph,
)
from ichain_drake.learning.library.files import sha256
from ichain_drake.learning.library.manifest import write_manifest
from ichain_drake.learning.library.saved_graph import GRAPH as FORM
from ichain_drake.learning.library.weights import pack_arrays, unpack_arrays
from ichain_drake.state import Role, StateSpace, Variable

HASH = "0123456789abcdef" * 4
GRAPH = small_world.GRAPH
BOX = Interaction("hand", "box")
Pair = tuple[InteractionModel, InteractionModel]
ESTIMATORS = {
    "polynomial(degree=1, clip=None)": "box(reach=0.15)",
    "kernel_ridge(alpha=0.03, gamma=0.3)": "SVC(C=30.0, gamma=1.0, class_weight='balanced')",
    "rectified_linear()": "LogisticRegression()",
}


def known_of(model: InteractionModel) -> InteractionModel:
    windows = {
        e: SwitchingWindow(np.arange(8.0).reshape(2, 4), np.arange(len(GRAPH.objects[e.child])) / 7.0, 1)
        for e in GRAPH.interactions
        if e.parent == "hand"
    }
    return replace(
        model,
        activations={e: (w, w) for e, w in windows.items()},
        deactivations={e: () for e in windows},
        robot_seconds=12.5,
        demonstrations_sha256=HASH,
    )


@pytest.fixture(scope="module")
def knowns(model: InteractionModel, demonstrations: list) -> list[InteractionModel]:
    """The usual candidates, and each other kind of frozen model that fits these data."""
    specs = [
        InteractionSpec(effect_estimators=(EstimatorSpec.parse(e),), status_estimators=(EstimatorSpec.parse(s),))
        for e, s in ESTIMATORS.items()
    ]
    return [known_of(m) for m in (model, *(learn_interactions(demonstrations, GRAPH, s) for s in specs))]


@pytest.fixture(scope="module")
def pairs(knowns: list[InteractionModel], tmp_path_factory: pytest.TempPathFactory) -> list[Pair]:
    library = tmp_path_factory.mktemp("pairs")
    found = []
    for i, known in enumerate(knowns):
        save_graph(known, library, f"job {i}")
        loaded = load_graph(library, f"job {i}", GRAPH)
        assert loaded is not None
        found.append((known, loaded))
    return found


@pytest.fixture
def library(knowns: list[InteractionModel], tmp_path: Path) -> Path:
    save_graph(knowns[0], tmp_path / "library", "job")
    return tmp_path / "library"


def same(a: Any, b: Any) -> bool:
    return np.asarray(a).tobytes() == np.asarray(b).tobytes()


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), rows=st.integers(1, 4), beyond=st.sampled_from([0.0, 0.3, 5.0]))
def test_the_same_answers_to_the_last_bit(pairs: list[Pair], seed: int, rows: int, beyond: float) -> None:
    rng = np.random.default_rng(seed)
    for known, loaded in pairs:
        old, new = known, loaded
        states, ahead = (
            {
                n: old.low[n] + (old.high[n] - old.low[n]) * rng.uniform(-beyond, 1 + beyond, (rows, len(old.low[n])))
                for n in GRAPH.objects
            }
            for _ in range(2)
        )
        forced = {e: rng.random(rows) < 0.5 for e in GRAPH.interactions if rng.random() < 0.5}
        for e in GRAPH.interactions:
            assert same(old.decide(e, states), new.decide(e, states))
            assert same(old.effect(e, states, ahead[e.parent]), new.effect(e, states, ahead[e.parent]))
            assert same(old.spread(e.child, [e]), new.spread(e.child, [e]))
        for a, b in zip(*(m.step(states, ahead["hand"], forced) for m in (old, new)), strict=True):
            assert list(a) == list(b)
            assert all(same(a[k], b[k]) for k in a)


def test_all_that_planning_needs_comes_back(pairs: list[Pair]) -> None:
    for known, loaded in pairs:
        assert loaded.report() == known.report()
        assert (loaded.robot_seconds, loaded.demonstrations_sha256) == (12.5, HASH)
        assert loaded.order == known.order
        for name in ("low", "high", "step_limit", "noise"):
            old, new = getattr(known, name), getattr(loaded, name)
            assert all(same(old[n], new[n]) for n in GRAPH.objects)
        for e, learned in known.edges.items():
            old, new = learned.examples, loaded.edges[e].examples
            assert (new.activations.rows, new.deactivations.pieces) == (old.activations.rows, old.deactivations.pieces)
            assert all(same(old.active[n], new.active[n]) for n in GRAPH.objects)
            assert same(learned.active_high, loaded.edges[e].active_high)
        window = loaded.activations[BOX][1]
        assert same(window.root, known.activations[BOX][1].root)
        assert window.event == 1
        assert loaded.deactivations[BOX] == ()


def test_it_is_listed_shown_checked_and_copied_beside_links(library: Path, tmp_path: Path) -> None:
    assert check_library(library) == []
    assert list_library(library) == []
    assert load_links(library, GRAPH, ["hand", "box"], ["x"]) == {}
    (shown,) = list_graphs(library)
    assert (shown.name, shown.source, shown.robot_seconds) == ("graph.job", "job", 12.5)
    assert set(shown.interactions) == {e.name for e in GRAPH.interactions}
    assert "hand: x [m]" in shown.objects["hand"]
    assert show_graph(library, "graph.job") == shown
    assert add_to_library(library, tmp_path / "other") == ["graph.job"]
    assert add_to_library(library / "graph.job", tmp_path / "third") == ["graph.job"]
    assert load_graph(tmp_path / "third", "job", GRAPH) is not None
    assert load_graph(library, "another job", GRAPH) is None
    assert link_name("graph", "job") != graph_name("job")
    assert graph_name("../a b") == "graph.%2e%2e%2fa%20b"
    with pytest.raises(InputError, match="needs a name"):
        graph_name("")


def test_the_order_of_objects_does_not_matter(library: Path, knowns: list[InteractionModel]) -> None:
    shuffled = InteractionGraph(dict(reversed(GRAPH.objects.items())), list(reversed(GRAPH.interactions)))
    loaded = load_graph(library, "job", shuffled)
    assert loaded is not None
    states = knowns[0].high
    assert same(loaded.decide(BOX, states), knowns[0].decide(BOX, states))


def changed(obj: str, change: Callable[[Variable], Variable]) -> InteractionGraph:
    space = GRAPH.objects[obj]
    return InteractionGraph(
        GRAPH.objects | {obj: StateSpace(space.type, tuple(change(v) for v in space.variables))}, GRAPH.interactions
    )


@pytest.mark.parametrize(
    ("graph", "message"),
    [
        (changed("lamp", lambda v: replace(v, unit="K")), "lamp lamp: variable glow: its unit is 1 in the library, K"),
        (changed("valve", lambda v: replace(v, kind="real")), "variable level: its kind is integer in the library"),
        (changed("lamp", lambda v: replace(v, role=Role("level"))), "variable glow: its role is none in the library"),
        (changed("lamp", lambda v: replace(v, name="shine")), "variable glow: the graph's object doesn't have it"),
        (InteractionGraph(GRAPH.objects | {"jar": GRAPH.objects["lamp"]}, [*GRAPH.interactions, "tap->jar"]),
         "object jar: the library's graph doesn't know it; learn the graph anew"),
        (InteractionGraph({n: s for n, s in GRAPH.objects.items() if n != "lamp"}, GRAPH.interactions[:-1]),
         "object lamp: this graph doesn't have it"),
        (InteractionGraph(GRAPH.objects, [*GRAPH.interactions, "hand->tap"]), "interaction hand->tap: the library's"),
        (InteractionGraph(GRAPH.objects | {"lamp": replace(GRAPH.objects["lamp"], type="torch")}, GRAPH.interactions),
         "type: it is lamp, here it is torch"),
    ],
)  # fmt: skip
def test_another_graph_is_refused(library: Path, graph: InteractionGraph, message: str) -> None:
    with pytest.raises(InputError, match=message):
        load_graph(library, "job", graph)


def edit(library: Path, change: Callable[[dict[str, Any]], None]) -> None:
    file = library / "graph.job" / "manifest.json"
    content = json.loads(file.read_text())
    change(content)
    file.write_text(json.dumps(content))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda m: m.update(format=5), "format 5 is newer than 4"),
        (lambda m: m.update(format=3), "format 3 is older than 4"),  # from before changes went one way
        (lambda m: m.update(robot_seconds=1.0), "robot_seconds: does not match its checksum"),
        (lambda m: m["model"]["noise"].reverse(), "model: does not match its checksum"),
        (lambda m: m.pop("period"), "period: missing"),
        (lambda m: m["interactions"]["hand->box"].update(f1="good"), r"interactions\.hand->box\.f1: 'good' can't"),
        (lambda m: m["files"].update({"model.npz": HASH}), "files: does not match its checksum"),
    ],
)
def test_an_edited_manifest_is_refused_by_its_field(
    library: Path, change: Callable[[dict[str, Any]], None], message: str
) -> None:
    edit(library, change)
    with pytest.raises(InputError, match=message):
        load_graph(library, "job", GRAPH)
    assert len(check_library(library)) == 1


def pickled(data: bytes) -> bytes:
    stream = io.BytesIO()
    np.savez(stream, a=np.array([{"nobody": "reads this"}], dtype=object))
    return stream.getvalue()


@pytest.mark.parametrize(
    ("file", "change", "message"),
    [
        ("manifest.json", lambda data: data[: len(data) // 2], "is no complete JSON"),
        ("model.npz", lambda data: data[:-1000], "its sha256 is not the manifest's"),
        ("model.npz", lambda data: data[:5000] + bytes([data[5000] ^ 1]) + data[5001:], "its sha256 is not"),
        ("model.npz", pickled, "its sha256 is not"),
        ("model.pkl", lambda data: b"cos\nsystem\n(S'true'\ntR.", "is no part of a link and is not opened"),
    ],
)
def test_a_damaged_or_foreign_file_is_refused(
    library: Path, file: str, change: Callable[[bytes], bytes], message: str
) -> None:
    path = library / "graph.job" / file
    path.write_bytes(change(path.read_bytes() if path.exists() else b""))
    with pytest.raises(InputError, match=message):
        load_graph(library, "job", GRAPH)


def reseal(library: Path, tree: Any = None, arrays: bytes | None = None) -> None:
    """Other contents under hashes that are right: what somebody forged."""
    folder = library / "graph.job"
    fields = json.loads((folder / "manifest.json").read_text())
    data = (folder / "model.npz").read_bytes() if arrays is None else arrays
    fields = {k: v for k, v in fields.items() if k not in ("format", "checksums")}
    fields |= {"model": fields["model"] if tree is None else tree, "files": {"model.npz": sha256(data)}}
    (folder / "model.npz").write_bytes(data)
    (folder / "manifest.json").write_bytes(write_manifest(fields, "forged", FORM))


FORGED = [
    (("edges", 0, 1, "status", "is"), "Popen", r"model\.edges\[0\]\.status\.is: 'Popen' can't stand here"),
    (("edges", 0, 1, "status", "inputs", 0, "is"), "Popen", r"inputs\[0\]\.is: 'Popen' can't stand here"),
    (("edges", 0, 1, "status", "frozen", "is"), "pickle", "frozen model of kind 'pickle': unknown"),
    (("edges", 0, 1, "status", "margin"), "much", r"status\.margin: 'much' can't stand here"),
    (("edges", 0, 1, "status", "offset"), None, r"status\.offset: its array is missing"),
    (("edges", 0, 0), "hand->moon", r"model\.edges\[0\]: 'hand->moon' can't stand here"),
    (("edges", 1, 0), "hand->box", r"model\.edges\[1\]: 'hand->box' is there twice"),
    (("edges",), [], r"model\.\w+.*: an array that is no part of the model"),
    (("edges", 0, 1, "effects"), {}, r"effects: a list is needed"),
    (("edges", 0, 1, "effects", 0, "variable"), 9, r"model\.edges, hand->box: index 9"),
    (("edges", 0, 1, "colour"), "red", r"model\.edges\[0\]\.colour: unknown field"),
    (("order",), ["hand->box"], r"model\.order: it is not about exactly what the graph has"),
    (("passive", 0, 1), [], r"model\.passive: 0 variables for the 6 of box"),
    (("activations", 0, 1, 0, "event"), 7, "row 7 is not in its window"),
    (("low",), {}, r"model\.low: a list of pairs is needed"),
    (("pieces",), "all", r"model\.pieces: a list is needed"),
]


@pytest.mark.parametrize(("place", "value", "message"), FORGED)
def test_forged_contents_are_refused_by_their_place(library: Path, place: tuple, value: Any, message: str) -> None:
    content = json.loads((library / "graph.job" / "manifest.json").read_text())
    tree = node = copy.deepcopy(content["model"])
    for key in place[:-1]:
        node = node[key]
    node[place[-1]] = value
    reseal(library, tree)
    with pytest.raises(InputError, match=message):
        load_graph(library, "job", GRAPH)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda a: a.update({"model.low[0]": a["model.low[0]"][:-1]}), r"model\.low: hand: an array of another shape"),
        (lambda a: a.update({"model.low[0]": a["model.low[0]"] * np.nan}), r"model\.low\[0\]: a number in its array"),
        (lambda a: a.update({"model.low[0]": np.zeros(4, int)}), r"model\.low\[0\]: an array of int64, float64 is"),
        (lambda a: a.pop("model.edges[0].status.scale"), r"status\.scale: its array is missing"),
        (lambda a: a.update(more=np.zeros(2)), "more: an array that is no part of the model"),
        (lambda a: a.update({"model.edges[0].status.scale": np.zeros(1)}), r"model\.edges, hand->box: "),
    ],
)
def test_forged_arrays_are_refused_by_their_place(library: Path, change: Callable[[dict], Any], message: str) -> None:
    arrays = unpack_arrays((library / "graph.job" / "model.npz").read_bytes(), "model.npz")
    change(arrays)
    reseal(library, arrays=pack_arrays(arrays))
    with pytest.raises(InputError, match=message):
        load_graph(library, "job", GRAPH)


def test_nothing_is_unpickled(library: Path) -> None:
    reseal(library, arrays=pickled(b""))
    with pytest.raises(InputError, match="is no .npz file of plain arrays .*nothing in it was run"):
        load_graph(library, "job", GRAPH)


def test_what_is_not_finite_is_not_saved_and_the_earlier_graph_kept(
    library: Path, knowns: list[InteractionModel]
) -> None:
    known = knowns[0]
    status = replace(known.edges[BOX].status, score=float("nan"))
    broken = replace(known, edges=known.edges | {BOX: replace(known.edges[BOX], status=status)})
    with pytest.raises(InputError, match=r"model\.edges\[0\]\.status\.score: nan can't be saved"):
        save_graph(broken, library, "job")
    with pytest.raises(InputError, match="demonstrations_sha256"):
        save_graph(replace(known, demonstrations_sha256="?"), library, "job")
    assert load_graph(library, "job", GRAPH) is not None
    (library / "graph.job").rename(library / "graph.play")
    with pytest.raises(InputError, match=r"the graph in it is graph\.job; give the folder that name"):
        load_graph(library, "play", GRAPH)
