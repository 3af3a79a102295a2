"""Every interaction of saved graphs that fits is found, under any names; what doesn't fit is named with the reason."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import small_world

from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning import InteractionModel, KnownParts, SwitchingWindow, learn_interactions
from ichain_drake.learning.library import load_fitting, load_parts, save_graph
from ichain_drake.learning.library.manifest import write_manifest
from ichain_drake.learning.library.saved_graph import GRAPH as FORM
from ichain_drake.learning.status.inputs import ValueInput
from ichain_drake.state import StateSpace, Variable

GRAPH, HASH = small_world.GRAPH, "0123456789abcdef" * 4
BOX, VALVE, TAP, FILL, LAMP = GRAPH.interactions
OTHER = {"hand": "palm", "box": "parcel", "valve": "cock", "tap": "pipe", "lamp": "bulb"}


def known_of(model: InteractionModel) -> InteractionModel:
    mine = [e for e in model.graph.interactions if e.parent == model.graph.root]
    windows = {e: (SwitchingWindow(np.zeros((2, 4)), np.zeros(len(GRAPH.objects[e.child])), 1),) for e in mine}
    return replace(model, activations=windows, deactivations=windows, robot_seconds=12.5, demonstrations_sha256=HASH)


@pytest.fixture(scope="module")
def library(model: InteractionModel, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("parts") / "library"
    save_graph(known_of(model), folder, "job")
    return folder


def graph_with(**changed: StateSpace) -> InteractionGraph:
    return InteractionGraph(GRAPH.objects | changed, GRAPH.interactions)


TORCH = StateSpace("torch", (Variable("glow", lower=0.0, upper=2.0),))


def test_under_other_names_it_is_the_same_to_the_last_bit(library: Path, model: InteractionModel) -> None:
    here = InteractionGraph(
        {OTHER[n]: s for n, s in GRAPH.objects.items()}, [(OTHER[e.parent], OTHER[e.child]) for e in GRAPH.interactions]
    )
    parts = load_parts(library, "another", here)
    assert not parts.reasons
    assert parts.is_whole(here)
    assert parts.sources[Interaction("palm", "parcel")] == f"{library / 'graph.job'}: hand->box"
    assert set(parts.robot_seconds.values()) == {12.5}
    assert set(parts.activations) == {e for e in here.interactions if e.parent == "palm"} == set(parts.deactivations)
    found = learn_interactions([], here, known=parts)
    rows = {n: np.vstack([small_world.states_of(p)[n] for p in small_world.pieces(5)]) for n in GRAPH.objects}
    renamed = {OTHER[n]: s for n, s in rows.items()}
    for ours, theirs in zip(found.graph.interactions, GRAPH.interactions, strict=True):
        np.testing.assert_array_equal(found.decide(ours, renamed), model.decide(theirs, rows))
        seen = [i.label for i in found.edges[ours].status.inputs]
        assert len(seen) == len(model.edges[theirs].status.inputs)
        assert not [label for label in seen if any(old in label for old in GRAPH.objects)]
    ahead = found.step(renamed, np.roll(renamed["palm"], -1, axis=0))[0]
    wanted = model.step(rows, np.roll(rows["hand"], -1, axis=0))[0]
    for n in GRAPH.objects:
        np.testing.assert_array_equal(ahead[OTHER[n]], wanted[n])


def test_the_whole_graph_is_taken_as_one_where_it_fits(library: Path, model: InteractionModel) -> None:
    whole = load_fitting(library, "job", GRAPH)
    assert isinstance(whole, InteractionModel)
    assert whole.report() == model.report()
    found = load_fitting(library, "another job", GRAPH)
    assert isinstance(found, KnownParts)
    assert set(found.elsewhere) == set(GRAPH.interactions)


def test_what_fits_is_taken_beside_what_does_not(library: Path) -> None:
    here = graph_with(lamp=TORCH)
    found = load_fitting(library, "job", here)
    assert isinstance(found, KnownParts)
    assert set(found.edges) == {BOX, VALVE, TAP, FILL}
    assert set(found.objects) == set(GRAPH.objects) - {"lamp"}
    assert not found.elsewhere
    assert list(found.reasons) == [LAMP]
    assert "graph.job: lamp: type: it is lamp, here it is torch" in found.reasons[LAMP]
    model = learn_interactions(
        [p for p in small_world.pieces(3) if (p.table[LAMP.name] > 0.5).any()], here, known=found
    )
    assert [e.variable for e in model.edges[LAMP].effects] == [0]


def test_of_two_that_are_alike_none_is_guessed(library: Path) -> None:
    more = [*GRAPH.interactions, "hand->second", "second->tap"]
    two = InteractionGraph(GRAPH.objects | {"second": GRAPH.objects["valve"]}, more)
    found = load_parts(library, "job", two)
    assert set(found.edges) == set(GRAPH.interactions)  # the names tell
    assert "hand->valve may be any of hand->valve, hand->second" in found.reasons[Interaction("hand", "second")]
    named = {"left": GRAPH.objects["valve"], "right": GRAPH.objects["valve"]}
    objects = {n: s for n, s in GRAPH.objects.items() if n != "valve"} | named
    edges = [BOX, FILL, "hand->left", "hand->right", "left->tap", "right->tap", "right->lamp"]
    found = load_parts(library, "job", InteractionGraph(objects, edges))
    assert set(found.edges) == {BOX, FILL, Interaction("right", "lamp")}
    assert "hand->valve may be any of hand->left, hand->right" in found.reasons[Interaction("hand", "left")]
    assert "or lift what was learned on one to all of its type" in found.reasons[Interaction("hand", "left")]


def test_what_was_learned_on_one_is_lifted_to_all_of_its_type_where_that_is_said(library: Path) -> None:
    more = [*GRAPH.interactions, "hand->second", "second->tap"]
    two = InteractionGraph(GRAPH.objects | {"second": GRAPH.objects["valve"]}, more)
    found = load_parts(library, "job", two, lift=True)
    assert not found.reasons
    hand, tap = Interaction("hand", "second"), Interaction("second", "tap")
    assert (found.sources[hand], found.sources[VALVE]) == (
        f"{library / 'graph.job'}: hand->valve",
        f"{library / 'graph.job'}",
    )
    for here, there in ((hand, VALVE), (tap, TAP)):
        assert [e.variable for e in found.edges[here].effects] == [e.variable for e in found.edges[there].effects]
        assert not any("valve" in i.label for i in found.edges[here].status.inputs)
    assert {hand, VALVE} <= set(found.activations)


def test_a_status_needs_all_that_it_looks_at(model: InteractionModel, tmp_path: Path) -> None:
    status = model.edges[FILL].status
    assert len(status.offset) == 3  # the box's place
    inputs = tuple(ValueInput("hand", i, f"hand.{axis}") for i, axis in enumerate("xyz"))
    learned = replace(model.edges[FILL], status=replace(status, inputs=inputs))
    save_graph(known_of(replace(model, edges=model.edges | {FILL: learned})), tmp_path, "job")
    assert FILL in load_parts(tmp_path, "job", GRAPH).edges
    alone = InteractionGraph(GRAPH.objects, [VALVE, TAP, FILL, LAMP])  # the hand is no parent of the box any more
    found = load_parts(tmp_path, "job", alone)
    assert set(found.edges) == {VALVE, TAP, LAMP}
    assert "tap->box: its status also looks at hand, which doesn't act on box here" in found.reasons[FILL]


def test_an_empty_library_knows_nothing_and_says_so(tmp_path: Path) -> None:
    found = load_parts(tmp_path, "job", GRAPH)
    assert not found.edges
    assert set(found.reasons.values()) == {"the library knows no such interaction"}
    with pytest.raises(InputError, match="can't be read as a folder"):
        load_parts(tmp_path / "nix", "job", GRAPH)


def test_a_graph_of_the_same_name_of_which_nothing_fits_is_refused(library: Path) -> None:
    hand = GRAPH.objects["hand"]
    inches = StateSpace("hand", tuple(replace(v, unit="in") if v.unit == "m" else v for v in hand.variables))
    valve = replace(GRAPH.objects["valve"], type="crank")
    box = replace(GRAPH.objects["box"], type="jar")
    with pytest.raises(InputError, match="hand hand: variable x: its unit is m in the library, in here"):
        load_fitting(library, "job", graph_with(hand=inches, valve=valve, box=box))


def test_a_damaged_graph_of_any_name_is_refused(library: Path, model: InteractionModel, tmp_path: Path) -> None:
    save_graph(known_of(model), tmp_path / "L", "zebra")
    (tmp_path / "L" / "graph.zebra" / "model.npz").write_bytes(b"")
    with pytest.raises(InputError, match=r"graph\.zebra/model\.npz: its sha256 is not the manifest's"):
        load_fitting(tmp_path / "L", "job", GRAPH)


def test_another_period_is_a_reason(model: InteractionModel, tmp_path: Path) -> None:
    folder = save_graph(known_of(model), tmp_path, "zebra")
    fields = json.loads((folder / "manifest.json").read_text())
    fields = {k: v for k, v in fields.items() if k not in ("format", "checksums")} | {"period": 0.5}
    (folder / "manifest.json").write_bytes(write_manifest(fields, "zebra", FORM))
    found = load_parts(tmp_path, "job", GRAPH)
    assert not found.edges
    assert all("graph.zebra: period: it was learned at 0.5 s" in why for why in found.reasons.values())


def test_what_is_given_up_is_told_with_its_reason(library: Path) -> None:
    found = load_parts(library, "job", GRAPH).without({LAMP: "it glows in another color"})
    assert found.reasons == {LAMP: "it glows in another color"}
    assert set(found.sources) == set(GRAPH.interactions) - {LAMP} == set(found.edges)
    assert "lamp" not in found.objects
    assert VALVE in found.activations
    assert VALVE not in found.without({VALVE: "moved"}).activations
