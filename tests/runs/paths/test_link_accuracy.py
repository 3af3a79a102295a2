"""The floor under the whole chain: how well the hand brings the joystick to wanted axes, from 200 positions.

Run with `-s` to see the figures.
"""

import numpy as np
import pytest

from ichain_drake.errors import InputError
from ichain_drake.objects.controls.joystick import FULL_TILT, tilt_from_axes
from ichain_drake.runs.paths.link_accuracy import HasWantedStates, LinkAccuracy, learn_first_link, measure_first_link
from ichain_drake.systems import load_scenario
from ichain_drake.systems.car_game.scenario import CarGame

MOVING, REST = 0.03, 0.02
"""Largest rms over both axes at the end of the first tick and of the next, read noise included."""


def measured(physics: str, samples: int, count: int = 40) -> LinkAccuracy:
    scenario = load_scenario("car_game", [f"learning.samples={samples}"], physics, 0)  # type: ignore[arg-type]
    assert isinstance(scenario, CarGame)
    chain = learn_first_link(scenario, [scenario.record_play(samples)], scenario.config.learning.candidates())
    found = measure_first_link(scenario, chain, count)
    print(f"\n{physics}, {samples} positions: {found}")
    return found


@pytest.mark.parametrize(("physics", "samples"), [("contact", 200), ("ideal", 200)])
def test_wanted_axes_are_reached(physics, samples):
    found = measured(physics, samples)
    assert found.edge == "hand->joystick"
    assert found.samples == samples
    assert found.held
    assert found.moving <= MOVING
    assert found.rest <= REST
    # Read noise 0.004 and rounding to 1/127 come on top of what is really off.
    noise = np.hypot(0.004, 1 / 127 / np.sqrt(12))
    assert found.true_moving < found.moving < found.true_moving + 2 * noise
    assert found.true_rest < found.rest < found.true_rest + 2 * noise


def test_wanted_axes_are_held_out_within_reach_and_far_apart():
    scenario = load_scenario("car_game", (), "ideal", 0)
    assert isinstance(scenario, HasWantedStates)
    wanted = scenario.held_out_wanted(100)
    tilt = tilt_from_axes(wanted)
    assert wanted.shape == (100, 2)
    assert np.abs(wanted).max() <= 1
    inside = np.abs(wanted).max(axis=1) < 0.97  # tilts of saturated axes can't be told from the axes
    assert np.abs(tilt[inside]).max() <= FULL_TILT + 1e-9
    steps = np.abs(np.diff(tilt, axis=0))[inside[1:] & inside[:-1]]
    assert np.degrees(steps.max()) <= 15.0 + 1e-6
    assert np.degrees(steps.max()) > 13.0
    np.testing.assert_array_equal(wanted, load_scenario("car_game", (), "contact", 0).held_out_wanted(100))
    assert not np.array_equal(wanted, load_scenario("car_game", (), "ideal", 1).held_out_wanted(100))


class WrongShape(CarGame):
    def held_out_wanted(self, count):
        return np.zeros((count, 3))


def test_wanted_states_of_a_wrong_shape_are_refused():
    scenario = WrongShape(["learning.samples=60"], "ideal", 0)
    chain = learn_first_link(scenario, [scenario.record_play(60)], scenario.config.learning.candidates())
    with pytest.raises(InputError, match=r"held_out_wanted gave shape \(10, 3\)"):
        measure_first_link(scenario, chain, 10)
