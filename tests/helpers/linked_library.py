"""A saved library with one small link, and how tests forge it and expect it refused."""

import hashlib
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from ichain_drake.demonstrations import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.learning.chain.chain import LearnedChain, LinkCandidates, learn_chain
from ichain_drake.learning.chain.link import EstimatorSpec
from ichain_drake.learning.library import (
    add_to_library,
    check_library,
    load_links,
)
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
