"""What a scenario declares about learning a graph: lists of estimators to choose from, by name."""

from __future__ import annotations

from dataclasses import dataclass

from ichain_drake.learning.link import EstimatorSpec


def _specs(*texts: str) -> tuple[EstimatorSpec, ...]:
    return tuple(EstimatorSpec.parse(text) for text in texts)


@dataclass(frozen=True)
class InteractionSpec:
    """Candidates for every model of a graph; the data choose.

    Attributes:
        effect_estimators: regressors, simpler ones first: a later one must be clearly better to be taken.
        status_estimators: classifiers with a decision function that can be frozen (see `learning.frozen.FREEZABLE`).
        window: effects are judged over this many successive ticks [ticks]: slow ones drown in one tick's noise.
    """

    effect_estimators: tuple[EstimatorSpec, ...] = _specs(
        "polynomial(degree=1, clip=None)", "polynomial(degree=2, clip=None)", "kernel_ridge(alpha=0.03, gamma=0.3)"
    )
    status_estimators: tuple[EstimatorSpec, ...] = _specs(
        "SVC(C=30.0, gamma=1.0, class_weight='balanced')",
        "SVC(C=300.0, gamma=0.3, class_weight='balanced')",
        "SVC(C=300.0, gamma=1.0, class_weight='balanced')",
        "SVC(C=300.0, gamma=3.0, class_weight='balanced')",
    )
    window: int = 12
