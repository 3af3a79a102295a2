"""Several frozen models of the same inputs side by side: outputs that can't be merged into one evaluation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from ichain_drake.errors import InputError
from ichain_drake.learning.frozen.gaussian_process import GaussianProcess, stack_gaussian_processes
from ichain_drake.learning.frozen.kernel import KernelSum, stack_kernel_sums
from ichain_drake.learning.frozen.model import Array, FrozenModel, from_arrays
from ichain_drake.learning.frozen.polynomial import Polynomial
from ichain_drake.learning.frozen.scaling import FloatArray, InputScaling


@dataclass(eq=False, kw_only=True)
class Stacked(FrozenModel):
    """The outputs of `parts`, one after the other.

    Attributes:
        parts: models with the same number of inputs; each scales its inputs itself.
    """

    kind: ClassVar[str] = "stacked"

    parts: list[FrozenModel]

    @property
    def n_out(self) -> int:
        """Number of outputs."""
        return sum(part.n_out for part in self.parts)

    def _value(self, z: FloatArray) -> FloatArray:
        return np.concatenate([part.value(z) for part in self.parts])

    def _value_and_jacobian(self, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        values, jacobians = zip(*(part.value_and_jacobian(z) for part in self.parts), strict=True)
        return np.concatenate(values), np.concatenate(jacobians)

    def _batch(self, z: FloatArray) -> FloatArray:
        return np.concatenate([part.batch(z) for part in self.parts], axis=1)

    def _batch_jacobian(self, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        values, jacobians = zip(*(part.batch_jacobian(z) for part in self.parts), strict=True)
        return np.concatenate(values, axis=1), np.concatenate(jacobians, axis=1)

    @property
    def has_spread(self) -> bool:
        """Whether every part has one, or a residual_std was given for those that have none."""
        return self.residual_std is not None or all(part.has_spread for part in self.parts)

    def _batch_spread(self, z: FloatArray) -> FloatArray:
        if self.residual_std is None:
            return np.concatenate([part.batch_spread(z) for part in self.parts], axis=1)
        result = np.tile(self.residual_std, (len(z), 1))
        start = 0
        for part in self.parts:
            if part.has_spread:
                result[:, start : start + part.n_out] = part.batch_spread(z)
            start += part.n_out
        return result

    def rescaled(self, scale: FloatArray, offset: FloatArray) -> Stacked:
        """The model with outputs `y * scale + offset`."""
        ends = np.cumsum([part.n_out for part in self.parts])[:-1]
        pieces = zip(self.parts, np.split(scale, ends), np.split(offset, ends), strict=True)
        return replace(self, parts=[part.rescaled(s, b) for part, s, b in pieces], residual_std=self._std_times(scale))

    def arrays(self) -> dict[str, Array]:
        """The model as plain arrays: those of each part, prefixed with its number."""
        result = super().arrays()
        for i, part in enumerate(self.parts):
            result[f"{i}.kind"] = np.array(part.kind)
            result |= {f"{i}.{name}": value for name, value in part.arrays().items()}
        return result

    @classmethod
    def _from_arrays(cls, inputs: InputScaling, arrays: Mapping[str, Array]) -> Stacked:
        parts: list[FrozenModel] = []
        while f"{len(parts)}.kind" in arrays:
            prefix = f"{len(parts)}."
            own = {name.removeprefix(prefix): arrays[name] for name in arrays if name.startswith(prefix)}
            parts.append(from_arrays(str(own["kind"]), own))
        if not parts:
            raise InputError("frozen model of kind 'stacked': it has no parts")
        return cls(inputs=inputs, parts=parts, residual_std=arrays.get("residual_std"))


def stack(models: list[FrozenModel]) -> FrozenModel:
    """One model with the outputs of several, merged into one evaluation where their form allows it.

    Args:
        models: models of the same inputs.
    """
    first = models[0]
    if len(models) == 1:
        return first
    if all(m.inputs.same_as(first.inputs) for m in models):
        polynomials = [m for m in models if isinstance(m, Polynomial) and m.noise_std is None]
        if len(polynomials) == len(models):
            lists = [[tuple(row) for row in p.exponents] for p in polynomials]
            union = np.array(sorted({row for rows in lists for row in rows}), dtype=np.int64).reshape(-1, first.n_in)
            place = {tuple(row): j for j, row in enumerate(union)}
            coef = np.zeros((sum(p.n_out for p in polynomials), len(union)))
            start = 0
            for p, rows in zip(polynomials, lists, strict=True):
                coef[start : start + p.n_out, [place[row] for row in rows]] = p.weights
                start += p.n_out
            return replace(Polynomial.from_terms(union, coef, np.zeros(len(coef))), inputs=first.inputs)
        sums = [m for m in models if isinstance(m, KernelSum) and len(m.centres) == 1]
        if len(sums) == len(models):
            return stack_kernel_sums(sums)
        processes = [m for m in models if isinstance(m, GaussianProcess)]
        if len(processes) == len(models) and all(
            np.array_equal(p.centres, processes[0].centres) and np.array_equal(p.exponents, processes[0].exponents)
            for p in processes
        ):
            return stack_gaussian_processes(processes)
    return Stacked(inputs=InputScaling.identity(first.n_in), parts=models)
