"""The log of an episode holds what the ports showed, also where it makes its rows afterwards."""

import numpy as np
import pytest
from small_car_world import car_world, random_commands

from ichain_drake.control.tracking.path import TimedPath
from ichain_drake.objects import ObjectSettings
from ichain_drake.simulation.commands import Commands
from ichain_drake.simulation.episode import Episode
from ichain_drake.systems.car_game.scenario import CarGame
from ichain_drake.timing import FRAME
from ichain_drake.world import World


def make_world(kind: str) -> World:
    if kind != "contact":
        dropouts = ((0.1, 0.3),) if kind == "dropout" else ()
        return car_world(settings={"car": ObjectSettings(2, 3, dropouts=dropouts, reading_scale=1.0)})
    game = CarGame(("robot.hand.noise_std={x: 0.001}",), "contact")
    return game.make_world(TimedPath(game.reference_paths()["eight"], game.path_limits()), 0)


@pytest.mark.parametrize("kind", ["ideal", "dropout", "contact"])
def test_rows_are_what_the_ports_showed_to_the_last_bit(kind: str) -> None:
    world = make_world(kind)
    episode = Episode(world, Commands(random_commands(3)))
    shown: dict[tuple[str, str], list[np.ndarray]] = {}
    for frame in range(13):
        if frame:
            episode.simulator.AdvanceTo(frame * FRAME)  # the updates of this instant are still to come
        for name in world.graph.objects:
            for port in ("state", "measured"):
                shown.setdefault((name, port), []).append(episode.value(name, port))
        if frame in (0, 5):
            episode.log()  # what is made of its rows is kept for the next time
    log = episode.log()
    assert len(episode.log().times) == len(log.times) == 13
    for (name, port), rows in shown.items():
        logged = {"state": log.states, "measured": log.measured}[port][name]
        np.testing.assert_array_equal(logged, rows, f"{name}.{port}")
    np.testing.assert_array_equal(episode.recent("hand"), log.states["hand"][-11:])
    noisy = "hand" if kind == "contact" else "car"
    assert not np.array_equal(log.measured[noisy], log.states[noisy][:, : log.measured[noisy].shape[1]])
