"""Cycles of interactions: a graph may have them, but no cycle may be active as a whole (paper sec. V)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from ichain_drake.errors import ActiveCycleError
from ichain_drake.graph import Interaction, InteractionGraph

Ring = list[Interaction]


def rings_of(graph: InteractionGraph) -> list[Ring]:
    """Every cycle of a graph, as the interactions along it."""
    rings = nx.simple_cycles(graph.digraph)
    return [[Interaction(a, b) for a, b in zip(ring, [*ring[1:], ring[0]], strict=True)] for ring in rings]


def sweeps_of(
    graph: InteractionGraph, incoming: Mapping[str, Sequence[Interaction]], order: Sequence[Interaction]
) -> dict[tuple[str, ...], tuple[str, ...]]:
    """In which order the members of each cycle are advanced: those nearest to a robot first.

    Args:
        graph: the interaction graph.
        incoming: interactions that act on each object, in canonical order.
        order: all interactions in canonical order, which decides between equals.
    """
    far = nx.multi_source_dijkstra_path_length(graph.digraph, set(graph.roots))
    place = {e: k for k, e in enumerate(order)}
    return {
        members: tuple(sorted(members, key=lambda n: (far[n], place[incoming[n][0]])))
        for members in graph.components
        if len(members) > 1
    }


def refuse_active(rings: Sequence[Ring], on: Mapping[Interaction, NDArray[np.bool_]], time: float | None) -> None:
    """Refuse a cycle of interactions that are active at the same time.

    Args:
        rings: all cycles; those of which `on` says nothing are left out.
        on: status of interactions, shape (n,).
        time: named in the error [s].

    Raises:
        ActiveCycleError: names the interactions.
    """
    for ring in rings:
        if ring[0] not in on:
            continue
        rows = np.flatnonzero(np.all([on[e] for e in ring], axis=0))
        if len(rows):
            when = "" if time is None else f" at t = {time:.3f} s"
            where = "" if len(on[ring[0]]) == 1 else f" in row {rows[0]}"
            names = ", ".join(e.name for e in ring)
            raise ActiveCycleError(f"active interactions form a cycle{when}{where}: {names}; deactivate one of them")
