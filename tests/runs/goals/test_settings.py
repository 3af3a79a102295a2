"""Which of the settings that every scenario has a scenario with a goal obeys."""

import pytest
from lamp import LampScenario

import ichain_drake as ic
from ichain_drake.errors import InputError
from ichain_drake.learning import InteractionSpec
from ichain_drake.runs.goals.settings import graph_spec
from ichain_drake.scenarios.config import ControlConfig, LearningConfig, ScenarioConfig


def test_the_estimator_is_the_only_one_for_effects() -> None:
    assert graph_spec(ScenarioConfig()) == InteractionSpec()
    spec = graph_spec(ScenarioConfig(learning=LearningConfig(estimator="kernel_ridge(gamma=0.5)")))
    assert [str(e) for e in spec.effect_estimators] == ["kernel_ridge(gamma=0.5)"]
    assert spec.status_estimators == InteractionSpec().status_estimators


@pytest.mark.parametrize(
    ("config", "message"),
    [
        (ScenarioConfig(learning=LearningConfig(samples=499)), "learning.samples is for scenarios that follow paths"),
        (ScenarioConfig(learning=LearningConfig(action="current")), "learning.action is for scenarios that follow"),
        (ScenarioConfig(control=ControlConfig(method="inverse")), "control.method is for scenarios that follow paths"),
        (ScenarioConfig(control=ControlConfig(along=0.5)), "control.along is for scenarios that follow paths"),
        (ScenarioConfig(learning=LearningConfig(estimator="LogisticRegression")), "it is no regressor"),
        (ScenarioConfig(learning=LearningConfig(estimator="mlp(colour=1)")), r"learning.estimator mlp\(colour=1\): "),
        (ScenarioConfig(learning=LearningConfig(estimator="mlp(")), r"learning.estimator mlp\(: "),
        (ScenarioConfig(learning=LearningConfig(estimator="AdaBoostRegressor")), "estimator AdaBoostRegressor: "),
    ],
)
def test_others_are_refused_before_anything_is_recorded(config: ScenarioConfig, message: str) -> None:
    with pytest.raises(InputError, match=message) as refused:
        graph_spec(config)
    assert "\n" not in str(refused.value)
    scenario = LampScenario()
    scenario.config = config
    run = ic.GraphRun(scenario, ("lamp.light >= 0.5",))
    with pytest.raises(InputError, match=message):
        ic.run_graph(run)
    assert run.pieces == []
