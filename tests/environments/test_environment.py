"""Systems as Gymnasium environments: the contract, the same world as everywhere, rewards and ends."""

import warnings

import numpy as np
import pytest

import ichain_drake as ic
from ichain_drake.environments.registration import SYSTEMS, environment_id
from ichain_drake.systems import SCENARIOS

gymnasium = pytest.importorskip("gymnasium", reason="Gymnasium is missing: pip install 'ichain_drake[games]'")


def test_every_system_is_registered() -> None:
    assert set(SYSTEMS) == set(SCENARIOS)
    assert environment_id("two_dispensers") == "ichain/TwoDispensers-v0"
    assert {environment_id(s) for s in SYSTEMS} <= set(gymnasium.registry)


@pytest.mark.parametrize("system", SYSTEMS)
def test_gymnasium_finds_nothing_wrong(system: str) -> None:
    from gymnasium.utils.env_checker import check_env

    if system == "car_racing":
        pytest.importorskip("Box2D", reason="Box2D is missing: pip install 'ichain_drake[games]'")
    env = gymnasium.make(environment_id(system))
    with warnings.catch_warnings():  # units and noise are no normalised box, on purpose
        warnings.filterwarnings("ignore", message=".*Box (action|observation) space")
        check_env(env.unwrapped)


def test_steps_are_the_ticks_of_a_recorded_demonstration() -> None:
    scenario = ic.load_scenario("water_dispenser", physics="ideal")
    env = ic.make_env(scenario)
    env.reset(seed=3)
    scenario.seed = env.scenario.seed
    commands = np.tile(env.command, (12, 1))
    commands[2:, 2] += 0.03
    piece = ic.record(scenario.make_world(0), ic.Commands(commands), 12, tuple(scenario.graph.objects), "moves")
    rows, given = env.imitation([piece])
    np.testing.assert_array_equal(given, commands[: len(given)])
    observed = [env.reset(seed=3)[0], *(env.step(c)[0] for c in commands)]
    np.testing.assert_array_equal(observed[: len(rows)], rows)


def test_a_seed_decides_about_all_episodes_that_follow() -> None:
    def starts(seed: int) -> list[float]:
        env = ic.make_env("car_game")
        first = env.reset(seed=seed)[0]
        return [*first, *env.reset()[0]]

    assert starts(1) == starts(1)
    assert starts(1) != starts(2)
    assert starts(1)[: len(starts(1)) // 2] != starts(1)[len(starts(1)) // 2 :]


def test_the_seed_of_an_episode_is_that_of_a_run() -> None:
    env = ic.make_env("water_dispenser", settings="noise.scale=0")
    seen, info = env.reset(seed=5)
    world = ic.load_scenario("water_dispenser", "noise.scale=0", "ideal", info["seed"]).make_world(0)
    cup = world.GetOutputPort("cup.measured").Eval(world.CreateDefaultContext())
    names = [n.partition(".")[0] for n in env.observation_names]
    np.testing.assert_array_equal(seen[np.array(names) == "cup"], cup)


def test_a_vector_of_environments_steps() -> None:
    envs = gymnasium.make_vec("ichain/CarGame-v0", num_envs=2, vectorization_mode="sync", path="eight")
    seen, info = envs.reset(seed=[1, 2])
    assert not np.array_equal(seen[0], seen[1])
    seen, rewards, *_ = envs.step(envs.action_space.sample())
    assert seen.shape == (2, 11)
    assert rewards.shape == (2,)
    assert info["valid"].shape == (2, 3)


def test_commands_out_of_bounds_are_taken_to_them_and_what_counts_is_rounded() -> None:
    env = ic.make_env("water_dispenser")
    env.reset(seed=0)
    env.step(np.full(len(env.command_names), 10.0))
    np.testing.assert_array_equal(env.command, env.action_space.high)
    action = env.action_space.high.copy()
    action[env.command_names.index("grip")] = 0.4
    env.step(action)
    assert env.command[env.command_names.index("grip")] == 0.0


def test_it_steps_with_the_arm_in_it() -> None:
    env = ic.make_env("kettle", "contact")
    seen, _ = env.reset(seed=0)
    after, reward, ended, late, info = env.step(env.command)
    assert np.abs(after - seen).max() < 0.2, "a hand that is told to stay moved"
    assert (reward, ended, late, info["success"]) == (0.0, False, False, False)


def test_a_late_episode_is_cut_short_and_a_lost_path_ends() -> None:
    env = ic.make_env("car_game", settings="noise.scale=0")
    env.reset(seed=0)
    env._judge.limit = 2
    rest = env.command
    _, _, ended, late, info = env.step(rest)
    assert not late
    *_, ended, late, info = env.step(rest)
    assert late
    assert not ended
    assert info["time"] == pytest.approx(2 * ic.TICK)
    env._judge.limit = 10_000
    while not ended:
        *_, ended, late, info = env.step(rest)
    assert not info["success"]
    assert info["time"] < 120


def test_nothing_runs_before_a_reset_or_after_closing() -> None:
    env = ic.make_env("car_game")
    action = env.action_space.sample()
    with pytest.raises(ic.InputError, match="call reset first"):
        env.step(action)
    env.reset()
    with pytest.raises(ic.InputError, match="action: x is not a finite number"):
        env.step(np.array([np.nan, 0.0]))
    env.close()
    with pytest.raises(ic.InputError, match="call reset first"):
        env.step(action)


def test_what_it_can_not_do_is_refused() -> None:
    with pytest.raises(ic.InputError, match="has no path 'nine'; it has"):
        ic.make_env("car_game", path="nine")
    with pytest.raises(ic.InputError, match="follows paths; leave goal"):
        ic.make_env("car_game", goal="car.x >= 1")
    with pytest.raises(ic.InputError, match="lookahead 0: give"):
        ic.make_env("car_game", lookahead=0)
    with pytest.raises(ic.InputError, match="has no paths; leave path 'eight' out"):
        ic.make_env("water_dispenser", path="eight")


def test_pieces_without_commands_teach_nothing() -> None:
    env = ic.make_env("car_game")
    piece = env.scenario.record_drive(3)
    bare = ic.Demonstration(piece.table.drop(columns="command.x"), piece.units, "bare")
    with pytest.raises(ic.InputError, match=r"bare: column command.x is missing"):
        env.imitation([bare])
    with pytest.raises(ic.InputError, match="no piece is given"):
        env.imitation([])


def test_without_gymnasium_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "gymnasium", None)
    with pytest.raises(ic.InputError, match=r"pip install 'ichain_drake\[games\]'"):
        ic.make_env("car_game")
