"""Demonstrations without flags, or without a graph: both are found out of the states before anything is learned."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from ichain_drake.demonstrations import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.learning.discovery.edges import discover_graph
from ichain_drake.learning.discovery.graph_file import read_edges
from ichain_drake.learning.discovery.labels import Labelled, flagged, label_pieces, raw_piece
from ichain_drake.scenarios.base import Progress


@dataclass(frozen=True)
class Taught:
    """What demonstrations say beside states.

    Attributes:
        unlabelled: whether flags are inferred where they are missing.
        no_graph: whether the graph's edges, and all flags, are found out of states.
        graph_file: edges in place of the scenario's.
    """

    unlabelled: bool = False
    no_graph: bool = False
    graph_file: Path | None = None

    def __post_init__(self) -> None:
        if self.no_graph and self.graph_file is not None:
            raise InputError("--graph and --no-graph: give one of the two")
        if self.no_graph and not self.unlabelled:
            raise InputError("--no-graph is for --unlabelled: flags say which interactions there are")

    def graph(self, graph: InteractionGraph) -> InteractionGraph:
        """The graph to learn, before what is found out of states.

        Raises:
            InputError: on a file that can't be read.
        """
        return graph if self.graph_file is None else read_edges(self.graph_file, graph)

    def labelled(
        self, pieces: Sequence[Demonstration], graph: InteractionGraph, say: Progress, *, recorded: bool = False
    ) -> Labelled:
        """Pieces with flags, and the graph that they are of.

        Args:
            pieces: as read or recorded.
            graph: to learn.
            say: called with a line at each step.
            recorded: whether they come with true flags, which are thrown away.

        Raises:
            InputError: as `label_pieces` and `discover_graph`.
        """
        if recorded or self.no_graph:
            pieces = [without_flags(p) for p in pieces]
        if not self.no_graph:
            labels = label_pieces(pieces, graph, say=say)
        else:
            spaces = {n: s.observable for n, s in graph.objects.items()}
            root = graph.only_root("finding edges")
            found = discover_graph([raw_piece(p, graph) for p in pieces], spaces, root, say=say)
            lost = [*found.still, *found.free]
            if lost:
                raise InputError(
                    f"{lost[0]}: the pieces don't show that anything acts on it; record pieces in which it does, or "
                    "give the graph's edges with --graph"
                )
            edges = InteractionGraph(graph.objects, [f.edge for f in found.found], graph.origins)
            labels = flagged(pieces, edges, found.found)
        for line in labels.lines():
            say(line)
        return labels


def without_flags(piece: Demonstration) -> Demonstration:
    """A piece's states alone."""
    flags = [c for c in piece.table.columns if "->" in str(c)]
    return replace(piece, table=piece.table.drop(columns=flags), open={})
