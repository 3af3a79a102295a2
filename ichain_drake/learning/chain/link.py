"""Learning one interaction: forward and inverse models with their cross-validation scores."""

from __future__ import annotations

import ast
import inspect
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Generic, TypeVar

import numpy as np
from sklearn.base import clone
from sklearn.model_selection import KFold, cross_val_predict

from ichain_drake.demonstrations.transitions import Transitions
from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction, Origin
from ichain_drake.learning.chain.models import ActionKind, ForwardModel, InverseModel
from ichain_drake.learning.estimators import for_outputs, make_estimator
from ichain_drake.learning.estimators.trial import try_out
from ichain_drake.learning.features import ChangeCode, FeatureKind
from ichain_drake.learning.frozen import FrozenModel, freeze
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import FloatArray


@dataclass(frozen=True)
class EstimatorSpec:
    """An estimator by name, with its parameters, as a scenario names it; or an estimator object.

    Attributes:
        name: see `make_estimator`; of an object, that of its class.
        parameters: its constructor's; of an object, those that are not the usual ones.
        estimator: the object, which is never fitted itself; None where the name says it all.
    """

    name: str = "polynomial"
    parameters: Mapping[str, Any] = field(default_factory=dict)
    estimator: Any = field(default=None, compare=False, repr=False)

    @classmethod
    def of(cls, given: Any) -> EstimatorSpec:
        """What somebody gave for an estimator: a spec, a name with parameters, or any scikit-learn estimator.

        Raises:
            InputError: on anything else, such as a class in place of an object.
        """
        if isinstance(given, EstimatorSpec):
            return given
        if isinstance(given, str):
            return cls.parse(given)
        if isinstance(given, type) or not hasattr(given, "fit") or not hasattr(given, "get_params"):
            raise InputError(f"{given!r} is no estimator; give a name such as 'polynomial(degree=3)' or an object")
        parameters = given.get_params(deep=False)
        usual = inspect.signature(type(given)).parameters
        changed = {k: v for k, v in parameters.items() if k not in usual or _written(v) != _written(usual[k].default)}
        return cls(type(given).__name__, {k: _written(v) for k, v in changed.items()}, clone(given))

    @classmethod
    def parse(cls, text: str) -> EstimatorSpec:
        """Read `name` or `name(parameter=value, ...)`; values are Python literals, nothing is evaluated.

        Raises:
            InputError: on any other text.
        """
        try:
            tree = ast.parse(text.strip(), mode="eval").body
            if isinstance(tree, ast.Name):
                return cls(tree.id)
            if not isinstance(tree, ast.Call) or not isinstance(tree.func, ast.Name) or tree.args:
                raise ValueError(text)
            if any(k.arg is None for k in tree.keywords):
                raise ValueError(text)
            return cls(tree.func.id, {str(k.arg): ast.literal_eval(k.value) for k in tree.keywords})
        except (SyntaxError, ValueError, TypeError, RecursionError, MemoryError):
            raise InputError(f"estimator {text!r}: write name or name(parameter=value, ...)") from None

    def make(self) -> Any:
        """A new, unfitted scikit-learn estimator."""
        if self.estimator is not None:
            return clone(self.estimator)
        return make_estimator(self.name, **dict(self.parameters))

    def __str__(self) -> str:
        inside = ", ".join(f"{k}={v!r}" for k, v in self.parameters.items())
        return f"{self.name}({inside})"


def _written(value: Any) -> Any:
    """A parameter as it can be read back: itself if it is a literal, else its text."""
    try:
        same = ast.literal_eval(repr(value)) == value
    except (ValueError, SyntaxError, TypeError, MemoryError, RecursionError):
        same = False
    return value if same is True else " ".join(repr(value).split())


def listed_specs(given: Any) -> tuple[EstimatorSpec, ...]:
    """Specs of several estimators, or of one, not tried out.

    Raises:
        InputError: on what is no estimator.
    """
    one = isinstance(given, EstimatorSpec | str | type) or hasattr(given, "get_params")
    try:
        return tuple(EstimatorSpec.of(item) for item in ([given] if one else given))
    except TypeError:  # it can't be gone through
        return (EstimatorSpec.of(given),)


def specs_of(given: Any, *, classifier: bool = False) -> tuple[EstimatorSpec, ...]:
    """Specs of several estimators, or of one; objects are tried out at once.

    Args:
        given: see `EstimatorSpec.of`.
        classifier: whether they have to classify.

    Raises:
        InputError: on what is no estimator, or an object that can't be fitted or frozen, with the list of what can.
    """
    specs = listed_specs(given)
    for spec in specs:
        if spec.estimator is not None:
            try:
                try_out(spec.make(), classifier=classifier)
            except InputError as error:
                raise InputError(f"estimator {spec}: {error}") from None
    return specs


@dataclass(frozen=True)
class ForwardSpec:
    """One candidate for a forward model."""

    estimator: EstimatorSpec = field(default_factory=EstimatorSpec)
    features: FeatureKind = "raw"
    action: ActionKind = "next"

    def __str__(self) -> str:
        return f"{self.estimator}, features {self.features}, action {self.action}"


@dataclass(frozen=True)
class InverseSpec:
    """One candidate for an inverse model."""

    estimator: EstimatorSpec = field(default_factory=EstimatorSpec)
    features: FeatureKind = "raw"
    aim: int = 1
    action: ActionKind = "next"

    def __str__(self) -> str:
        return f"{self.estimator}, features {self.features}, aim {self.aim}, action {self.action}"


ModelT = TypeVar("ModelT")
SpecT = TypeVar("SpecT")


@dataclass(frozen=True)
class Scored(Generic[ModelT, SpecT]):
    """A fitted model with what is known about it.

    Attributes:
        model: the fitted, frozen model.
        spec: the candidate that it came from.
        score: cross-validated coefficient of determination, mean over outputs (1 is perfect).
        residual_std: cross-validated residual of each output, in its unit, shape (n_out,).
        samples: number of transitions that it was fitted to.
    """

    model: ModelT
    spec: SpecT
    score: float
    residual_std: FloatArray
    samples: int


def cross_validated_std(estimator: Any, inputs: FloatArray, outputs: FloatArray) -> FloatArray:
    """Standard deviation of the residuals of rows that the fit has not seen, shape (n_out,).

    An estimator that knows it exactly after `fit`, by leaving one out (attribute `residual_std_`), is asked; any other
    is fitted anew on each of five blocks of successive rows left out.
    """
    exact = getattr(estimator, "residual_std_", None)
    if exact is not None:
        return np.asarray(exact, dtype=float)
    predicted = cross_val_predict(clone(estimator), inputs, outputs, cv=KFold(LEARNING.folds))
    return np.sqrt(np.mean((outputs - np.asarray(predicted).reshape(outputs.shape)) ** 2, axis=0))


def _fit(
    spec: EstimatorSpec, inputs: FloatArray, outputs: FloatArray, where: str
) -> tuple[FrozenModel, float, FloatArray]:
    if len(inputs) < 2 * LEARNING.folds:
        raise InputError(
            f"{where}: {len(inputs)} transitions are too few for {spec}; record at least {2 * LEARNING.folds}"
        )
    try:
        estimator = for_outputs(spec.make(), outputs.shape[1]).fit(inputs, outputs)
        std = cross_validated_std(estimator, inputs, outputs)
        frozen = freeze(estimator, residual_std=std)
    except Exception as error:  # whatever an estimator of anybody may raise
        raise InputError(f"{where}: {spec}: {' '.join(str(error).split())[:300]}") from error
    spread = outputs.std(axis=0)
    moving = spread > 0
    score = float(np.mean(1.0 - (std[moving] / spread[moving]) ** 2)) if moving.any() else 1.0
    return frozen, score, std


def fit_forward(
    data: Transitions, spec: ForwardSpec, interaction: Interaction, origin: Origin | None = None
) -> Scored[ForwardModel, ForwardSpec]:
    """Fit Tr of one interaction (paper sec. III).

    Args:
        data: transitions while the interaction is active.
        spec: estimator, features and action convention.
        interaction: named in errors.
        origin: what the parent's positions are taken relative to; None for the frame's own.

    Raises:
        InputError: if the samples are too few for the estimator.
    """
    where = f"{interaction.name}, forward model"
    model = ForwardModel(data.child_space, data.parent_space, spec.features, spec.action, None, origin)  # type: ignore[arg-type]
    inputs = model.inputs(data.child, data.parent, data.parent_next)
    outputs = ChangeCode(data.child_space, spec.features).encode(data.child, data.child_next)
    frozen, score, std = _fit(spec.estimator, inputs, outputs, where)
    return Scored(replace(model, frozen=frozen), spec, score, std, len(data))


def fit_inverse(
    data: Transitions,
    spec: InverseSpec,
    targets: Sequence[int],
    interaction: Interaction,
    origin: Origin | None = None,
) -> Scored[InverseModel, InverseSpec]:
    """Fit Tr^-1 of one interaction directly, as the paper does (sec. IV).

    Args:
        data: transitions while the interaction is active.
        spec: estimator, features, how many ticks ahead the wanted state lies, action convention.
        targets: the child's variables that wanted states will name.
        interaction: named in errors.
        origin: what the parent's positions are taken relative to; None for the frame's own.

    Raises:
        InputError: if the samples are too few for the estimator.
    """
    where = f"{interaction.name}, inverse model"
    later, usable = data.child_ahead(spec.aim)
    action = data.parent_next if spec.action == "next" else data.parent
    model = InverseModel(
        data.child_space,
        data.parent_space,
        tuple(targets),
        spec.features,
        spec.aim,
        None,  # type: ignore[arg-type]
        action.min(axis=0),
        action.max(axis=0),
        origin,
    )
    inputs = model.inputs(data.child, later[:, list(targets)])[usable]
    offset = None if origin is None else origin.offset(data.parent_space)
    outputs = action[usable] if offset is None else action[usable] - offset
    frozen, score, std = _fit(spec.estimator, inputs, outputs, where)
    return Scored(replace(model, frozen=frozen), spec, score, std, int(usable.sum()))


def best_by_score(candidates: Sequence[Scored[ModelT, SpecT]]) -> Scored[ModelT, SpecT]:
    """The candidate with the highest cross-validation score; the earlier one of equals."""
    return max(candidates, key=lambda c: c.score)
