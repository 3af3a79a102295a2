"""Gymnasium's CarRacing behind the joystick: the same game as the original, its state, paths, and what is refused."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from ichain_drake.demonstrations import data_hash
from ichain_drake.errors import InputError
from ichain_drake.learning.library import save_chain
from ichain_drake.objects import check_object
from ichain_drake.runs.library import load
from ichain_drake.runs.paths.choice import choose_paths
from ichain_drake.runs.paths.evaluation import check_evaluation
from ichain_drake.runs.paths.link_accuracy import learn_first_link
from ichain_drake.runs.paths.output import make_recording
from ichain_drake.runs.paths.result import PathRun
from ichain_drake.runs.paths.run import run_paths
from ichain_drake.scenarios import build_world
from ichain_drake.systems import load_scenario
from ichain_drake.systems.car_game.scenario import CarGame
from ichain_drake.systems.car_racing.scenario import CAR_WIDTH, CarRacing
from ichain_drake.timing import FRAME

gymnasium = pytest.importorskip("gymnasium", reason="Gymnasium is missing: pip install 'ichain_drake[games]'")
pytest.importorskip("Box2D", reason="Box2D is missing: pip install 'ichain_drake[games]'")

STICK = {"joystick": np.zeros(4)}
ON = {"joystick": np.float64(1.0)}


def racing(*settings: str, seed: int = 0) -> CarRacing:
    scenario = load_scenario("car_racing", settings, "ideal", seed)
    assert isinstance(scenario, CarRacing)
    return scenario


def test_it_is_the_same_game_as_the_original() -> None:
    """Beside the registered environment, pixels and all; the solver's memory between steps makes the difference."""
    scenario = racing("game.steps=1", "game.frames=1")
    environment = scenario.environment
    original = gymnasium.make("CarRacing-v3")
    original.reset(seed=scenario.config.game.track)
    state = environment.start(0)
    rewards = []
    for k in range(45):
        steering, throttle = 0.5 * np.sin(k / 6), 0.9 if k % 20 < 15 else -0.4
        action = np.array([0.4 * steering, 0.15 * throttle, -0.15 * throttle])
        state = environment.step(state, action, np.zeros(0))
        _, reward, *_ = original.step(np.clip(action, [-1, 0, 0], 1).astype(np.float32))
        rewards.append((state[environment.index("reward")], reward))
    hull = original.unwrapped.car.hull
    place = state[:2] - np.array(scenario.size) / 2
    np.testing.assert_allclose(place, hull.position, atol=2e-3)
    assert np.hypot(*state[3:5]) == pytest.approx(np.linalg.norm(hull.linearVelocity), abs=0.01)
    assert state[3] > 5.0
    # A tile counts in the state in which a wheel comes to it, in the original a step later.
    ours, theirs = np.array(rewards).T
    assert abs(ours.sum() - theirs.sum()) < 1000 / len(original.unwrapped.track) + 1e-6
    assert theirs.sum() > 10


def test_the_game_keeps_the_contract_of_objects() -> None:
    scenario = racing()
    world = scenario.make_world(choose_paths(scenario, ["lap"])["lap"], 0)
    game = scenario.make_target(scenario.idle_state(), world.objects["car"].settings)
    check_object(game)
    assert game.state_space.observable.names == ("x", "y", "heading", "speed", "drift", "yaw_rate")


def test_a_step_depends_on_the_state_alone() -> None:
    """Whatever was calculated in between, on and off the road; also on a game that was opened anew."""
    scenario = racing()
    environment = scenario.environment
    road = scenario.reference_paths()["lap"]
    start = scenario.car_at(road[50] + [6.0, 3.0], 0.4, 14.0)

    def drive(on: CarRacing, state: np.ndarray) -> np.ndarray:
        for k in range(40):
            state = on.environment.step(state, np.array([0.3 * np.sin(k / 4), 0.1, 0.05 * (k % 9 == 0)]), np.zeros(0))
        return state

    once = drive(scenario, start)
    drive(scenario, scenario.car_at(road[200], 2.0, 25.0))
    np.testing.assert_array_equal(drive(scenario, start), once)
    np.testing.assert_array_equal(drive(racing(), start), once)
    visited = environment.inner(once)[-7:].sum() - environment.inner(start)[-7:].sum()
    assert visited > 0  # it crossed the road: tiles are part of the state


def test_a_cloned_world_goes_on_in_the_same_way() -> None:
    world = build_world(racing(), path="weave")
    simulator = Simulator(world)
    world.GetInputPort("hand_command").FixValue(simulator.get_mutable_context(), [0.51, 0.02])
    simulator.AdvanceTo(0.5)
    middle = simulator.get_context().Clone()
    ends = []
    for _ in range(2):
        again = Simulator(world, middle.Clone())
        again.AdvanceTo(1.5)
        ends.append(world.GetOutputPort("car.state").Eval(again.get_context()))
    np.testing.assert_array_equal(*ends)
    assert np.hypot(*(ends[0][:2] - world.GetOutputPort("car.state").Eval(middle)[:2])) > 5.0


def test_a_push_moves_the_whole_car() -> None:
    """Set what is measured, in the middle of a bend, and the game goes on from there."""
    scenario = racing()
    state = scenario.car_at(np.array([100.0, 500.0]), 0.3, 12.0)
    for _ in range(20):
        state = scenario.environment.step(state, np.array([0.2, 0.05, 0.0]), np.zeros(0))
    world = scenario.build_world(state, [0.0, 0.0], 0)
    car = world.objects["car"]
    context = car.CreateDefaultContext()
    pushed = state.copy()
    pushed[:3] += [3.0, -2.0, 0.7]
    car.set_state(context, pushed)
    np.testing.assert_allclose(car.get_state(context)[:6], pushed[:6], atol=1e-4)
    one, two = state, car.get_state(context)
    for _ in range(15):
        one, two = (scenario.environment.step(s, np.array([0.2, 0.05, 0.0]), np.zeros(0)) for s in (one, two))
    c, s = np.cos(0.7), np.sin(0.7)
    moved = np.array([[c, -s], [s, c]]) @ (one[:2] - state[:2])
    np.testing.assert_allclose(two[:2] - pushed[:2], moved, atol=5e-3)
    np.testing.assert_allclose(two[3:6], one[3:6], atol=5e-3)


def test_the_clock_is_the_games_own() -> None:
    """50 steps a second: in 30 frames as many, and a rolling car goes as far as its speed says."""
    scenario = racing()
    state = start = scenario.car_at(np.array([100.0, 500.0]), 0.3, 12.0)
    game = scenario.make_target(start, scenario.build_world(start, [0, 0], 0).objects["car"].settings)
    for _ in range(30):
        state = game.step(state, STICK, ON, np.zeros(0), FRAME)
    assert state[game.state_space.index("steps")] == 50
    np.testing.assert_allclose(state[:2] - start[:2], 12.0 * np.array([np.cos(0.3), np.sin(0.3)]), atol=0.02)
    np.testing.assert_allclose(state[2:6], [0.3, 12.0, 0.0, 0.0], atol=1e-3)
    slow = racing("game.steps=1", "game.frames=2").environment
    assert "phase" in slow.space.names


def test_a_lap_ends_the_episode() -> None:
    scenario = racing()
    environment = scenario.environment
    lap = scenario.reference_paths()["lap"]
    heading = np.arctan2(*(lap[41] - lap[40])[::-1])
    state = scenario.car_at(lap[40], heading, 15.0)
    space = environment.space
    tiles = [k for k, name in enumerate(space.names) if name.startswith("visited_")]
    count = len(environment.env.unwrapped.road)
    left = 44  # all but one tile ahead
    bits = np.array([k != left for k in range(count)] + [False] * (-count % 48), dtype=float)
    state[tiles] = bits.reshape(-1, 48) @ 2.0 ** np.arange(48)
    ended = []
    for _ in range(40):
        state = environment.step(state, np.zeros(3), np.zeros(0))
        ended.append(state[environment.index("terminated")])
    assert 0.0 in ended
    assert ended[-1] == 1.0
    assert np.hypot(*(state[:2] - lap[left])) < 8.0  # it stays where it ended
    assert state[3] == pytest.approx(15.0, abs=0.5)


def test_off_the_playfield_the_episode_ends() -> None:
    scenario = racing()
    environment = scenario.environment
    state = scenario.car_at(np.array([660.0, 300.0]), 0.0, 30.0)
    for _ in range(20):
        state = environment.step(state, np.zeros(3), np.zeros(0))
    assert state[environment.index("terminated")] == 1.0
    assert 666.0 < state[0] < 668.0


def test_nothing_is_drawn_unless_asked_for() -> None:
    environment = racing().environment
    assert environment.env.render_mode is None
    observation, *_ = environment.env.step(np.zeros(3, np.float32))
    assert observation is None


def test_the_weave_stays_on_the_road() -> None:
    scenario = racing()
    lap, weave = (scenario.reference_paths()[k] for k in ("lap", "weave"))
    off = np.array([np.linalg.norm(lap - p, axis=1).min() for p in weave])
    assert 2.0 < off.max() < 40 / 6 - CAR_WIDTH
    for path in (lap, weave):
        assert (path > 0).all()
        assert (path < scenario.size[0]).all()


def test_tracks_differ_by_their_seed() -> None:
    seven, eight = (racing(f"game.track={k}").reference_paths()["lap"] for k in (7, 8))
    assert len(seven) != len(eight) or not np.allclose(seven, eight)
    np.testing.assert_array_equal(racing(seed=3).reference_paths()["lap"], seven)


def test_the_car_games_hand_serves_here(tmp_path: Path) -> None:
    """The link hand -> joystick comes from the library of another game; only joystick -> car is learned."""
    library = tmp_path / "library"
    other = load_scenario("car_game", ["learning.samples=150"], "ideal")
    assert isinstance(other, CarGame)
    pieces = [other.record_play(150)]
    save_chain(
        learn_first_link(other, pieces, other.config.learning.candidates()), library, other.name, data_hash(pieces)
    )

    scenario = racing("learning.samples=250", "learning.estimator=polynomial(degree=2)")
    known = load(library, scenario)
    assert known.names == ("hand->joystick",)
    run = PathRun(scenario, choose_paths(scenario, ["weave"]))
    run_paths(run, known=known)
    report = run.report()
    assert [p.name for p in run.pieces] == ["drive"]
    assert report["models"]["hand->joystick"]["source"] != "demonstrations"
    assert report["models"]["joystick->car"]["source"] == "demonstrations"
    assert report["goal_reached"]
    assert report["given"]["half_car_width"] == CAR_WIDTH / 2
    assert report["metrics"]["mean_error_px"] < report["given"]["half_car_width"] / 4
    assert report["metrics"]["unit"] == "unit"
    assert report["metrics"]["oracle_error_px"] is None
    assert report["metrics"]["oracle_reason"].startswith("car_racing has no oracle: the true game")
    json.dumps(report, allow_nan=False)
    car = make_recording(run).spaces["car"]
    assert {"speed", "terminated", "reward"} <= set(car.names)
    assert not [n for n in car.names if n.startswith(("hull", "wheel", "visited"))]


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("game.steer=0", "game.steer is 0.* up to 1"),
        ("game.gas=1.5", "game.gas is 1.5"),
        ("game.track=-1", "game.track is -1"),
        ("game.steps=0", "game.steps is 0; give a whole number from 1"),
        ("game.frames=-3", "game.frames is -3"),
        ("play.reach=0", "play.reach is 0"),
    ],
)
def test_settings_that_make_no_sense_are_refused(setting: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        racing(setting)


def test_there_is_no_oracle_to_ask_for() -> None:
    with pytest.raises(InputError, match="car_racing has no oracle"):
        check_evaluation(racing(), 1, ["oracle"])


def test_without_the_extra_it_is_listed_and_says_what_to_install() -> None:
    code = (
        "import sys; sys.modules['gymnasium'] = None; from ichain_drake.cli.main import main\n"
        "print(main(['list'])); print(main(['run', 'car_racing']))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    *listed, status, refused = done.stdout.splitlines()
    assert any(line.startswith("car_racing") for line in listed)
    assert (status, refused) == ("0", "2")
    (line,) = done.stderr.strip().splitlines()
    assert "pip install 'ichain_drake[games]'" in line
