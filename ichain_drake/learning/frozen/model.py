"""What every frozen model can do: one row fast, many rows at once, Jacobians, spread, and a life as plain arrays."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ichain_drake.errors import InputError
from ichain_drake.learning.frozen.scaling import FloatArray, InputScaling

Array = NDArray[Any]


@dataclass(eq=False, kw_only=True)
class FrozenModel(ABC):
    """A fitted model as plain arrays; no scikit-learn call, no state, the same bits at every evaluation.

    A subclass is a dataclass whose fields are arrays: they are what is saved. It evaluates *scaled* inputs `z`.

    Attributes:
        inputs: scaling of the inputs.
        residual_std: standard deviation of a prediction's error, shape (n_out,), in the units of the outputs; None
            where nothing is known about it.
    """

    kind: ClassVar[str]
    kinds: ClassVar[dict[str, type[FrozenModel]]] = {}
    takes_batches: ClassVar[bool] = False
    """Whether `batch` and `batch_noted` take tables of rows with leading dimensions, (..., n, n_in): each table gives
    the bits that it gives alone, which rows of one table don't, as BLAS sums in another order for more rows."""

    inputs: InputScaling
    residual_std: FloatArray | None = None

    def __init_subclass__(cls) -> None:
        FrozenModel.kinds[cls.kind] = cls

    def __post_init__(self) -> None:
        # One memory layout for all: BLAS sums in another order for another layout, and a loaded model must agree
        # with the saved one in every bit.
        for f in fields(self):
            value = getattr(self, f.name)
            if isinstance(value, np.ndarray) and value.ndim:
                setattr(self, f.name, np.ascontiguousarray(value))
        self.n_in = len(self.inputs.mean)
        self._prepare()
        if self.residual_std is not None:
            std = np.asarray(self.residual_std, dtype=float)
            if std.shape not in {(), (1,), (self.n_out,)} or not np.isfinite(std).all() or (std < 0).any():
                raise InputError(
                    f"residual_std: one number >= 0 an output is needed ({self.n_out}), got {self.residual_std}"
                )
            self.residual_std = np.ascontiguousarray(np.broadcast_to(std, (self.n_out,)))

    def _prepare(self) -> None:  # noqa: B027 - nothing to prepare is fine
        """Compute what evaluation needs from the fields."""

    @property
    @abstractmethod
    def n_out(self) -> int:
        """Number of outputs."""

    @abstractmethod
    def _value(self, z: FloatArray) -> FloatArray:
        """One scaled row, (n_in,) -> (n_out,)."""

    @abstractmethod
    def _value_and_jacobian(self, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        """One scaled row, (n_in,) -> (n_out,), (n_out, n_in)."""

    @abstractmethod
    def _batch(self, z: FloatArray) -> FloatArray:
        """Scaled rows, (n, n_in) -> (n, n_out)."""

    def _batch_jacobian(self, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Scaled rows, (n, n_in) -> (n, n_out), (n, n_out, n_in); row by row unless a subclass knows better."""
        values, jacobians = np.empty((len(z), self.n_out)), np.empty((len(z), self.n_out, self.n_in))
        for i, row in enumerate(z):
            values[i], jacobians[i] = self._value_and_jacobian(row)
        return values, jacobians

    def _noted(self, z: FloatArray) -> tuple[FloatArray, Any]:
        """Scaled rows, (n, n_in) -> (n, n_out) and a note for `_jacobians`: the Jacobians, unless it can wait."""
        return self._batch_jacobian(z)

    def _jacobians(self, notes: Sequence[Any]) -> FloatArray:
        """Jacobians by scaled inputs of k evaluations that were noted, (k, n, n_out, n_in)."""
        return np.stack(notes)

    @property
    def has_spread(self) -> bool:
        """Whether `spread` and `batch_spread` can answer."""
        return self.residual_std is not None

    def _batch_spread(self, z: FloatArray) -> FloatArray:
        """Predictive standard deviation of scaled rows, (n, n_in) -> (n, n_out)."""
        if self.residual_std is None:
            raise InputError(
                f"frozen {self.kind} model: it has no predictive spread of its own; give residual_std to freeze()"
            )
        return np.tile(self.residual_std, (len(z), 1))

    @abstractmethod
    def rescaled(self, scale: FloatArray, offset: FloatArray) -> FrozenModel:
        """The model with outputs `y * scale + offset`, both of shape (n_out,), scale > 0."""

    def _std_times(self, scale: FloatArray) -> FloatArray | None:
        return None if self.residual_std is None else self.residual_std * scale

    def value(self, x: ArrayLike) -> FloatArray:
        """Evaluate one row.

        Args:
            x: inputs, shape (n_in,).

        Returns:
            shape (n_out,).

        Raises:
            InputError: on another shape.
        """
        return self._value(self.inputs.apply(self._row(x)))

    def value_and_jacobian(self, x: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Evaluate one row and its derivative.

        Args:
            x: inputs, shape (n_in,).

        Returns:
            value (n_out,), and d value / d x (n_out, n_in).
        """
        z = self.inputs.apply(self._row(x))
        value, jacobian = self._value_and_jacobian(z)
        return value, self.inputs.pull_back(jacobian, z)

    def batch(self, rows: ArrayLike) -> FloatArray:
        """Evaluate rows, shape (n, n_in) -> (n, n_out)."""
        return self._batch(self.inputs.apply(self._rows(rows)))

    def batch_jacobian(self, rows: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Evaluate rows and derivatives, shape (n, n_in) -> (n, n_out), (n, n_out, n_in)."""
        z = self.inputs.apply(self._rows(rows))
        values, jacobians = self._batch_jacobian(z)
        return values, self.inputs.pull_back(jacobians, z)

    def batch_noted(self, rows: ArrayLike) -> tuple[FloatArray, Any]:
        """The values of `batch_jacobian`, shape (n, n_out), and a note with which `jacobians` gives the derivatives.

        Where one evaluation starts from what another gave, the derivatives of all can so be calculated in one go.
        """
        z = self.inputs.apply(self._rows(rows))
        values, note = self._noted(z)
        return values, (z, note)

    def jacobians(self, notes: Sequence[Any]) -> FloatArray:
        """Derivatives of k evaluations by `batch_noted`, (k, n, n_out, n_in): to the bit those of `batch_jacobian`."""
        return self.inputs.pull_back(self._jacobians([note for _, note in notes]), np.array([z for z, _ in notes]))

    def spread(self, x: ArrayLike) -> FloatArray:
        """Predictive standard deviation at one row, shape (n_in,) -> (n_out,), in the units of the outputs.

        Raises:
            InputError: if the model has none (see `freeze`).
        """
        return self._batch_spread(self.inputs.apply(self._row(x))[None])[0]

    def batch_spread(self, rows: ArrayLike) -> FloatArray:
        """Predictive standard deviation at rows, shape (n, n_in) -> (n, n_out); errors as `spread`."""
        return self._batch_spread(self.inputs.apply(self._rows(rows)))

    def arrays(self) -> dict[str, Array]:
        """The model as plain arrays, for `np.savez`; `from_arrays(kind, arrays)` brings it back bit by bit."""
        result: dict[str, Array] = {
            "input_mean": self.inputs.mean,
            "input_scale": self.inputs.scale,
            "input_clip": np.array(self.inputs.clip),
        }
        for f in fields(self):
            value = getattr(self, f.name)
            if isinstance(value, np.ndarray):
                result[f.name] = value
        return result

    @classmethod
    def _from_arrays(cls, inputs: InputScaling, arrays: Mapping[str, Array]) -> FrozenModel:
        return cls(inputs=inputs, **{f.name: arrays[f.name] for f in fields(cls) if f.name in arrays})

    def _row(self, x: ArrayLike) -> FloatArray:
        row = np.asarray(x, dtype=float)
        if row.shape != (self.n_in,):
            raise InputError(f"frozen {self.kind} model: a row of {self.n_in} inputs is needed, got shape {row.shape}")
        return row

    def _rows(self, rows: ArrayLike) -> FloatArray:
        array = np.ascontiguousarray(rows, dtype=float)
        table = array.ndim == 2 or (array.ndim > 2 and self.takes_batches)
        if not table or array.shape[-1] != self.n_in:
            raise InputError(f"frozen {self.kind} model: shape (n, {self.n_in}) is needed, got {array.shape}")
        return array


def from_arrays(kind: str, arrays: Mapping[str, Array]) -> FrozenModel:
    """Build a frozen model from what `FrozenModel.arrays` gave.

    Args:
        kind: the `kind` of the saved model.
        arrays: such as an opened `.npz` file.

    Raises:
        InputError: on an unknown kind, or on arrays that don't make a model of that kind; names what is missing.
    """
    if kind not in FrozenModel.kinds:
        raise InputError(f"frozen model of kind {kind!r}: unknown; known are {', '.join(sorted(FrozenModel.kinds))}")
    try:
        for name in arrays:
            if arrays[name].dtype.kind == "f" and np.isnan(arrays[name]).any():
                raise InputError(f"frozen model of kind {kind!r}: array {name} contains NaN")
        inputs = InputScaling(arrays["input_mean"], arrays["input_scale"], float(arrays["input_clip"]))
        return FrozenModel.kinds[kind]._from_arrays(inputs, arrays)
    except InputError:
        raise
    except (KeyError, TypeError, ValueError, IndexError) as error:
        raise InputError(f"frozen model of kind {kind!r}: its arrays are incomplete or misshapen ({error})") from error
