"""From fitted scikit-learn trees and forests to `Trees`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from sklearn.base import is_classifier
from sklearn.dummy import DummyRegressor

from ichain_drake.errors import InputError
from ichain_drake.learning.frozen.scaling import FloatArray, InputScaling
from ichain_drake.learning.frozen.trees import Trees


def mean_of_trees(estimator: Any, members: Sequence[Any]) -> Trees:
    """The mean of trees; for classifiers the probability of class 1 minus 0.5."""
    factor = 1.0 / len(members)
    if not is_classifier(estimator):
        leaves = [member.tree_.value[:, :, 0] * factor for member in members]
        return _joined(members, leaves, np.zeros(leaves[0].shape[1]))
    leaves = []
    for member in members:
        counts = member.tree_.value[:, 0, :]
        leaves.append((counts[:, 1:2] / counts.sum(axis=1, keepdims=True)) * factor)
    return _joined(members, leaves, np.array([-0.5]))


def boosted_trees(estimator: Any) -> Trees:
    """The sum of a gradient boosting regressor's trees, shrunk by its learning rate, on its constant start."""
    if estimator.init_ == "zero":
        start = np.zeros(1)
    elif isinstance(estimator.init_, DummyRegressor):
        start = np.ravel(estimator.init_.constant_).astype(float)
    else:
        raise InputError("GradientBoostingRegressor can be frozen with init=None or 'zero' only")
    members = list(estimator.estimators_[:, 0])
    return _joined(members, [m.tree_.value[:, :, 0] * estimator.learning_rate for m in members], start)


def _joined(members: Sequence[Any], leaf_values: Sequence[FloatArray], offset: FloatArray) -> Trees:
    """All nodes of all trees in one numbering."""
    sizes = [member.tree_.node_count for member in members]
    roots = np.concatenate([[0], np.cumsum(sizes)[:-1]]).astype(np.int64)
    children, features, thresholds = [], [], []
    for member, root, size in zip(members, roots, sizes, strict=True):
        t = member.tree_
        leaf = t.children_left < 0
        own = np.arange(size)
        right, left = np.where(leaf, own, t.children_right), np.where(leaf, own, t.children_left)
        children.append(np.stack([right, left]) + root)
        features.append(np.where(leaf, 0, t.feature))
        thresholds.append(t.threshold)
    return Trees(
        inputs=InputScaling.identity(members[0].n_features_in_),
        roots=roots,
        features=np.concatenate(features).astype(np.int64),
        thresholds=np.concatenate(thresholds).astype(float),
        children=np.concatenate(children, axis=1).astype(np.int64),
        leaf_values=np.concatenate(leaf_values).astype(float),
        offset=offset,
        depth=np.array(max(member.tree_.max_depth for member in members), dtype=np.int64),
    )
