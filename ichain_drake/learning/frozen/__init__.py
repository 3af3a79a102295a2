"""Fitted estimators as plain numpy: fast on one row, vectorised over rows, with Jacobians, savable without pickle."""

from ichain_drake.learning.frozen.convert import FREEZABLE, Freezable, freeze
from ichain_drake.learning.frozen.model import FrozenModel, from_arrays
from ichain_drake.learning.frozen.scaling import InputScaling

__all__ = ["FREEZABLE", "Freezable", "FrozenModel", "InputScaling", "freeze", "from_arrays"]
