"""As many demonstrations as learning looks at: all of them, but for logs of many hours."""

from __future__ import annotations

from collections.abc import Sequence

from ichain_drake.demonstrations import Demonstration
from ichain_drake.demonstrations.thinning import Bound, thinned
from ichain_drake.graph import InteractionGraph
from ichain_drake.learning.settings import LEARNING


def enough(pieces: Sequence[Demonstration], graph: InteractionGraph) -> list[Demonstration]:
    """The pieces, or stretches of them with `LEARNING.most_learned` rows in all.

    Which stretches these are depends on the order of the pieces, and nothing else.

    Args:
        pieces: demonstrations.
        graph: whose interactions are learned.
    """
    return thinned(pieces, graph, learned_bound())


def learned_bound() -> Bound:
    """How many rows are learned from at most."""
    return Bound(LEARNING.most_learned, LEARNING.examples)


def thinning_told(given: Sequence[Demonstration], used: Sequence[Demonstration]) -> list[str]:
    """A line that says so if not all rows are learned from.

    Args:
        given: all pieces.
        used: what `enough` kept of them.
    """
    rows, kept = sum(map(len, given)), sum(map(len, used))
    if kept == rows:
        return []
    return [
        f"{kept} of {rows} rows are learned from: stretches that show every change of status, and evenly of the rest "
        f"(at most {LEARNING.most_learned}: learning.settings, most_learned)"
    ]
