"""Where the boxes and arrows of a small interaction graph go, so that no arrow runs through a foreign box."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from ichain_drake.graph import Interaction

FloatArray = NDArray[np.float64]

_LETTER, _PADDING, _HEIGHT = 6.6, 16.0, 22.0  # of a box, at a font of 12 px [px]
_COLUMN_GAP, _ROW_GAP = 20.0, 38.0
_ARROW_GAP = 34.0  # between the boxes of a chain, which lie side by side
_PAIR_BEND = 11.0  # keeps the two arrows between the same boxes apart
_BENDS = tuple(sign * size for size in range(0, 241, 12) for sign in (1.0, -1.0))
_CLEARANCE = 4.0  # of an arrow from a box that is not its own
_TIP = 2.0  # an arrow ends so far from its box
_MARGIN = 3.0


@dataclass(frozen=True)
class GraphLayout:
    """A drawing of an interaction graph, in pixels, y down.

    Attributes:
        width, height: of the drawing.
        boxes: middle, width and height of each object's box, shape (4,).
        curves: start, control and end point of each interaction's quadratic curve, shape (3, 2).
    """

    width: float
    height: float
    boxes: Mapping[str, FloatArray]
    curves: Mapping[Interaction, FloatArray]

    def points(self, edge: Interaction, count: int = 24) -> FloatArray:
        """Points on an interaction's curve, shape (count, 2)."""
        return _curve(self.curves[edge], count)


def layout_graph(objects: Sequence[str], interactions: Sequence[Interaction]) -> GraphLayout:
    """Lay out a graph: objects in rows by their distance from the robot; a chain in one line.

    Args:
        objects: names in the order they are shown.
        interactions: the edges; objects that none leads to from the first row's come last.
    """
    boxes = _boxes(_rows(objects, interactions))
    curves = {e: _route(e, boxes, Interaction(e.child, e.parent) in interactions) for e in interactions}
    corners = [_curve(c) for c in curves.values()]
    corners += [b[:2] + b[2:] * np.array([[-0.5, -0.5], [0.5, 0.5]]) for b in boxes.values()]
    low, high = np.vstack(corners).min(axis=0) - _MARGIN, np.vstack(corners).max(axis=0) + _MARGIN
    width, height = high - low
    shift = np.concatenate([low, np.zeros(2)])
    return GraphLayout(
        float(width), float(height), {n: b - shift for n, b in boxes.items()}, {e: c - low for e, c in curves.items()}
    )


def _rows(objects: Sequence[str], interactions: Sequence[Interaction]) -> list[list[str]]:
    graph = nx.DiGraph()
    graph.add_nodes_from(objects)
    graph.add_edges_from((e.parent, e.child) for e in interactions)
    roots = [n for n in objects if graph.in_degree(n) == 0] or list(objects[:1])
    depth = {
        n: min(nx.multi_source_dijkstra_path_length(graph, set(roots)).get(n, len(objects)), 10**6) for n in objects
    }
    return [[n for n in objects if depth[n] == d] for d in sorted(set(depth.values()))]


def _boxes(rows: list[list[str]]) -> dict[str, FloatArray]:
    boxes: dict[str, FloatArray] = {}
    widths = {n: _LETTER * len(n) + _PADDING for row in rows for n in row}
    if all(len(row) == 1 for row in rows):
        x = 0.0
        for (name,) in rows:
            boxes[name] = np.array([x + widths[name] / 2, 0.0, widths[name], _HEIGHT])
            x += widths[name] + _ARROW_GAP
        return boxes
    for k, row in enumerate(rows):
        x = -(sum(widths[n] for n in row) + _COLUMN_GAP * (len(row) - 1)) / 2
        for name in row:
            boxes[name] = np.array([x + widths[name] / 2, k * (_HEIGHT + _ROW_GAP), widths[name], _HEIGHT])
            x += widths[name] + _COLUMN_GAP
    return boxes


def _route(edge: Interaction, boxes: Mapping[str, FloatArray], paired: bool) -> FloatArray:
    """The least bent curve that stays clear of the boxes of others."""
    a, b = boxes[edge.parent], boxes[edge.child]
    along = b[:2] - a[:2]
    normal = np.array([-along[1], along[0]]) / np.linalg.norm(along)
    others = [box for name, box in boxes.items() if name not in (edge.parent, edge.child)]
    curves = []
    for bend in _BENDS:
        if paired and (bend < 0 or np.signbit(bend)):  # the way back bends to its own side
            continue
        size = bend + _PAIR_BEND if paired else bend
        middle = (a[:2] + b[:2]) / 2 + size * normal
        curves.append(np.array([_border(a, middle, 0.0), middle, _border(b, middle, _TIP)]))
        if not any(_inside(_curve(curves[-1]), box) for box in others):
            return curves[-1]
    return curves[0]


def _border(box: FloatArray, toward: FloatArray, gap: float) -> FloatArray:
    """Where the line from a box's middle toward a point leaves the box, a gap farther."""
    direction = toward - box[:2]
    half = box[2:] / 2 + gap
    with np.errstate(divide="ignore"):
        return np.asarray(box[:2] + direction * np.min(half / np.abs(direction)))


def _curve(points: FloatArray, count: int = 24) -> FloatArray:
    t = np.linspace(0, 1, count)[:, None]
    return np.asarray((1 - t) ** 2 * points[0] + 2 * t * (1 - t) * points[1] + t**2 * points[2])


def _inside(points: FloatArray, box: FloatArray) -> bool:
    return bool(np.any(np.all(np.abs(points - box[:2]) < box[2:] / 2 + _CLEARANCE, axis=1)))
