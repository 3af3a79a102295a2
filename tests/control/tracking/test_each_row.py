"""Many rows decided at once: each to the bits that it has alone, whatever models the levels have."""

from typing import Any

import numpy as np
import pytest
from sklearn.linear_model import LinearRegression
from sklearn.neural_network import MLPRegressor
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler

from ichain_drake.control.tracking.each_row import each_row
from ichain_drake.control.tracking.levels import InverseLevel, PredictiveLevel
from ichain_drake.control.tracking.move_to import MoveTo, RobotLevel
from ichain_drake.learning.chain.models import ForwardModel, InverseModel
from ichain_drake.learning.estimators import PolynomialGaussianProcess, PolynomialRegressor
from ichain_drake.learning.frozen import freeze
from ichain_drake.state import StateSpace, Variable

HAND = StateSpace("hand", (Variable("a", "m"), Variable("b", "m")))
THING = StateSpace("thing", (Variable("x", "m"), Variable("y", "m"), Variable("v", "m/s")))
ESTIMATORS = {
    "polynomial": lambda: PolynomialRegressor(degree=2),
    "process": PolynomialGaussianProcess,
    "network": lambda: make_pipeline(
        StandardScaler(), MLPRegressor(hidden_layer_sizes=(6,), solver="lbfgs", max_iter=30, random_state=0)
    ),
}


def frozen(estimator: Any, inputs: np.ndarray, outputs: np.ndarray) -> Any:
    return freeze(estimator.fit(inputs, outputs))


@pytest.mark.filterwarnings("ignore:lbfgs failed to converge")
@pytest.mark.parametrize("name", ESTIMATORS)
def test_decisions_are_those_of_each_alone(name: str) -> None:
    rng = np.random.default_rng(0)
    child, hand = rng.uniform(-1, 1, (120, 3)), rng.uniform(-1, 1, (120, 2))
    change = 0.1 * np.stack([hand[:, 0] + 0.1 * child[:, 1], hand[:, 1] ** 2, child[:, 2] * hand[:, 0]], axis=1)
    forward = ForwardModel(
        THING, HAND, "raw", "next", frozen(ESTIMATORS[name](), np.concatenate([child, hand], axis=1), change)
    )
    inverse = InverseModel(
        HAND, HAND, (0, 1), "none", 1, frozen(ESTIMATORS[name](), hand, hand), -np.ones(2), np.ones(2)
    )
    predictive = PredictiveLevel(forward, THING, (0, 1), np.full(2, 0.1), -np.ones(2), np.ones(2), np.full(2, 0.5))
    robot = RobotLevel(
        HAND, np.ones(2), frozen(LinearRegression(), hand, hand + 0.01), np.full(2, -2.0), np.full(2, 2.0)
    )
    policy = MoveTo([InverseLevel(inverse, np.ones(2)), predictive], robot)
    states = [rng.uniform(-1, 1, (40, n)) for n in (2, 2, 3)]
    wanted = states[2][:, None, :2] + np.cumsum(rng.uniform(-0.1, 0.1, (40, policy.lookahead, 2)), axis=1)
    memory = np.zeros((40, policy.memory_size))
    for _ in range(2):
        rows = [policy.decide([s[k : k + 1] for s in states], wanted[k : k + 1], memory[k : k + 1]) for k in range(40)]
        command, memory, _ = each_row(policy).decide(states, wanted, memory)
        np.testing.assert_array_equal(command, np.concatenate([row[0] for row in rows]))
        np.testing.assert_array_equal(memory, np.concatenate([row[1] for row in rows]))
    assert len(np.unique(command[:, 0])) > 10
