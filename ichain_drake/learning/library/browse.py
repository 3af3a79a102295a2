"""Looking into an interaction library: what it holds, and whether all of it can be used."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ichain_drake.errors import InputError
from ichain_drake.learning.library.files import is_graph_name, library_entries, link_folder, link_folders
from ichain_drake.learning.library.saved import SavedLink
from ichain_drake.learning.library.saved_graph import SavedGraph


@dataclass(frozen=True)
class LinkSummary:
    """What a library's list shows of a link.

    Attributes:
        name: of the link: `<parent type>-<child type>`.
        parent, child: their variables with units, such as `hand: x [m], y [m]`.
        interaction, source: the interaction's name where it was learned, and the scenario.
        targets: the child's variables that its inverse models bring about.
        positions: what the parent's positions are relative to.
        forward, inverses: estimators with features, action and aim.
        forward_score, inverse_score: cross-validated coefficient of determination; of the inverses the best.
        samples: transitions that the forward model was fitted to.
        robot_seconds: simulated time that recording them took of the robot [s].
        versions: of what it was learned with.
        demonstrations_sha256: hash of the demonstrations.
        size: of all its files [bytes].
    """

    name: str
    parent: str
    child: str
    interaction: str
    source: str
    targets: tuple[str, ...]
    positions: str
    forward: str
    inverses: tuple[str, ...]
    forward_score: float
    inverse_score: float
    samples: int
    robot_seconds: float
    versions: Mapping[str, str]
    demonstrations_sha256: str
    size: int


def show_link(library: Path, name: str) -> LinkSummary:
    """One link of a library by name.

    Raises:
        InputError: on a name that is none or unknown, or a link that is damaged.
    """
    return _summary(SavedLink.read(link_folder(library, name)))


def list_library(folder: Path) -> list[LinkSummary]:
    """All links of a library, by name.

    Raises:
        InputError: if there is no such folder, or anything in it is damaged or foreign (`check_library` tells all).
    """
    return [_summary(SavedLink.read(link)) for link in link_folders(folder)]


def check_library(folder: Path) -> list[str]:
    """Problems of a library, one line each; empty if every link and graph can be loaded and nothing else is in it.

    Raises:
        InputError: if there is no such folder, or it is a single link.
    """
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
    parent, child = (
        f"{fields[end]['type']}: " + ", ".join(f"{v['name']} [{v['unit']}]" for v in fields[end]["variables"])
        for end in ("parent", "child")
    )
    forward, inverses = fields["forward"], fields["inverses"]
    return LinkSummary(
        saved.folder.name,
        parent,
        child,
        fields["interaction"],
        fields["source"],
        tuple(fields["targets"]),
        _positions(fields),
        f"{forward['estimator']}, features {forward['features']}, action {forward['action']}",
        tuple(f"{i['estimator']}, features {i['features']}, aim {i['aim']}, action {i['action']}" for i in inverses),
        forward["score"],
        max((i["score"] for i in inverses), default=float("nan")),
        forward["samples"],
        fields["robot_seconds"],
        fields["versions"],
        fields["demonstrations_sha256"],
        sum(len(data) for data in saved.files.values()),
    )


def _positions(fields: Mapping[str, Any]) -> str:
    origin = fields["origin"]
    if origin is None:
        return "as they come"
    place = ", ".join(f"{v:g}" for v in origin["position"])
    return f"relative to the {fields['child']['type']}'s declared origin in frame {origin['frame']!r}, then at {place}"
