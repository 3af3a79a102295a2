"""How near to its path an episode was is measured on the truth, whatever the sensors said."""

import numpy as np
import pytest

from ichain_drake.control.tracking.arrival import Arrival
from ichain_drake.control.tracking.path import TimedPath
from ichain_drake.runs.paths.following import measure_result
from ichain_drake.simulation.episode import EpisodeLog
from ichain_drake.systems import load_scenario
from ichain_drake.timing import FRAME


def test_an_error_is_that_of_the_true_states() -> None:
    scenario = load_scenario("car_game", (), "ideal", 0)
    path = TimedPath(np.stack([np.linspace(200, 400, 50), np.full(50, 300.0)], axis=1), scenario.path_limits())
    times = np.arange(0.0, path.time[-1], FRAME)
    space = scenario.graph.objects["car"]
    states = np.zeros((len(times), len(space)))
    states[:, [space.index("x"), space.index("y")]] = path.at_time(times) + [0.0, 2.0]
    readings = np.zeros((len(times), len(space.observable)))  # a sensor that is 300 px off
    log = EpisodeLog(times, {"car": states}, {"car": readings}, {}, np.zeros((len(times), 2)))
    arrival = Arrival(path)
    arrival.see(log.states["car"][:, :2], path, len(path.points) - 1)
    result = measure_result(scenario, "line", path, log, arrival, 0)
    assert result.error == pytest.approx(2.0, abs=0.05)
    assert 2.0 <= result.paper_metric < 10.0
