"""Who watches a run changes nothing; who adjusts it changes what the slider says, and can stop it."""

from types import SimpleNamespace

import numpy as np
import pytest

from ichain_drake.control.tracking.path import TimedPath
from ichain_drake.runs import live
from ichain_drake.runs.live import LiveRun
from ichain_drake.simulation.commands import Commands
from ichain_drake.simulation.episode import Episode
from ichain_drake.simulation.recorder import RecordingInterrupted, record
from ichain_drake.simulation.watching import present_watcher, watched_by
from ichain_drake.systems import load_scenario


class Eye:
    def __init__(self, stop_at=10**9, then=None):
        self.begun, self.seen, self.stop_at, self.then = 0, [], stop_at, then or (lambda episode, frame: None)

    def begin(self, episode):
        self.begun += 1

    def frame(self, episode):
        self.seen.append(episode.context.get_time())
        self.then(episode, len(self.seen))
        return len(self.seen) >= self.stop_at


@pytest.fixture(scope="module")
def scenario():
    return load_scenario("car_game", (), "ideal", 0)


def drive(scenario, ticks=6):
    world = scenario.build_world(np.array([400.0, 300.0, 0.0, 30.0, 0.0, 0.0]), [0.0, 0.4], 960)
    hand = np.array([[0.5, 0.02], [0.51, 0.02], [0.49, 0.03]])
    return Episode(world, Commands(hand)), ticks


def test_a_watched_episode_is_the_same(scenario):
    episode, ticks = drive(scenario)
    episode.run(ticks)
    eye = Eye()
    watched, _ = drive(scenario)
    with watched_by(eye):
        watched.run(2)
        watched.run(ticks - 2)
    assert present_watcher() is None
    assert eye.begun == 1
    assert np.array_equal(eye.seen, episode.log().times[1:])
    for name, states in episode.log().states.items():
        assert np.array_equal(states, watched.log().states[name]), name


def test_stopping_keeps_what_was_recorded(scenario):
    world = scenario.build_world(np.array([400.0, 300.0, 0.0, 30.0, 0.0, 0.0]), [0.0, 0.4], 960)
    with watched_by(Eye(stop_at=25)), pytest.raises(RecordingInterrupted) as stopped:
        record(world, Commands(np.array([[0.5, 0.02]])), 30, ("joystick", "car"), "piece")
    assert len(stopped.value.piece) == 3


def adjust(scenario, name, value, at=15):
    item = next(a for a in scenario.adjustables() if a.name == name)

    def then(episode, frame):
        if frame == at:
            item.apply(episode, value)

    return Eye(then=then)


def test_a_push_displaces_once(scenario):
    episode, ticks = drive(scenario)
    episode.run(ticks)
    pushed, _ = drive(scenario)
    with watched_by(adjust(scenario, "push car y [px]", 12.0)):
        pushed.run(ticks)
    moved = pushed.log().states["car"] - episode.log().states["car"]
    assert (moved[:16] == 0).all()
    assert moved[16:, 1] == pytest.approx(12.0, abs=1e-9)


def test_with_noise_off_a_resting_stick_reads_one_value(scenario):
    noisy, ticks = drive(scenario)
    noisy.run(ticks)
    quiet, _ = drive(scenario)
    with watched_by(adjust(scenario, "noise scale", 0.0)):
        quiet.run(ticks)
    resting = slice(45, 60)
    assert np.ptp(noisy.log().measured["joystick"][resting], axis=0).min() > 0
    assert np.ptp(quiet.log().measured["joystick"][resting], axis=0).max() == 0


def test_the_target_path_moves_with_its_slider(scenario):
    path = TimedPath(scenario.reference_paths()["eight"], scenario.path_limits())
    moved = path.shifted(np.array([10.0, -5.0]))
    assert moved.at_time(np.array([1.0])) == pytest.approx(path.at_time(np.array([1.0])) + [10.0, -5.0])
    assert np.array_equal(moved.time, path.time)
    assert not np.array_equal(moved.points, path.points)


def test_live_run_begins_shows_and_ends_without_a_browser(scenario):
    live = LiveRun(scenario)
    episode, ticks = drive(scenario)
    with watched_by(live):
        episode.run(ticks)
    assert live.report() == {"realtime": False, "changes": []}
    assert live.view.meshcat.HasPath("/drake/car/screen/episode0/trail0")
    live.view.meshcat.SetSliderValue("noise scale", 2.0)
    again, _ = drive(scenario)
    with watched_by(live):
        again.run(1)
    assert [(c["what"], c["value"], c["episode"]) for c in live.changes] == [("noise scale", 2.0, 2)]
    assert again.world.objects["car"].settings.noise_scale == 2.0
    live.close()


def test_a_goal_scenario_lets_its_goal_be_moved():
    names = [a.name for a in load_scenario("water_dispenser", (), "ideal", 0).adjustables()]
    assert names[-2:] == ["cup.water >=", "cup.temperature >="]


def test_speed_is_that_since_the_episode_began(monkeypatch):
    monkeypatch.setattr(live.time, "monotonic", lambda: 104.0)
    shown = []
    run = SimpleNamespace(
        _start=(1.0, 100.0), _in_force={}, _adjustables=(), _clock=None, _line="goes",
        view=SimpleNamespace(page=SimpleNamespace(show=lambda *args: shown.append(args))),
    )  # fmt: skip
    LiveRun._tell(run, 9.0)
    assert shown[0][2] == {"time": "9.0 s", "speed": "2.0 x real time"}
