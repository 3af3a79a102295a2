"""The look at a world before a run: what sensors say, never what is."""

import numpy as np
import pytest
from lamp import Lamp, LampScenario

from ichain_drake.runs.goals.run import own_goal
from ichain_drake.simulation.wiring import look, start_command


class DimLamp(Lamp):
    """Its sensor shows 0.3 more than there is."""

    def measure(self, state, noise):
        return state + 0.3 + 0.01 * noise


class Lying(LampScenario):
    kinds = {**LampScenario.kinds, "lamp": DimLamp}


def test_a_start_is_what_was_measured_averaged_over_a_few_ticks() -> None:
    start = look(Lying().make_world(3))
    assert start["lamp"] == pytest.approx(0.3, abs=0.02)
    assert start["lamp"] != pytest.approx(0.3, abs=1e-6)
    assert start["lamp"] == look(Lying().make_world(3))["lamp"] != look(Lying().make_world(4))["lamp"]
    assert {n: v.shape for n, v in start.items()} == {"hand": (3,), "dimmer": (1,), "switch": (1,), "lamp": (1,)}
    many = [look(Lying().make_world(k))["dimmer"][0] - 0.4 for k in range(12)]
    assert np.std(many) < 0.8e-3, "of one reading it is 1e-3"


def test_the_first_command_is_where_the_hand_is() -> None:
    scenario = Lying()
    assert own_goal(scenario) == ()
    home = scenario.spec.hand.reduce(scenario.spec.home_hand())
    np.testing.assert_allclose(start_command(scenario.make_world(0)), home, atol=1e-9)
