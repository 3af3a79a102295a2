"""Saving what was learned about a whole interaction graph into a library, and loading it for the graph at hand."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.blas import one_blas_thread
from ichain_drake.learning.frozen.model import Array
from ichain_drake.learning.known import KnownParts
from ichain_drake.learning.library.encoding import encode
from ichain_drake.learning.library.files import MANIFEST, graph_name, item_folders, sha256, write_files
from ichain_drake.learning.library.fit import check_graph
from ichain_drake.learning.library.manifest import TIME_CONVENTION, space_fields, write_manifest
from ichain_drake.learning.library.parts import load_parts
from ichain_drake.learning.library.save import current_versions
from ichain_drake.learning.library.saved_graph import GRAPH, WEIGHTS, Contents, SavedGraph
from ichain_drake.learning.library.weights import pack_arrays
from ichain_drake.learning.model import InteractionModel
from ichain_drake.timing import TICK


def save_graph(model: InteractionModel, library: Path, name: str) -> Path:
    """Save a learned graph in a folder of its own, `graph.<name>`, in place of an earlier one of that name.

    Args:
        model: what was learned.
        library: the library's folder; made where it doesn't exist.
        name: by which it will be loaded, such as the scenario's.

    Returns:
        The graph's folder.

    Raises:
        InputError: if something in it can't be saved (a number that is not finite, a bad hash), or the library can't
            be written; an earlier graph is kept then.
    """
    arrays = dict[str, Array]()
    contents = Contents(
        edges=model.edges,
        passive={n: p.variables for n, p in model.passive.items()},
        low=model.low,
        high=model.high,
        step_limit=model.step_limit,
        order=model.order,
        noise=model.noise,
        pieces=model.pieces,
        findings=model.findings,
        activations=dict(model.activations),
        deactivations=dict(model.deactivations),
    )
    tree = encode(contents, "model", arrays)
    files = {WEIGHTS: pack_arrays(arrays)}
    fields = {
        "graph": name,
        "period": TICK,
        "time": TIME_CONVENTION,
        "objects": {n: space_fields(space) for n, space in model.graph.objects.items()},
        "interactions": {e.name: _scores(model, e) for e in model.graph.interactions},
        "model": tree,
        "robot_seconds": float(model.robot_seconds),
        "versions": current_versions(),
        "demonstrations_sha256": model.demonstrations_sha256,
        "files": {file: sha256(data) for file, data in files.items()},
    }
    manifest = write_manifest(fields, f"graph {name}", GRAPH)
    return write_files(library, graph_name(name), {MANIFEST: manifest} | files)


def load_graph(library: Path, name: str, graph: InteractionGraph) -> InteractionModel | None:
    """Load what a library knows about a graph. Versions of Python, Drake and scikit-learn don't matter.

    Args:
        library: the library's folder.
        name: that it was saved by.
        graph: the graph at hand: its objects must have the names, variables, units, kinds and roles of the saved one.

    Returns:
        The model; None where the library has no graph of that name.

    Raises:
        InputError: if there is no such library, it holds what is no part of one, or the graph in it is damaged,
            edited, of a newer format or doesn't fit: names the file, the field or the variable that differs.
    """
    folder = library / graph_name(name)
    if folder.name not in {found.name for found in item_folders(library)}:
        return None
    with one_blas_thread():  # the trial evaluations, as everywhere
        return SavedGraph.read(folder).known(graph)


def load_fitting(
    library: Path, name: str, graph: InteractionGraph, *, lift: bool = False
) -> InteractionModel | KnownParts:
    """Load all that a library's graphs know about the graph at hand.

    Args:
        library: the library's folder.
        name: by which the graph at hand is saved.
        graph: the graph at hand.
        lift: see `load_parts`.

    Returns:
        The saved graph of that name if it fits as a whole; otherwise every interaction that fits; see `load_parts`.

    Raises:
        InputError: as `load_parts`; and if the graph of that name has no interaction that fits: names the field or
            variable that differs.
    """
    folder = library / graph_name(name)
    if folder.name not in {found.name for found in item_folders(library)}:
        return load_parts(library, name, graph, lift=lift)
    with one_blas_thread():
        saved = SavedGraph.read(folder)
        try:
            check_graph(saved.manifest, saved.graph(), graph, str(folder))
        except InputError as error:
            parts = load_parts(library, name, graph, lift=lift)
            if len(parts.elsewhere) == len(parts.edges):
                raise error from None
            return parts
        return saved.known(graph)


def _scores(model: InteractionModel, edge: Interaction) -> dict[str, Any]:
    """What the manifest says about an interaction, for people."""
    learned = model.edges[edge]
    names = model.graph.objects[edge.child].observable.names
    return {
        "samples": int(learned.status.samples),
        "f1": float(learned.status.score),
        "event_f1": float(learned.status.event_score),
        "calibration_error": float(learned.status.calibration_error),
        "effects": {names[e.variable]: float(e.regression.explained) for e in learned.effects},
    }
