"""State spaces: the named, ordered variables that make up an object's state (paper sec. III: the set S_i)."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydrake.common.containers import namedview

from ichain_drake.errors import InputError

Kind = Literal["real", "angle", "binary", "integer"]
RoleKind = Literal["position", "orientation", "amount", "intensive", "change", "level"]

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.intp]


@dataclass(frozen=True)
class Role:
    """What a variable *is*, so that learning can build features without knowing names.

    Attributes:
        kind: `position` and `orientation` (a component of a pose), `amount` (a conserved quantity), `intensive`
            (a property of an amount that mixes by volume), `change` (the change of an amount over one tick), `level`.
        frame: the frame a pose component is expressed in; components of one pose share it.
        axis: `x`, `y` or `z`: the direction of a position, or the axis that an orientation turns about.
        of: for `intensive` and `change`: the name of the amount in the same state space.
    """

    kind: RoleKind
    frame: str = ""
    axis: str = ""
    of: str = ""


@dataclass(frozen=True)
class Variable:
    """One variable of a state.

    Attributes:
        name: unique within its state space.
        unit: a unit symbol such as `m`, `rad`, `px/s`; `1` for a dimensionless number.
        lower, upper: bounds, in the unit; an angle's are those of its wrapped value.
        kind: real, angle (wraps at +-pi rad), binary or integer.
        role: see `Role`; None where nothing is declared.
        hidden: part of the truth, but never measured: it appears in no demonstration, controller or learned model.
        measured_in: `plant` where, in `contact` physics, the value is sampled from a body in the arm's plant.
    """

    name: str
    unit: str = "1"
    lower: float = -math.inf
    upper: float = math.inf
    kind: Kind = "real"
    role: Role | None = None
    hidden: bool = False
    measured_in: Literal["", "plant"] = ""

    def __post_init__(self) -> None:
        if not self.name or "." in self.name or "->" in self.name:
            raise InputError(f"variable name {self.name!r}: give a non-empty name without '.' and '->'")
        if not self.lower <= self.upper:
            raise InputError(f"variable {self.name}: lower bound {self.lower} is not below upper bound {self.upper}")
        if self.kind == "angle" and self.unit not in ("rad", "1"):
            raise InputError(
                f"variable {self.name}: an angle wraps at +-pi rad, so it can't be in {self.unit}; declare "
                f"Variable({self.name!r}, 'rad', -math.pi, math.pi, kind='angle'), and "
                f"say [{self.unit}] in the headers of tables: they are converted"
            )


def wrap_angle(angle: ArrayLike) -> FloatArray:
    """Wrap angles to [-pi, pi).

    Args:
        angle: any shape [rad].

    Returns:
        The same shape [rad]; NaN stays NaN.
    """
    if isinstance(angle, float):  # to the same bits, in a fraction of the time
        turned = (angle + math.pi) % (2 * math.pi) - math.pi
        return np.float64(-math.pi if turned >= math.pi else turned)  # type: ignore[return-value]
    wrapped = (np.asarray(angle, dtype=float) + math.pi) % (2 * math.pi) - math.pi
    # The remainder of a tiny negative number rounds up to 2 pi.
    if not wrapped.ndim:
        return np.asarray(-math.pi) if wrapped >= math.pi else wrapped
    return np.where(wrapped >= math.pi, -math.pi, wrapped)


def columns(state: FloatArray) -> list[FloatArray]:
    """The variables of a state, shape (..., n_variables), one by one, each of shape (...).

    Without a batch they are Python's numbers: computing with these is many times faster than with arrays of no
    dimension, and several times faster than with numpy's own numbers, to the same bits.
    """
    return state.tolist() if state.ndim == 1 else [state[..., i] for i in range(state.shape[-1])]


@dataclass(frozen=True)
class StateSpace:
    """An ordered set of variables (paper sec. III: S_i of object O_i, and the action set A_i+1 of its child, eq. 2).

    Attributes:
        type: the object type, such as `joystick`; an interaction library is keyed by it.
        variables: the variables in the order of the state vector.
    """

    type: str
    variables: tuple[Variable, ...] = field(default=())

    def __post_init__(self) -> None:
        object.__setattr__(self, "variables", tuple(self.variables))
        names = [v.name for v in self.variables]
        for name in names:
            if names.count(name) > 1:
                raise InputError(f"state space {self.type}: variable {name} is declared twice")
        for v in self.variables:
            if v.role is not None and v.role.of and v.role.of not in names:
                raise InputError(f"state space {self.type}: {v.name} refers to {v.role.of}, which it does not have")

    def __len__(self) -> int:
        return len(self.variables)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Variable names in state order."""
        return tuple(v.name for v in self.variables)

    @cached_property
    def observable(self) -> StateSpace:
        """The state space without hidden variables: what is measured, demonstrated and learned."""
        return self._part(self.observable_indices)

    @cached_property
    def observable_indices(self) -> NDArray[np.intp]:
        """Positions of the observable variables in the state vector, shape (n_observable,)."""
        return np.array([i for i, v in enumerate(self.variables) if not v.hidden], dtype=np.intp)

    @cached_property
    def plant_indices(self) -> NDArray[np.intp]:
        """Positions of the variables that are sampled from the plant in `contact`, shape (n,)."""
        return np.array([i for i, v in enumerate(self.variables) if v.measured_in == "plant"], dtype=np.intp)

    @cached_property
    def angle_mask(self) -> NDArray[np.bool_]:
        """True for variables that wrap, shape (n_variables,)."""
        return np.array([v.kind == "angle" for v in self.variables], dtype=bool)

    @cached_property
    def _turns(self) -> bool:
        """Whether any variable wraps."""
        return bool(self.angle_mask.any())

    @cached_property
    def jump_mask(self) -> NDArray[np.bool_]:
        """True for variables that can't change gradually, shape (n_variables,)."""
        return np.array([v.kind in ("binary", "integer") for v in self.variables], dtype=bool)

    @cached_property
    def lower(self) -> FloatArray:
        """Lower bounds, shape (n_variables,)."""
        return np.array([v.lower for v in self.variables], dtype=float)

    @cached_property
    def upper(self) -> FloatArray:
        """Upper bounds, shape (n_variables,)."""
        return np.array([v.upper for v in self.variables], dtype=float)

    @cached_property
    def view(self) -> Any:
        """A `pydrake` namedview class that reads a state vector by variable name."""
        return namedview(f"{self.type.title().replace('_', '')}State", list(self.names))

    def index(self, name: str) -> int:
        """Position of a variable in the state vector.

        Raises:
            InputError: if there is no variable of that name.
        """
        try:
            return self.names.index(name)
        except ValueError:
            raise InputError(f"{self.type} has no variable {name!r}; it has {', '.join(self.names)}") from None

    def indices(self, names: Iterable[str]) -> NDArray[np.intp]:
        """Positions of several variables, shape (len(names),)."""
        return np.array([self.index(n) for n in names], dtype=np.intp)

    def role_indices(self, kind: RoleKind) -> NDArray[np.intp]:
        """Positions of the variables that have a role of this kind, shape (n,)."""
        return np.array([i for i, v in enumerate(self.variables) if v.role and v.role.kind == kind], dtype=np.intp)

    def difference(self, to: ArrayLike, start: ArrayLike) -> FloatArray:
        """`to - start`, with angles taken the short way round.

        Args:
            to, start: states, shape (..., n_variables).

        Returns:
            shape (..., n_variables), in the variables' units.
        """
        delta = np.asarray(to, dtype=float) - np.asarray(start, dtype=float)
        return np.where(self.angle_mask, wrap_angle(delta), delta) if self._turns else delta

    def clip(self, state: ArrayLike) -> FloatArray:
        """Clip to the bounds; angles are left alone. Shape (..., n_variables) in and out."""
        value = np.asarray(state, dtype=float)
        # `np.clip` of so few numbers takes more than twice as long.
        clipped = np.minimum(np.maximum(value, self.lower), self.upper)
        return np.where(self.angle_mask, value, clipped) if self._turns else clipped

    def check(self, state: ArrayLike, where: str) -> FloatArray:
        """Check a state vector where data enters.

        Args:
            state: shape (..., n_variables).
            where: what to name in the error, such as `car start state`.

        Returns:
            The state as a float array.

        Raises:
            InputError: on a wrong shape or a NaN or infinite value; names the variable.
        """
        value = np.asarray(state, dtype=float)
        if value.shape[-1:] != (len(self),):
            raise InputError(f"{where}: shape {value.shape} given, {len(self)} values needed ({', '.join(self.names)})")
        bad = ~np.isfinite(value).reshape(-1, len(self)).all(axis=0)
        if bad.any():
            raise InputError(f"{where}: {self.names[int(np.argmax(bad))]} is not a finite number")
        return value

    def subspace(self, names: Sequence[str]) -> StateSpace:
        """The state space of some of the variables, in the order given; a role without its amount is dropped."""
        return self._part(self.indices(names))

    def _part(self, indices: NDArray[np.intp]) -> StateSpace:
        kept = [self.variables[i] for i in indices]
        names = {v.name for v in kept}
        lost = [v for v in kept if v.role is not None and v.role.of and v.role.of not in names]
        return StateSpace(self.type, tuple(replace(v, role=None) if v in lost else v for v in kept))
