"""Nothing in a library is ever run, and no name in it leads elsewhere."""

import io
import json
import os
import pickle
import shutil
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from linked_library import EDGE, GRAPH, LINK, forge, refused

from ichain_drake.errors import InputError
from ichain_drake.learning.library import (
    add_to_library,
    check_library,
    list_library,
    load_link,
    show_link,
)


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
