"""A library that is damaged, edited, foreign or unsafe is refused by name, and nothing in it is ever run."""

import hashlib
import io
import json
import os
import pickle
import resource
import shutil
import tempfile
import zipfile
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ichain_drake.demonstrations import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.learning.chain import LearnedChain, LinkCandidates, learn_chain
from ichain_drake.learning.library import (
    LearnedCommand,
    add_to_library,
    check_library,
    list_library,
    load_command,
    load_link,
    load_links,
    save_chain,
    save_link,
    show_link,
)
from ichain_drake.learning.link import EstimatorSpec
from ichain_drake.state import Role, StateSpace, Variable
from ichain_drake.timing import TICK

HASH = "0123456789abcdef" * 4
HAND = StateSpace("hand", (Variable("x", "m"), Variable("y", "m")))
STICK = StateSpace("joystick", (Variable("a", role=Role("level")), Variable("b", kind="angle")))
GRAPH = InteractionGraph({"hand": HAND, "stick": STICK}, ["hand->stick"])
EDGE = GRAPH.interactions[0]
LINK = "hand-joystick"


def learned() -> LearnedChain:
    rng = np.random.default_rng(0)
    hand = np.cumsum(rng.normal(size=(30, 2)), axis=0)
    states = {"hand": hand, "command": np.roll(hand, -1, axis=0) * 1.3, "stick": 0.1 * hand}
    table = {"time": np.arange(30) * TICK}
    for name, space in (("hand", HAND), ("command", HAND), ("stick", STICK)):
        table |= {f"{name}.{v}": states[name][:, i] for i, v in enumerate(space.names)}
    spec = EstimatorSpec("polynomial", {"degree": 1})
    candidates = {"*": LinkCandidates((spec,), (spec,), features=("raw",))}
    return learn_chain([Demonstration(pd.DataFrame(table))], GRAPH, "stick", ("a", "b"), candidates)


CHAIN = learned()


@pytest.fixture
def library(tmp_path: Path) -> Path:
    save_chain(CHAIN, tmp_path / "library", "a test", HASH)
    return tmp_path / "library"


def load(library: Path, graph: InteractionGraph = GRAPH) -> None:
    load_links(library, graph, ("hand", "stick"), ("a", "b"))


def forge(folder: Path, edit: Callable[[dict[str, Any]], object] = lambda manifest: None) -> None:
    """Edit a manifest and make all its checksums right again, as somebody who means harm would."""
    file = folder / "manifest.json"
    manifest = json.loads(file.read_text())
    for name in manifest["files"]:
        if (folder / name).is_file():
            manifest["files"][name] = hashlib.sha256((folder / name).read_bytes()).hexdigest()
    edit(manifest)
    del manifest["checksums"]
    manifest["checksums"] = {
        k: hashlib.sha256(json.dumps(v, sort_keys=True).encode()).hexdigest() for k, v in manifest.items()
    }
    file.write_text(json.dumps(manifest))


def refused(library: Path, match: str) -> None:
    """Refused by everything that loads, lists, checks or copies a link, in one line."""
    with pytest.raises(InputError, match=match) as caught:
        load(library)
    assert "\n" not in str(caught.value)
    with pytest.raises(InputError, match=match):
        add_to_library(library, library.parent / "other")
    assert not (library.parent / "other").exists()
    (problem,) = check_library(library)
    assert problem == str(caught.value)


class Trap:
    """Pickles to a call that makes a file."""

    def __init__(self, file: Path) -> None:
        self.file = file

    def __reduce__(self) -> tuple[Any, ...]:
        return os.mkdir, (str(self.file),)


@pytest.fixture
def sprung(tmp_path: Path) -> Iterator[Path]:
    """A path that a trap makes when it is run; the trap is shown to work, and the path must be gone at the end."""
    path = tmp_path / "sprung"
    pickle.loads(pickle.dumps(Trap(path)))
    assert path.exists()
    path.rmdir()
    yield path
    assert not path.exists()


def object_array(sprung: Path) -> np.ndarray:
    return np.array([Trap(sprung)], dtype=object)


def saved(write: Callable[..., None], *arrays: Any, **named: Any) -> bytes:
    stream = io.BytesIO()
    write(stream, *arrays, **named)
    return stream.getvalue()


def zipped(name: str, data: bytes) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        archive.writestr(name, data)
    return stream.getvalue()


SKOPS = json.dumps(
    {"__class__": "mkdir", "__module__": "os", "__loader__": "FunctionNode", "content": {}, "protocol": 2}
).encode()
PLANTED: dict[str, Callable[[Path], bytes]] = {
    "pickle": lambda sprung: pickle.dumps(Trap(sprung)),
    "object array in npz": lambda sprung: saved(np.savez, weights=object_array(sprung), allow_pickle=True),
    "object array as npy": lambda sprung: saved(np.save, object_array(sprung), allow_pickle=True),
    "pickle in zip": lambda sprung: zipped("weights.npy", pickle.dumps(Trap(sprung))),
    "pickle beside arrays": lambda sprung: zipped("data.pkl", pickle.dumps(Trap(sprung))),
    "skops": lambda sprung: zipped("schema.json", SKOPS),
    "plain npy": lambda sprung: saved(np.save, np.zeros(3)),
    "compressed": lambda sprung: saved(np.savez_compressed, weights=np.zeros(3)),
    "structured": lambda sprung: saved(np.savez, weights=np.zeros(3, dtype=[("a", float)])),
    "nothing": lambda sprung: b"",
}


@pytest.mark.parametrize("what", PLANTED)
@pytest.mark.parametrize("file", ["forward.npz", "inverse_0.npz", "command.npz"])
def test_planted_weights_are_refused_and_not_run(library: Path, sprung: Path, what: str, file: str) -> None:
    (library / LINK / file).write_bytes(PLANTED[what](sprung))
    refused(library, f"{LINK}/{file}: its sha256 is not the manifest's")
    forge(library / LINK)
    with pytest.raises(InputError, match=f"{LINK}/{file}: "):
        load_link(library / LINK, GRAPH, EDGE, [0, 1])
    (problem,) = check_library(library)
    assert f"{LINK}/{file}: " in problem
    with pytest.raises(InputError, match=f"{LINK}/{file}: "):
        add_to_library(library, library.parent / "other")


@pytest.mark.parametrize("name", ["model.pkl", "model.skops", "model.joblib", "forward.npz.pkl", "other.npz", ".x.pkl"])
def test_planted_files_beside_the_weights_are_refused(library: Path, sprung: Path, name: str) -> None:
    (library / LINK / name).write_bytes(pickle.dumps(Trap(sprung)))
    refused(library, f"{LINK}/{name}: is no part of (a|this) link and is not opened")
    with pytest.raises(InputError, match=name):
        list_library(library)


@pytest.mark.parametrize("name", ["model.pkl", "model.skops", "forward.npz"])
def test_planted_files_beside_the_links_are_refused(library: Path, sprung: Path, name: str) -> None:
    (library / name).write_bytes(pickle.dumps(Trap(sprung)))
    refused(library, f"{name} is no part of a library and is not opened")
    with pytest.raises(InputError, match=name):
        list_library(library)


def test_links_to_elsewhere_are_refused(library: Path, tmp_path: Path) -> None:
    outside = tmp_path / "outside.npz"
    (library / LINK / "forward.npz").rename(outside)
    (library / LINK / "forward.npz").symlink_to(outside)
    refused(library, "forward.npz: is no ordinary file")
    (library / LINK / "forward.npz").unlink()
    os.mkfifo(library / LINK / "forward.npz")
    refused(library, "forward.npz: is no ordinary file")
    shutil.rmtree(library / LINK)
    (tmp_path / "elsewhere").mkdir()
    (library / LINK).symlink_to(tmp_path / "elsewhere")
    refused(library, f"{LINK} is no part of a library")


@pytest.mark.parametrize("name", ["../outside.npz", "/etc/passwd", "sub/forward.npz", "..", "forward.pkl", ""])
def test_file_names_that_lead_elsewhere_are_refused(library: Path, name: str) -> None:
    def edit(manifest: dict[str, Any]) -> None:
        manifest["files"][name] = manifest["files"].pop("forward.npz")
        manifest["forward"]["file"] = name

    forge(library / LINK, edit)
    refused(library, "manifest.json: forward.file: .* can't stand here")
    forge(library / LINK, lambda m: m["forward"].update(file="forward.npz"))
    refused(library, "manifest.json: files: .* is no name that may stand here")


@pytest.mark.parametrize("name", ["../library/hand-joystick", "/hand-joystick", "..", "hand", "hand-joystick/../x", ""])
def test_link_names_that_lead_elsewhere_are_refused(library: Path, name: str) -> None:
    with pytest.raises(InputError, match="is no link's name; write it as <parent type>-<child type>"):
        show_link(library, name)


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
    forge(library / LINK, lambda m: m.update(format=2, novelty=True))
    refused(library, "manifest.json: format 2 is newer than 1, .* update ichain_drake")
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


def contents(folder: Path) -> dict[Path, bytes]:
    return {file.relative_to(folder): file.read_bytes() for file in folder.rglob("*") if file.is_file()}


def test_what_can_not_be_saved_leaves_the_earlier_link(library: Path) -> None:
    link, before = CHAIN.links[0], contents(library)
    nan = replace(link, child_limit=np.array([1.0, np.nan]))
    with pytest.raises(InputError, match=r"hand->stick of me can't be saved: child_limit\[1\]: nan can't stand here"):
        save_link(nan, library, "me", HASH)
    with pytest.raises(InputError, match="can't be saved: demonstrations_sha256: 'today'"):
        save_link(link, library, "me", "today")
    spec = replace(link.forward.spec, estimator=EstimatorSpec("polynomial", {"alphas": np.ones(2)}))
    with pytest.raises(InputError, match="its parameters must be plain values"):
        save_link(replace(link, forward=replace(link.forward, spec=spec)), library, "me", HASH)
    other = replace(link.inverses[0], model=replace(link.inverses[0].model, targets=(0,)))
    with pytest.raises(InputError, match="its inverse models have 2 sets of targets"):
        save_link(replace(link, inverses=(*link.inverses, other)), library, "me", HASH)
    with pytest.raises(InputError, match="hand->stick and b->c are between the same types of objects"):
        again = replace(link, interaction=replace(EDGE, parent="b", child="c"))
        save_chain(replace(CHAIN, links=(link, again)), library, "me", HASH)
    bad = LearnedCommand(None, np.zeros(2), np.zeros(2), np.array([0.0, np.inf]))
    with pytest.raises(InputError, match=r"command.hand_limit\[1\]: inf can't"):
        save_link(link, library, "me", HASH, bad)
    assert contents(library) == before


def test_a_full_folder_is_refused_and_the_earlier_link_stays(library: Path) -> None:
    before = contents(library)
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (3000, hard))  # writing beyond it fails, as on a full disk
    try:
        with pytest.raises(InputError, match=r"library: hand-joystick can't be written \(File too large\)") as caught:
            save_chain(CHAIN, library, "another", HASH)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert "\n" not in str(caught.value)
    assert contents(library) == before
    assert [entry.name for entry in library.iterdir()] == [LINK]


def test_a_read_only_folder_is_refused(library: Path) -> None:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        folder.chmod(0o555)
        root = os.geteuid() == 0
        if root:  # whom permissions don't stop
            os.seteuid(65534)
        try:
            with pytest.raises(InputError, match=r"hand-joystick can't be written \(Permission denied\)"):
                save_chain(CHAIN, folder, "a test", HASH)
            with pytest.raises(InputError, match=r"hand-joystick can't be written \(Permission denied\)"):
                save_chain(CHAIN, folder / "inner", "a test", HASH)
        finally:
            if root:
                os.seteuid(0)
        assert list(folder.iterdir()) == []
    (library / "file").write_text("")
    with pytest.raises(InputError, match=r"can't be written \(.*(File exists|Not a directory)"):
        save_chain(CHAIN, library / "file", "a test", HASH)


def test_only_a_saved_link_is_replaced(tmp_path: Path) -> None:
    (tmp_path / LINK).mkdir()
    (tmp_path / LINK / "notes.txt").write_text("mine")
    with pytest.raises(InputError, match="something that is no saved link is in its place"):
        save_chain(CHAIN, tmp_path, "a test", HASH)
    assert list(contents(tmp_path)) == [Path(LINK) / "notes.txt"]
    (tmp_path / LINK / "notes.txt").unlink()
    save_chain(CHAIN, tmp_path, "a test", HASH)
    assert check_library(tmp_path) == []


@pytest.mark.parametrize("kind", ["../../outside", "/etc", "..", "a b", "hand-x", "\N{SNOWMAN}", "a\0b"])
def test_types_never_lead_out_of_the_library(tmp_path: Path, kind: str) -> None:
    link, hand = CHAIN.links[0], replace(HAND, type=kind)
    forward = replace(link.forward, model=replace(link.forward.model, parent_space=hand))
    folder = save_link(replace(link, forward=forward), tmp_path / "a" / "b", "a test", HASH)
    assert folder.resolve().parent == (tmp_path / "a" / "b").resolve()
    assert [entry.name for entry in tmp_path.iterdir()] == ["a"]
    assert show_link(tmp_path / "a" / "b", folder.name).parent.startswith(f"{kind}: ")
    with pytest.raises(InputError, match="an object type is empty"):
        forward = replace(forward, model=replace(forward.model, parent_space=replace(HAND, type="")))
        save_link(replace(link, forward=forward), tmp_path, "a test", HASH)
