"""Which settings of `learning` and `control` a scenario with a goal obeys."""

from __future__ import annotations

from dataclasses import fields, replace

from ichain_drake.errors import InputError
from ichain_drake.learning import InteractionSpec
from ichain_drake.learning.chain.link import EstimatorSpec
from ichain_drake.learning.estimators.trial import try_out
from ichain_drake.scenarios.config import ControlConfig, LearningConfig, ScenarioConfig


def graph_spec(config: ScenarioConfig) -> InteractionSpec:
    """Candidate estimators for a scenario with a goal: `learning.estimator`, if given, is the only one for effects.

    Raises:
        InputError: on an estimator that can't be fitted or frozen, or any other setting of `learning` or `control`
            that is not the usual one: those are about paths.
    """
    learning = replace(config.learning, estimator="")
    for section, given, usual in (
        ("learning", learning, LearningConfig()),
        ("control", config.control, ControlConfig()),
    ):
        for item in fields(usual):  # type: ignore[arg-type] # mypy joins the two classes to `object`
            if getattr(given, item.name) != getattr(usual, item.name):
                raise InputError(
                    f"{section}.{item.name} is for scenarios that follow paths: a graph is learned from all rows of "
                    "its demonstrations and controlled by plans; leave it out"
                )
    text = config.learning.estimator
    return InteractionSpec(effect_estimators=(_regressor(text),)) if text else InteractionSpec()


def planner_of(config: ScenarioConfig) -> str:
    """Name of the planner that a scenario asks for; one whose configuration says nothing has the fast one."""
    return str(getattr(config, "planner", "fast"))


def _regressor(text: str) -> EstimatorSpec:
    """The estimator, tried out on a few rows: one that can't be used would be passed over in learning, with no word."""
    try:
        spec = EstimatorSpec.parse(text)
        try_out(spec.make())
    except (TypeError, ValueError) as error:  # InputError is one
        raise InputError(f"learning.estimator {text}: {' '.join(str(error).split())[:300]}") from None
    return spec
