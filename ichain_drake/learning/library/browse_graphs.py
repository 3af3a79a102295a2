"""Looking at the whole graphs of an interaction library."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from ichain_drake.learning.library.files import is_graph_name, item_folders, link_folder
from ichain_drake.learning.library.saved_graph import SavedGraph


@dataclass(frozen=True)
class GraphSummary:
    """What a library's list shows of a graph.

    Attributes:
        name: of its folder: `graph.<source>`.
        source: the scenario that it was learned in.
        objects: their variables with units, such as `hand: x [m], y [m]`, by name.
        interactions: F1 of the status, of its switching events and on left-out blocks, and by variable of the child
            the share of its change that an effect explains; by interaction.
        score: mean F1 of the status over all interactions.
        samples: rows that each was learned from.
        robot_seconds: simulated time that recording them took of the robot [s].
        versions: of what it was learned with.
        demonstrations_sha256: hash of the demonstrations.
        size: of all its files [bytes].
    """

    name: str
    source: str
    objects: Mapping[str, str]
    interactions: Mapping[str, str]
    score: float
    samples: int
    robot_seconds: float
    versions: Mapping[str, str]
    demonstrations_sha256: str
    size: int


def show_graph(library: Path, name: str) -> GraphSummary:
    """One graph of a library by the name of its folder.

    Raises:
        InputError: on a name that is none or unknown, or a graph that is damaged.
    """
    return _summary(SavedGraph.read(link_folder(library, name)))


def list_graphs(folder: Path) -> list[GraphSummary]:
    """All graphs of a library, by name.

    Raises:
        InputError: if there is no such folder, or anything in it is damaged or foreign (`check_library` tells all).
    """
    return [_summary(SavedGraph.read(found)) for found in item_folders(folder) if is_graph_name(found.name)]


def _summary(saved: SavedGraph) -> GraphSummary:
    fields = saved.manifest
    edges = fields["interactions"].values()
    return GraphSummary(
        saved.folder.name,
        fields["graph"],
        {
            name: f"{space['type']}: " + ", ".join(f"{v['name']} [{v['unit']}]" for v in space["variables"])
            for name, space in fields["objects"].items()
        },
        {
            name: f"f1 {e['f1']:.4f}, events {e['event_f1']:.4f}, blocks {e['block_score']:.4f}; "
            + (", ".join(f"{v} {score:.4f}" for v, score in e["effects"].items()) or "no effects")
            for name, e in fields["interactions"].items()
        },
        sum(e["f1"] for e in edges) / max(1, len(edges)),
        max((e["samples"] for e in edges), default=0),
        fields["robot_seconds"],
        fields["versions"],
        fields["demonstrations_sha256"],
        sum(len(data) for data in saved.files.values()),
    )
