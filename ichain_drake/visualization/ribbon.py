"""Lines as flat ribbons of triangles: WebGL draws plain lines one pixel wide, whatever width is asked for."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ichain_drake.errors import InputError

FloatArray = NDArray[np.float64]


def spaced(points: ArrayLike, spacing: float) -> NDArray[np.intp]:
    """Which points to keep so that neighbours are at least so far apart; the first is always kept.

    A ribbon through points closer than it is wide would fold.

    Args:
        points: shape (n, 3) [m].
        spacing: least distance [m].

    Returns:
        indices, shape (k,).
    """
    value = np.asarray(points, dtype=float)
    kept = [0] if len(value) else []
    for i in range(1, len(value)):
        if np.linalg.norm(value[i] - value[kept[-1]]) >= spacing:
            kept.append(i)
    return np.array(kept, dtype=np.intp)


def ribbon(points: ArrayLike, width: float, normal: ArrayLike) -> tuple[FloatArray, NDArray[np.intp]]:
    """Triangles of a flat line; those of the k-th segment come k-th, so that a line can grow by drawing more of them.

    Args:
        points: shape (n, 3) [m], n >= 2, neighbours distinct.
        width: of the line [m].
        normal: direction that the ribbon faces, shape (3,).

    Returns:
        vertices, shape (3, 2 n) [m], and vertex indices of the triangles, shape (3, 2 (n - 1)), as Drake's
        `SetTriangleMesh` takes them.

    Raises:
        InputError: if the shape is another.
    """
    p = np.asarray(points, dtype=float)
    if p.ndim != 2 or p.shape[1:] != (3,) or len(p) < 2:
        raise InputError(f"line: points of shape (n, 3) with n >= 2 needed; shape {p.shape} given")
    segments = np.diff(p, axis=0)
    segments /= np.maximum(np.linalg.norm(segments, axis=1, keepdims=True), 1e-12)
    tangents = np.vstack([segments[:1], segments[:-1] + segments[1:], segments[-1:]])
    side = np.cross(np.asarray(normal, dtype=float), tangents)
    side /= np.maximum(np.linalg.norm(side, axis=1, keepdims=True), 1e-12)
    # At a bend the corner lies further out; limited, as a hairpin's would lie at infinity.
    slant = np.ones(len(p))
    half = np.cross(np.asarray(normal, dtype=float), segments)
    slant[1:-1] = np.clip(np.abs(np.sum(side[1:-1] * half[1:], axis=1)), 0.5, 1.0)
    side *= (width / 2 / slant)[:, None]
    vertices = np.empty((2 * len(p), 3))
    vertices[0::2] = p - side
    vertices[1::2] = p + side
    first = 2 * np.arange(len(p) - 1)
    triangles = np.empty((2 * len(first), 3), dtype=np.intp)
    triangles[0::2] = np.stack([first, first + 2, first + 1], axis=1)
    triangles[1::2] = np.stack([first + 1, first + 2, first + 3], axis=1)
    return vertices.T, triangles.T
