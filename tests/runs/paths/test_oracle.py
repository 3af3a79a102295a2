"""The oracle plans with the true model, which predicts the noise-free world exactly."""

import numpy as np
import pytest

from ichain_drake.control.tracking.path import TimedPath
from ichain_drake.runs.paths.following import oracle_follow
from ichain_drake.runs.paths.oracle import TrueTickModel, straight_frames
from ichain_drake.scenarios.joystick_demonstrations import Player
from ichain_drake.simulation.episode import Episode
from ichain_drake.systems import load_scenario
from ichain_drake.timing import FRAMES_PER_TICK
from ichain_drake.world.reference import WorldReference


def wave() -> np.ndarray:
    t = np.linspace(0.0, 1.0, 200)[:, None]
    return np.concatenate([250 + 200 * t, 300 + 40 * np.sin(6 * t)], axis=1)


def test_its_model_is_the_noise_free_world():
    scenario = load_scenario("car_game", ["noise.scale=0"], "ideal", 0)
    world = scenario.make_world(TimedPath(wave(), scenario.path_limits()), 0)
    # Steps that the hand makes in four frames; for longer ones its path over the sphere counts, which is not modelled.
    player = Player(np.array([0.5, 0.0]), 0.04, 0.03, 8, [3])
    episode = Episode(world, player)
    episode.run(8)
    log = episode.log()
    names = scenario.graph.chain(scenario.target)
    sizes = tuple(len(scenario.graph.objects[n]) for n in names)
    model = TrueTickModel(WorldReference(scenario.graph, world.objects, straight_frames), names, sizes)
    for tick in range(1, 7):
        now, then = FRAMES_PER_TICK * tick, FRAMES_PER_TICK * (tick + 1)
        joined = np.concatenate([log.states[n][now] for n in names[1:]])[None]
        after = model.predict(joined, log.states[names[0]][now][None], log.states[names[0]][then][None])
        wanted = np.concatenate([log.states[n][then] for n in names[1:]])
        np.testing.assert_allclose(after[0], wanted, atol=1e-6)


def test_its_slopes_are_those_of_its_predictions():
    scenario = load_scenario("car_game", (), "ideal", 0)
    world = scenario.make_world(TimedPath(wave(), scenario.path_limits()), 0)
    names = scenario.graph.chain(scenario.target)
    sizes = tuple(len(scenario.graph.objects[n]) for n in names)
    model = TrueTickModel(WorldReference(scenario.graph, world.objects, straight_frames), names, sizes)
    child = np.array([[0.1, 0.1, 0.2, 0.2, 300.0, 300.0, 0.3, 40.0, 0.1, 0.5]])
    hand, command = np.array([[0.51, 0.005]]), np.array([[0.52, -0.01]])
    after, *slopes = model.linearize(child, hand, command)
    np.testing.assert_allclose(after, model.predict(child, hand, command))
    step, inputs = 1e-6, [child, hand, command]
    for which, slope in enumerate(slopes):
        numeric = np.empty_like(slope)
        for k in range(slope.shape[2]):
            more, less = ([*inputs], [*inputs])
            more[which], less[which] = (inputs[which] + sign * step * np.eye(slope.shape[2])[k] for sign in (1, -1))
            numeric[:, :, k] = (model.predict(*more) - model.predict(*less)) / (2 * step)
        assert np.abs(numeric).max() > 1e-3, "each input matters"
        np.testing.assert_allclose(slope, numeric, rtol=1e-2, atol=1e-2 * np.abs(numeric).max())


def test_a_hand_that_has_far_to_go_takes_longer():
    near = straight_frames(np.zeros(2), np.array([0.03, 0.0]))
    np.testing.assert_allclose(near[:4, 0], 0.03 * np.arange(1, 5) / 4)
    np.testing.assert_allclose(near[4:, 0], 0.03)
    far = straight_frames(np.zeros(2), np.array([0.0, 0.2]))
    np.testing.assert_allclose(np.diff(far[:, 1]), 0.4 / 30, atol=1e-9)  # at the speed limit, past the tick's end
    assert far[-1, 1] == pytest.approx(0.4 / 3)


def test_it_follows_a_path_and_says_the_same_twice():
    scenario = load_scenario("car_game", (), "ideal", 0)
    path = TimedPath(wave(), scenario.path_limits())
    first, second = (oracle_follow(scenario, "wave", path, 0) for _ in range(2))
    assert first.completed
    assert 0.2 < first.error < 1.0
    assert first.error == second.error
    np.testing.assert_array_equal(first.log.states["car"], second.log.states["car"])
