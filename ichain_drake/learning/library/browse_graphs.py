"""Looking at the whole graphs of an interaction library."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from ichain_drake.learning.library.files import is_graph_name, item_folders, link_folder
from ichain_drake.learning.library.item_summary import ItemSummary, common, space_words
from ichain_drake.learning.library.saved_graph import SavedGraph


@dataclass(frozen=True)
class GraphSummary(ItemSummary):
    """What a library's list shows of a graph, `graph.<source>`; see also `ItemSummary`.

    Attributes:
        objects: their variables with units, such as `hand: x [m], y [m]`, by name.
        interactions: F1 of the status, of its switching events and its calibration error, and by variable of the child
            the share of its change that an effect explains; by interaction.
        score: mean F1 of the status over all interactions.
        samples: rows that each was learned from.
    """

    objects: Mapping[str, str]
    interactions: Mapping[str, str]
    score: float
    samples: int


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
        **common(saved, fields["graph"]),
        objects={name: space_words(space) for name, space in fields["objects"].items()},
        interactions={
            name: f"f1 {e['f1']:.4f}, events {e['event_f1']:.4f}, calibration {e['calibration_error']:.4f}; "
            + (", ".join(f"{v} {score:.4f}" for v, score in e["effects"].items()) or "no effects")
            for name, e in fields["interactions"].items()
        },
        score=sum(e["f1"] for e in edges) / max(1, len(edges)),
        samples=max((e["samples"] for e in edges), default=0),
    )
