"""Looking into an interaction library: what it holds, and whether all of it can be used."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ichain_drake.errors import InputError
from ichain_drake.learning.library.files import is_graph_name, library_entries, link_folder, link_folders
from ichain_drake.learning.library.item_summary import ItemSummary, common, space_words
from ichain_drake.learning.library.saved import SavedLink
from ichain_drake.learning.library.saved_graph import SavedGraph


@dataclass(frozen=True)
class LinkSummary(ItemSummary):
    """What a library's list shows of a link, `<parent type>-<child type>`; see also `ItemSummary`.

    Attributes:
        parent, child: their variables with units, such as `hand: x [m], y [m]`.
        interaction: its name where it was learned.
        targets: the child's variables that its inverse models bring about.
        positions: what the parent's positions are relative to.
        forward, inverses: estimators with features, action and aim.
        forward_score, inverse_score: cross-validated coefficient of determination; of the inverses the best.
        samples: transitions that the forward model was fitted to.
    """

    parent: str
    child: str
    interaction: str
    targets: tuple[str, ...]
    positions: str
    forward: str
    inverses: tuple[str, ...]
    forward_score: float
    inverse_score: float
    samples: int


def show_link(library: Path, name: str) -> LinkSummary:
    """One link of a library by name.

    Raises:
        InputError: on a name that is none or unknown, or a link that is damaged.
    """
    return _summary(SavedLink.read(link_folder(library, name)))


def list_library(folder: str | Path) -> list[LinkSummary]:
    """All links of a library, by name.

    Raises:
        InputError: if there is no such folder, or anything in it is damaged or foreign (`check_library` tells all).
    """
    folder = Path(folder)
    return [_summary(SavedLink.read(link)) for link in link_folders(folder)]


def check_library(folder: str | Path) -> list[str]:
    """Problems of a library, one line each; empty if every link and graph can be loaded and nothing else is in it.

    Raises:
        InputError: if there is no such folder, or it is a single link.
    """
    folder = Path(folder)
    entries, problems = library_entries(folder)
    for entry in entries:
        try:
            kind: type[SavedGraph] | type[SavedLink] = SavedGraph if is_graph_name(entry.name) else SavedLink
            kind.read(entry).verify()
        except InputError as error:
            problems.append(str(error))
    return problems


def _summary(saved: SavedLink) -> LinkSummary:
    fields = saved.manifest
    forward, inverses = fields["forward"], fields["inverses"]
    return LinkSummary(
        **common(saved, fields["source"]),
        parent=space_words(fields["parent"]),
        child=space_words(fields["child"]),
        interaction=fields["interaction"],
        targets=tuple(fields["targets"]),
        positions=_positions(fields),
        forward=f"{forward['estimator']}, features {forward['features']}, action {forward['action']}",
        inverses=tuple(
            f"{i['estimator']}, features {i['features']}, aim {i['aim']}, action {i['action']}" for i in inverses
        ),
        forward_score=forward["score"],
        inverse_score=max((i["score"] for i in inverses), default=float("nan")),
        samples=forward["samples"],
    )


def _positions(fields: Mapping[str, Any]) -> str:
    origin = fields["origin"]
    if origin is None:
        return "as they come"
    place = ", ".join(f"{v:g}" for v in origin["position"])
    return f"relative to the {fields['child']['type']}'s declared origin in frame {origin['frame']!r}, then at {place}"
