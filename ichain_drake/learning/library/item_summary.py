"""What a library's list shows of a saved link as of a saved graph."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ichain_drake.learning.library.saved_item import SavedItem


@dataclass(frozen=True)
class ItemSummary:
    """What the list shows of either.

    Attributes:
        name: of its folder.
        source: the scenario that it was learned in.
        robot_seconds: simulated time that recording its demonstrations took of the robot [s].
        versions: of what it was learned with.
        demonstrations_sha256: hash of the demonstrations.
        size: of all its files [bytes].
    """

    name: str
    source: str
    robot_seconds: float
    versions: Mapping[str, str]
    demonstrations_sha256: str
    size: int


def common(saved: SavedItem, source: str) -> dict[str, Any]:
    """The fields of an `ItemSummary`.

    Args:
        saved: a link or graph.
        source: the scenario that it was learned in.
    """
    fields = saved.manifest
    return {
        "name": saved.folder.name,
        "source": source,
        "robot_seconds": fields["robot_seconds"],
        "versions": fields["versions"],
        "demonstrations_sha256": fields["demonstrations_sha256"],
        "size": saved.size,
    }


def space_words(space: Mapping[str, Any]) -> str:
    """A state space of a manifest in words, such as `hand: x [m], y [m]`.

    Args:
        space: its fields.
    """
    return f"{space['type']}: " + ", ".join(f"{v['name']} [{v['unit']}]" for v in space["variables"])
