"""A person marks recordings in the browser: what is shown of them, and what becomes of the marks."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ichain_drake.demonstrations import Demonstration
from ichain_drake.demonstrations.columns import TIME, as_numbers, column
from ichain_drake.graph import InteractionGraph
from ichain_drake.learning.blocks import runs
from ichain_drake.learning.discovery.cuts import Pieces, cut_pieces
from ichain_drake.learning.discovery.labels import Labelled
from ichain_drake.learning.discovery.marks import Mark, check_marks, make_marks, write_marks
from ichain_drake.state import BoolArray
from ichain_drake.visualization.label_page import LabelPage

_DIGITS = 5  # of values on the page


class LabellingSession:
    """Serves the page until the person ends it.

    Args:
        logs: recordings, not yet cut, in the graph's units.
        graph: objects, and the interactions that may be marked.
        content: of the page, from `page_content`.
        marks: so far.
        file: where marks go.
        say: called with a line at each event.
        notice: what the person should know at first.
    """

    def __init__(
        self,
        logs: Sequence[Demonstration],
        graph: InteractionGraph,
        content: Mapping[str, Any],
        marks: Sequence[Mark],
        file: Path,
        say: Callable[[str], None],
        notice: str = "",
    ) -> None:
        self._logs, self._graph, self._file, self._say = logs, graph, file, say
        self.marks = list(marks)
        self._over = threading.Event()
        content = {**content, "title": f"Marks: {file.name}", "notice": notice}
        self._page = LabelPage(content, self._save, self._over.set)

    @property
    def address(self) -> str:
        """URL to open in a browser."""
        return self._page.address

    def run(self) -> list[Mark]:
        """Until the person ends it, or Ctrl-C.

        Returns:
            The marks as they were saved last.
        """
        try:
            while not self._over.wait(0.5):  # so that Ctrl-C is heard
                pass
        finally:
            self._page.close()
        return self.marks

    def _save(self, rows: list[dict[str, Any]]) -> str:
        marks = make_marks(rows, "mark")
        check_marks(marks, self._logs, self._graph)
        cut_pieces(self._logs, self._graph, marks=marks)  # refuses to join what can't be
        write_marks(marks, self._file)
        self.marks = marks
        done = f"{len(marks)} marks saved in {self._file}"
        self._say(done)
        return done


def page_content(
    logs: Sequence[Demonstration],
    graph: InteractionGraph,
    shown: Sequence[str],
    found: Pieces,
    labelled: Labelled | None,
    marks: Sequence[Mark],
) -> dict[str, Any]:
    """What the page shows of recordings; see `LabelPage`.

    Args:
        logs: the recordings.
        graph: objects, and the interactions that may be marked.
        shown: names of the interactions that the page has.
        found: the recordings as they were cut, with the marks so far.
        labelled: statuses that were inferred in the pieces; None where nothing was.
        marks: so far.
    """
    return {
        "interactions": list(shown),
        "logs": [_log(log, graph, shown, found, labelled) for log in logs],
        "marks": [
            {"piece": m.piece, "interaction": m.interaction, "from": m.first, "to": m.last, "active": m.active}
            | {"name": m.name}
            for m in marks
        ],
    }


def _log(
    log: Demonstration, graph: InteractionGraph, shown: Sequence[str], found: Pieces, labelled: Labelled | None
) -> dict[str, Any]:
    columns = []
    for obj, space in graph.objects.items():
        for variable in space.observable.variables if log.has(obj, space) else ():
            values = as_numbers(log.table[column(obj, variable.name)])
            unit = "" if variable.unit == "1" else f" [{variable.unit}]"
            columns.append(
                {
                    "label": f"{obj}.{variable.name}{unit}",
                    "low": _number(values.min()),
                    "high": _number(values.max()),
                    "values": [_number(v) for v in values],
                }
            )
    statuses = _statuses(log, shown, found, labelled)
    return {
        "name": log.name,
        "times": [round(float(t), 4) for t in as_numbers(log.table[TIME])],
        "columns": columns,
        "on": {edge: _stretches(on) for edge, (on, _) in statuses.items()},
        "open": {edge: _stretches(nothing) for edge, (_, nothing) in statuses.items()},
        "cuts": [
            {"row": c.row, "why": c.why, "sure": round(c.sure, 4), "fixed": c.fixed}
            for c in found.cuts
            if c.log == log.name
        ],
    }


def _statuses(
    log: Demonstration, shown: Sequence[str], found: Pieces, labelled: Labelled | None
) -> Mapping[str, tuple[BoolArray, BoolArray]]:
    """Per interaction whether it is active, and whether that is open, in the rows of a recording."""
    out = {name: (np.zeros(len(log), bool), np.zeros(len(log), bool)) for name in shown}
    pieces = () if labelled is None else labelled.pieces
    for piece, (whose, first) in zip(pieces, found.begins, strict=False):
        if whose != log.name:
            continue
        rows = slice(first, first + len(piece))
        for name, (on, nothing) in out.items():
            if name in piece.table:
                on[rows] = as_numbers(piece.table[name]) > 0.5  # noqa: PLR2004 - a flag
            if name in piece.open:
                nothing[rows] = piece.open[name]
    return out


def _stretches(rows: BoolArray) -> list[list[int]]:
    return [[a, b - 1] for a, b in runs(rows)]


def _number(value: float) -> float:
    return float(f"{value:.{_DIGITS}g}")
