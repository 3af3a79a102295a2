"""A library that is damaged, edited or foreign is refused by name."""

import json
import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from linked_library import CHAIN, EDGE, GRAPH, HAND, HASH, LINK, STICK, forge, load, refused

from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.learning.library import (
    check_library,
    list_library,
    load_command,
    load_link,
    load_links,
    save_chain,
    show_link,
)
from ichain_drake.learning.library.saved import SavedLink
from ichain_drake.state import Role, StateSpace, Variable
from ichain_drake.timing import TICK


def test_unknown_folders(library: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="it has no link 'hand-car'; it has hand-joystick"):
        show_link(library, "hand-car")
    for use in (list_library, check_library, load):
        with pytest.raises(InputError, match=r"nowhere: can't be read as a folder \(No such file or directory\)"):
            use(tmp_path / "nowhere")
        with pytest.raises(InputError, match="is a single link; give the folder that it is in"):
            use(library / LINK)
    with pytest.raises(InputError, match="there is no object 'foot'; objects are hand, stick"):
        load_links(library, GRAPH, ("foot", "stick"), ("a",))
    (library / LINK).rename(library / "hand-car")
    (problem,) = check_library(library)
    assert "hand-car: the link in it is hand-joystick; give the folder that name" in problem


def swapped(space: StateSpace, **changes: Any) -> StateSpace:
    """The state space with its second variable changed."""
    return replace(space, variables=(space.variables[0], replace(space.variables[1], **changes)))


MISFITS = {
    "name": (HAND, swapped(STICK, name="c"), "child joystick: variable b: the graph's object doesn't have it"),
    "more": (
        replace(HAND, variables=(*HAND.variables, Variable("z", "m"))),
        STICK,
        "parent hand: variable z: the library's link doesn't know it",
    ),
    "fewer": (
        replace(HAND, variables=HAND.variables[:1]),
        STICK,
        "parent hand: variable y: the graph's object doesn't",
    ),
    "order": (replace(HAND, variables=HAND.variables[::-1]), STICK, "parent hand: variable x: y stands in its place"),
    "unit": (swapped(HAND, unit="mm"), STICK, "parent hand: variable y: its unit is m in the library, mm here"),
    "kind": (HAND, swapped(STICK, kind="real"), "child joystick: variable b: its kind is angle in the library, real"),
    "role": (
        swapped(HAND, role=Role("position", "table", "y")),
        STICK,
        "parent hand: variable y: its role is none in the library, position frame 'table' axis 'y' here",
    ),
}


@pytest.mark.parametrize("what", MISFITS)
def test_a_link_for_other_variables_is_refused(library: Path, what: str) -> None:
    hand, stick, match = MISFITS[what]
    graph = InteractionGraph({"hand": hand, "stick": stick}, ["hand->stick"])
    with pytest.raises(InputError, match=match):
        load_links(library, graph, ("hand", "stick"), stick.names)
    with pytest.raises(InputError, match=match):
        load_command(library, graph, ("hand", "stick"))


def test_a_link_for_other_targets_types_period_or_convention_is_refused(library: Path) -> None:
    with pytest.raises(InputError, match="targets: its inverse models bring about a, b of joystick, here a are wanted"):
        load_links(library, GRAPH, ("hand", "stick"), ("a",))
    other = InteractionGraph({"hand": HAND, "stick": replace(STICK, type="lever")}, ["hand->stick"])
    with pytest.raises(InputError, match="child: type: it is joystick, here it is lever"):
        load_link(library / LINK, other, EDGE, [0, 1])
    forge(library / LINK, lambda m: m.update(period=0.1))
    refused(library, "period: it was learned at 0.1 s, this version runs at 0.333333 s")
    forge(library / LINK, lambda m: m.update(period=TICK, time="backwards"))
    refused(library, "time: its convention is 'backwards'")


def test_versions_of_other_programs_do_not_matter_but_the_format_does(library: Path) -> None:
    forge(library / LINK, lambda m: m.update(versions={"python": "4.0", "drake": "9.9", "scikit-learn": "0.1"}))
    assert check_library(library) == []
    load(library)
    forge(library / LINK, lambda m: m.update(format=3, novelty=True))
    refused(library, "manifest.json: format 3 is newer than 2, .* update ichain_drake")
    forge(library / LINK, lambda m: m.update(format=1))
    refused(library, "manifest.json: format 1 is older than 2, .* learn the link anew")
    forge(library / LINK, lambda m: m.update(format=0))
    refused(library, "manifest.json: format 0 is unknown")


EDITS: dict[str, tuple[Callable[[dict[str, Any]], object], str]] = {
    "missing": (lambda m: m.pop("child_scale"), "child_scale: missing"),
    "unknown": (lambda m: m.update(extra=1), "extra: unknown field"),
    "inner": (lambda m: m["parent"]["variables"][1].pop("unit"), r"parent.variables\[1\].unit: missing"),
    "kind": (lambda m: m["child"]["variables"][0].update(kind="odd"), r"child.variables\[0\].kind: 'odd' can't"),
    "text": (lambda m: m.update(robot_seconds="long"), "robot_seconds: 'long' can't stand here"),
    "truth": (lambda m: m.update(robot_seconds=True), "robot_seconds: True can't stand here"),
    "huge": (lambda m: m["forward"].update(score=10**400), "forward.score: 1000.* can't stand here"),
    "fraction": (lambda m: m["forward"].update(samples=1.5), "forward.samples: 1.5 can't stand here"),
    "list": (lambda m: m.update(child_limit=3), "child_limit: a list is needed, found 3"),
    "fields": (lambda m: m.update(command=3), "command: named fields are needed, found 3"),
    "hash": (lambda m: m.update(demonstrations_sha256="abc"), "demonstrations_sha256: 'abc' can't"),
    "format": (lambda m: m.update(format="1"), "format: '1' can't stand here"),
    "length": (lambda m: m["child_limit"].append(1.0), "child_limit: 3 numbers for 2 variables"),
    "inverse length": (
        lambda m: m["inverses"][0]["parent_lower"].pop(),
        r"inverses\[0\].parent_lower: 1 numbers for 2",
    ),
    "command length": (lambda m: m["command"]["lower"].pop(), "command.lower: 1 numbers for 2 variables"),
    "no inverse": (
        lambda m: (m["inverses"].clear(), m["files"].pop("inverse_0.npz")),
        "inverse_0.npz: is no part of this link",
    ),
    "aim": (lambda m: m["inverses"][0].update(aim=0), r"inverses\[0\].aim: 0 ticks ahead"),
    "estimator": (
        lambda m: m["forward"].update(estimator="os.mkdir('x')"),
        "forward.estimator: estimator .*: write name or name",
    ),
    "nested": (lambda m: m["forward"].update(estimator="(" * 10**5), "forward.estimator: "),
    "body": (lambda m: m["forward"].update(features="body"), "forward.features: joystick has no position x, y"),
    "features": (lambda m: m["forward"].update(features="none"), "forward.npz: its model has 7 inputs and 2 outputs"),
    "model kind": (lambda m: m["forward"].update(kind="trees"), "forward.npz: frozen model of kind 'trees'"),
    "no kind": (lambda m: m["forward"].update(kind="magic"), "forward.npz: frozen model of kind 'magic': unknown"),
    "twice": (lambda m: m["forward"].update(file="inverse_0.npz"), "files: inverse_0.npz is not there exactly once"),
    "unlisted": (lambda m: m["files"].pop("forward.npz"), "files: forward.npz is not there exactly once"),
    "doubled": (
        lambda m: m["child"]["variables"][1].update(name="a"),
        "parent, child: state space joystick: variable a",
    ),
    "role": (lambda m: m["child"]["variables"][0]["role"].update(of="q"), "parent, child: .* a refers to q"),
    "target": (lambda m: m.update(targets=["a", "q"]), "parent, child: joystick has no variable 'q'"),
    "targets": (lambda m: m.update(targets=["a", "a"]), "targets: each needs to be named once"),
}


@pytest.mark.parametrize("what", EDITS)
def test_a_manifest_that_can_not_be_true_is_refused(library: Path, what: str) -> None:
    edit, match = EDITS[what]
    forge(library / LINK, edit)
    refused(library, match)


def test_an_edited_field_is_named(library: Path) -> None:
    file = library / LINK / "manifest.json"
    whole = json.loads(file.read_text())
    edits: dict[str, Any] = {
        "targets": ["a"], "child_limit": [9.0, 9.0], "robot_seconds": 1e6, "source": "me", "versions": {},
        "demonstrations_sha256": "0" * 64, "interaction": "a->b",
    }  # fmt: skip
    for field, value in edits.items():
        file.write_text(json.dumps(whole | {field: value}))
        refused(library, f"manifest.json: {field}: does not match its checksum; the file is damaged or was edited")


@pytest.mark.parametrize("text", ["", "{", "[]", "null", "7", '"x"', "[" * 10**5, '{"format": NaN}', "\xff", "{}"])
def test_what_is_no_manifest_is_refused(library: Path, text: str) -> None:
    (library / LINK / "manifest.json").write_bytes(text.encode("latin-1"))
    refused(library, f"{LINK}/manifest.json: ")


@pytest.mark.parametrize("file", ["manifest.json", "forward.npz", "inverse_0.npz", "command.npz"])
def test_a_missing_file_is_named(library: Path, file: str) -> None:
    (library / LINK / file).unlink()
    refused(library, "holds no manifest.json" if file == "manifest.json" else f"{file}: is missing")


@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.data())
def test_any_damage_is_refused_or_harmless(data: st.DataObject) -> None:
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder)
        save_chain(CHAIN, library, "a test", HASH)
        file = data.draw(st.sampled_from(sorted((library / LINK).iterdir())))
        before = file.read_bytes()
        at = data.draw(st.integers(0, len(before) - 1))
        flipped = bytes([before[at] ^ data.draw(st.integers(1, 255))])
        kept = before[at + 1 :] if data.draw(st.booleans()) else b""
        file.write_bytes(before[:at] + flipped + kept)
        # Only white space between the fields of a manifest may change.
        same = file.name == "manifest.json" and is_same_document(before, file.read_bytes())
        assert (check_library(library) == []) == same


def is_same_document(a: bytes, b: bytes) -> bool:
    try:
        return json.loads(a) == json.loads(b)
    except (ValueError, RecursionError):
        return False


def edited_arrays(file: Path, **changes: Any) -> None:
    with np.load(file) as opened:
        arrays = dict(opened) | changes
    np.savez(file, **{name: array for name, array in arrays.items() if array is not None})


@pytest.mark.parametrize(
    ("changes", "match"),
    [
        ({"weights": None}, "forward.npz: frozen model of kind 'polynomial': its arrays are incomplete"),
        ({"weights": np.full((2, 5), np.nan)}, "forward.npz: .* array weights contains NaN"),
        ({"weights": np.full((2, 8), np.inf)}, "forward.npz: the polynomial model gives no finite numbers"),
        ({"weights": np.zeros((2, 5))}, "forward.npz: "),
        ({"surplus": np.zeros(2)}, "forward.npz: array surplus is no part of a polynomial model"),
        ({"input_mean": np.zeros((3, 1))}, "forward.npz: "),
    ],
)
def test_weights_that_make_no_model_are_refused(library: Path, changes: dict[str, Any], match: str) -> None:
    edited_arrays(library / LINK / "forward.npz", **changes)
    forge(library / LINK)
    refused(library, match)


@pytest.mark.parametrize("sizes", [(2, 1), (4, 1), (3, 0), (3, 2), (2, 2), (4, 0)])
def test_a_model_of_another_size_than_the_manifest_says_is_refused(sizes: tuple[int, int], tmp_path: Path) -> None:
    saved: Any = SimpleNamespace(folder=tmp_path)
    SavedLink._check_sizes(saved, {"file": "a.npz"}, SimpleNamespace(n_in=3, n_out=1), 3, 1)  # type: ignore[arg-type]
    model: Any = SimpleNamespace(n_in=sizes[0], n_out=sizes[1])
    with pytest.raises(InputError, match=f"has {sizes[0]} inputs and {sizes[1]} outputs, the manifest's has 3 and 1"):
        SavedLink._check_sizes(saved, {"file": "a.npz"}, model, 3, 1)
