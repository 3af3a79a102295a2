"""Decision trees and their sums: all trees descend one level at a time, together."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ichain_drake.learning.frozen.model import FrozenModel
from ichain_drake.learning.frozen.scaling import FloatArray


@dataclass(eq=False, kw_only=True)
class Trees(FrozenModel):
    """`y = offset + sum of the leaf values that the trees reach`; piecewise constant, so its Jacobian is zero.

    Attributes:
        roots: shape (n_trees,).
        features: input that a node looks at, shape (n_nodes,); 0 at a leaf.
        thresholds: shape (n_nodes,).
        children: where a node goes on if its input is above (row 0) or not above (row 1) the threshold, shape
            (2, n_nodes); a leaf leads to itself.
        leaf_values: shape (n_nodes, n_out).
        offset: shape (n_out,).
        depth: levels of the deepest tree, shape ().
    """

    kind: ClassVar[str] = "trees"

    roots: NDArray[np.int64]
    features: NDArray[np.int64]
    thresholds: FloatArray
    children: NDArray[np.int64]
    leaf_values: FloatArray
    offset: FloatArray
    depth: NDArray[np.int64]

    def _prepare(self) -> None:
        self._levels = int(self.depth)
        self._flat_children = self.children.ravel()
        self._n_nodes = len(self.features)

    @property
    def n_out(self) -> int:
        """Number of outputs."""
        return self.leaf_values.shape[1]

    def _value(self, z: FloatArray) -> FloatArray:
        z = z.astype(np.float32)  # as scikit-learn compares
        node = self.roots
        for _ in range(self._levels):
            low = z.take(self.features.take(node)) <= self.thresholds.take(node)
            node = self._flat_children.take(node + self._n_nodes * low)
        return self.leaf_values.take(node, axis=0).sum(axis=0) + self.offset

    def _value_and_jacobian(self, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        return self._value(z), np.zeros((self.n_out, self.n_in))

    def _batch(self, z: FloatArray) -> FloatArray:
        z = z.astype(np.float32)
        node = np.tile(self.roots, (len(z), 1))
        rows = np.arange(len(z))[:, None]
        for _ in range(self._levels):
            low = z[rows, self.features[node]] <= self.thresholds[node]
            node = self._flat_children[node + self._n_nodes * low]
        result = np.zeros((len(z), self.n_out))
        for tree in range(len(self.roots)):
            result += self.leaf_values[node[:, tree]]
        return result + self.offset

    def _batch_jacobian(self, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        return self._batch(z), np.zeros((len(z), self.n_out, self.n_in))

    def rescaled(self, scale: FloatArray, offset: FloatArray) -> Trees:
        """The model with outputs `y * scale + offset`."""
        return replace(
            self,
            leaf_values=self.leaf_values * scale,
            offset=self.offset * scale + offset,
            residual_std=self._std_times(scale),
        )
