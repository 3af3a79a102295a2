"""The car game's own numbers: start states, demonstrations, and what it refuses."""

import numpy as np
import pytest

from ichain_drake.errors import InputError
from ichain_drake.objects.controls.joystick import axes_from_tilt
from ichain_drake.runs.paths.choice import choose_paths
from ichain_drake.scenarios.joystick_demonstrations import Player
from ichain_drake.simulation.episode import Episode
from ichain_drake.systems import load_scenario
from ichain_drake.systems.car_game.scenario import CarGame


def game(*settings: str, seed: int = 0) -> CarGame:
    scenario = load_scenario("car_game", settings, "ideal", seed)
    assert isinstance(scenario, CarGame)
    return scenario


def test_a_run_starts_on_its_path_with_the_stick_as_configured():
    scenario = game()
    path = choose_paths(scenario, ["eight"])["eight"]
    world = scenario.make_world(path, 0)
    lower, upper = scenario.command_range()
    player = Player((lower + upper) / 2, 0.0425, 0.085, 1, [0])
    episode = Episode(world, player)
    x, y, heading, speed = episode.value("car", "state")[:4]
    assert np.hypot(x - path.points[0, 0], y - path.points[0, 1]) < 5.0
    assert heading == pytest.approx(path.direction[0], abs=1e-9)
    assert speed == pytest.approx(path.speed[0])
    np.testing.assert_allclose(episode.value("joystick", "state")[2:], [0.0, 0.4], atol=1e-6)


def test_starts_differ_by_seed_and_run_and_not_without_noise():
    def start(scenario: CarGame, run: int) -> np.ndarray:
        path = choose_paths(scenario, ["eight"])["eight"]
        world = scenario.make_world(path, run)
        return world.objects["car"].get_state(world.objects["car"].CreateDefaultContext())[:2]

    places = [start(game(), 0), start(game(), 1), start(game(seed=1), 0)]
    assert len({tuple(p) for p in places}) == 3
    np.testing.assert_array_equal(start(game(), 0), places[0])
    np.testing.assert_array_equal(start(game("noise.scale=0"), 0), start(game("noise.scale=0"), 1))


def test_play_covers_the_reach_and_drive_the_screen():
    scenario = game("learning.samples=300")
    play, drive = scenario.record_demonstrations()
    hand = play.table[["command.x", "command.y"]].to_numpy() - [0.5, 0.0]
    assert np.abs(hand).max() <= 0.0425 + 1e-9
    assert (np.abs(hand).max(axis=0) > 0.038).all()
    car = drive.table[["car.x", "car.y"]].to_numpy()
    assert (np.ptp(car, axis=0) > [300, 200]).all()
    assert set(drive.table.columns).isdisjoint({"hand.x", "command.x"})  # the driver needs no arm
    assert set(play.table.columns).isdisjoint({"car.x", "joystick->car"})


def test_a_known_first_link_is_not_played_again():
    pieces = list(game("learning.samples=30").record_demonstrations(known={"hand->joystick"}))
    assert [p.name for p in pieces] == ["drive"]


def test_another_mount_is_another_world():
    """The joystick remounted (turned 25 degrees): the same hand positions give other axes."""

    def axes(*settings: str) -> np.ndarray:
        play = game("learning.samples=30", "noise.scale=0", *settings).record_play(30)
        return play.table[["joystick.x_axis", "joystick.y_axis"]].to_numpy()

    assert np.abs(axes() - axes("joystick.yaw_deg=25")).max() > 0.2


def test_hand_over_the_knob_gives_the_tilt():
    scenario = game()
    tilt = np.radians([[10.0, -20.0], [0.0, 0.0]])
    back = scenario.config.joystick.mount().tilt_from_knob(scenario.hand_for_tilt(tilt))
    np.testing.assert_allclose(back, tilt, atol=1e-12)
    assert np.abs(axes_from_tilt(back)).max() < 1


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("play.reach=.inf", "play.reach is inf"),
        ("play.reach=.nan", "play.reach is nan"),
        ("joystick.handle=-0.1", "joystick.handle is -0.1"),
        ("start.axes=[0, 1.5]", "start.axes is .*; give 2 numbers from -1 to 1"),
        ("start.axes=[0, .nan]", "start.axes is .*; give 2 numbers from -1 to 1"),
        ("joystick.pivot=[1, 2]", "joystick.pivot is .*; give 3 numbers from -2 to 2, in m"),
    ],
)
def test_numbers_that_can_t_work_are_refused(setting, message):
    with pytest.raises(InputError, match=message):
        game(setting)
