"""How far a search for a plan goes."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class SearchSettings:
    """How far a search goes.

    Attributes:
        width: states that are expanded at a time.
        steps: of a plan at most.
        expansions: states that are expanded at most.
        optimal: whether a plan of least expected time is sought, below the one that is found so; takes long.
        most: states that are expanded at most for that.
    """

    width: int = 48
    steps: int = 24
    expansions: int = 240
    optimal: bool = False
    most: int = 20_000
