"""What a scenario declares about learning a graph: lists of estimators to choose from, by name."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from sklearn.base import is_classifier

from ichain_drake.errors import InputError
from ichain_drake.learning.chain.link import EstimatorSpec, listed_specs, specs_of
from ichain_drake.learning.status.box import BoxClassifier
from ichain_drake.state import FloatArray


def _specs(*texts: str) -> tuple[EstimatorSpec, ...]:
    return tuple(EstimatorSpec.parse(text) for text in texts)


def make_classifier(spec: EstimatorSpec, noise: FloatArray | float = 0.0) -> Any:
    """A new classifier by name: `box`, or one that `make_estimator` knows.

    Args:
        spec: name and parameters.
        noise: of the readings of its inputs, shape (n_features,), for one that can use it.

    Raises:
        InputError: on an unknown name or parameter.
    """
    if spec.name != "box":
        return spec.make()
    unknown = set(spec.parameters) - {"reach"}
    if unknown:
        raise InputError(f"estimator box has no parameter {sorted(unknown)[0]!r}; it has reach")
    return BoxClassifier(**spec.parameters, noise=noise)


@dataclass(frozen=True)
class InteractionSpec:
    """Candidates for every model of a graph; the data choose.

    Attributes:
        effect_estimators: regressors, simpler ones first: a later one must be clearly better to be taken.
        status_estimators: classifiers with a decision function that can be frozen (see `learning.frozen.FREEZABLE`);
            beside those of the library `box` (see `BoxClassifier`).
        window: effects are judged over this many successive ticks [ticks]: slow ones drown in one tick's noise.

    Estimators may be given as `EstimatorSpec`, as text such as `Ridge(alpha=1.0)`, or as scikit-learn objects.

    Raises:
        InputError: on what is no estimator, or an object that can't be fitted or frozen.
    """

    effect_estimators: tuple[EstimatorSpec, ...] = _specs(
        "polynomial(degree=1, clip=None)",
        "rectified_linear()",
        "polynomial(degree=2, clip=None)",
        "kernel_ridge(alpha=0.03, gamma=0.3)",
    )
    status_estimators: tuple[EstimatorSpec, ...] = _specs(
        "box(reach=0.3)",
        "SVC(C=30.0, gamma=1.0, class_weight='balanced')",
        "SVC(C=300.0, gamma=0.3, class_weight='balanced')",
        "SVC(C=300.0, gamma=1.0, class_weight='balanced')",
        "SVC(C=300.0, gamma=3.0, class_weight='balanced')",
    )
    window: int = 12

    def __post_init__(self) -> None:
        object.__setattr__(self, "effect_estimators", specs_of(self.effect_estimators))
        object.__setattr__(self, "status_estimators", specs_of(self.status_estimators, classifier=True))


def spec_of(estimators: Any) -> InteractionSpec:
    """Candidates of both kinds from one list: regressors for effects, classifiers for statuses.

    Args:
        estimators: one or several, as `InteractionSpec` takes them; of a kind that is missing, the usual.

    Raises:
        InputError: on what is no estimator, or an object that can't be fitted or frozen.
    """
    listed = listed_specs(estimators)
    classifiers = [spec for spec in listed if is_classifier(make_classifier(spec))]
    regressors = [spec for spec in listed if spec not in classifiers]
    usual = InteractionSpec()
    return InteractionSpec(tuple(regressors) or usual.effect_estimators, tuple(classifiers) or usual.status_estimators)
