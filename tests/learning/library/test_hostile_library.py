"""Libraries forged by chance under checksums that are right: refused in one line, or loaded and usable."""

from __future__ import annotations

import json
import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import linked_library
import numpy as np
import pytest
import small_world
from damage import altered
from hostile import MANY, survives, tried
from linked_library import CHAIN, HASH, LINK, forge

from ichain_drake.learning import InteractionModel
from ichain_drake.learning.library import load_graph, load_links, save_chain, save_graph
from ichain_drake.learning.library.files import sha256
from ichain_drake.learning.library.manifest import write_manifest
from ichain_drake.learning.library.saved_graph import GRAPH as FORM
from ichain_drake.learning.library.weights import pack_arrays, unpack_arrays

NAMES = ("is", "polynomial", "box", "hand", "hand->box", "real", "x", "m", "forward", "none", "next")
ODD = (0.0, -1.0, np.nan, np.inf, 1e300, -1e-300, 1e9)


def forged(rng: random.Random, arrays: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Arrays of which one is another."""
    name = rng.choice(list(arrays))
    a = np.array(arrays[name])
    how = rng.randrange(5)
    if how == 0:
        return {n: v for n, v in arrays.items() if n != name}
    if how == 1:
        a = a.reshape(-1)[: rng.randint(0, a.size)]
    elif how == 2:  # noqa: PLR2004
        a = a.astype(rng.choice([np.float32, np.int64, np.complex128, np.bool_]))
    elif a.size and a.dtype.kind == "f":
        a.reshape(-1)[rng.randrange(a.size)] = rng.choice(ODD)
    else:
        a = np.stack([a, a])
    return {**arrays, name: a}


def used(model: InteractionModel) -> None:
    """One step of what was loaded; numbers may be absurd, an error may not."""
    states = {n: np.zeros((2, len(s))) for n, s in small_world.GRAPH.objects.items()}
    with np.errstate(all="ignore"):
        model.step(states, states["hand"] + 0.01, strict=False)


@pytest.fixture
def graphs(model: InteractionModel, tmp_path: Path) -> Callable[[random.Random, Path], None]:
    folder = save_graph(model, tmp_path, "job")
    about = json.loads((folder / "manifest.json").read_text())
    fields = {k: v for k, v in about.items() if k not in ("format", "checksums")}
    content = (folder / "model.npz").read_bytes()
    arrays = unpack_arrays(content, "model.npz")

    def graphs(rng: random.Random, place: Path) -> None:
        tree, data = json.loads(json.dumps(fields)), content
        if rng.random() < 0.7:  # noqa: PLR2004
            altered(rng, tree["model"] if rng.random() < 0.8 else tree, *NAMES)  # noqa: PLR2004
        else:
            data = pack_arrays(forged(rng, arrays))
        (folder / "model.npz").write_bytes(data)
        document: dict[str, Any] = {**tree, "files": {"model.npz": sha256(data)}}
        try:
            (folder / "manifest.json").write_bytes(write_manifest(document, "forged", FORM))
        except Exception:  # what can't even be written
            return
        found: list[InteractionModel | None] = []
        tried(lambda: found.append(load_graph(place, "job", small_world.GRAPH)))
        if found and found[0] is not None:
            tried(lambda: used(found[0]))  # type: ignore[arg-type]

    return graphs


@pytest.fixture
def links(tmp_path: Path) -> Callable[[random.Random, Path], None]:
    save_chain(CHAIN, tmp_path, "a test", HASH)
    folder = tmp_path / LINK
    whole = {f.name: f.read_bytes() for f in folder.iterdir()}

    def links(rng: random.Random, place: Path) -> None:
        for name, data in whole.items():
            (folder / name).write_bytes(data)
        file = rng.choice([f for f in whole if f.endswith(".npz")])
        if rng.random() < 0.3:  # noqa: PLR2004
            np.savez(folder / file, **forged(rng, dict(np.load(folder / file))))  # type: ignore[arg-type]
            forge(folder)
        else:
            forge(folder, lambda manifest: altered(rng, manifest, *NAMES))
        tried(lambda: load_links(place, linked_library.GRAPH, ("hand", "stick"), ("a", "b")))

    return links


@pytest.mark.parametrize("kind", ["graphs", "links"])
def test_nothing_but_a_result_or_one_line(kind: str, request: pytest.FixtureRequest, tmp_path: Path) -> None:
    survives(request.getfixturevalue(kind), tmp_path, MANY // 10 if kind == "graphs" else MANY)  # those are large
