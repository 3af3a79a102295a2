"""Scripted demonstrations as a Minari data set: written, loaded, and the same as in the environment."""

import sys
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("gymnasium", reason="Gymnasium is missing: pip install 'ichain_drake[games]'")
pytest.importorskip("minari", reason="Minari is missing: pip install 'ichain_drake[minari]'")

import gymnasium
import minari
import push_environment
import yaml
from push_environment import CrateScenario

import ichain_drake as ic
from ichain_drake.demonstrations import Demonstration
from ichain_drake.demonstrations.importing import import_logs, parse_map
from ichain_drake.demonstrations.reading import prepare
from ichain_drake.environments.minari_data import played_script, write_minari

GOAL = ("crate.x >= 0.7", "not claw->crate")


@pytest.fixture(autouse=True)
def store(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path))


def test_pieces_are_episodes_of_the_environment_and_what_was_recorded() -> None:
    scenario = CrateScenario("noise.scale=0", seed=2)
    env = ic.make_env(scenario, goal=GOAL)
    recorded = list(scenario.record_demonstrations())
    played = list(played_script(env))
    assert [p.name for p in played] == [p.name for p in recorded]
    for episode, piece in zip(played, recorded, strict=True):
        states = np.concatenate([piece.states(n, s) for n, s in scenario.graph.objects.items()], axis=1)
        np.testing.assert_allclose(episode.observations, states[: len(episode.observations)], atol=1e-12)
        assert abs(episode.rewards.sum()) <= 1.0
        assert episode.actions.shape == (len(episode.rewards), 3)
    assert any(p.terminated for p in played)
    assert not all(p.terminated for p in played)


def imported(folder: Path) -> list[Demonstration]:
    return import_logs("minari", folder, parse_map(yaml.safe_load((folder / "map.yaml").read_text()), "map"))


@pytest.mark.filterwarnings("ignore:.*is set to None")
def test_a_data_set_is_written_loaded_read_as_demonstrations_and_its_environment_made_again(tmp_path: Path) -> None:
    system = {"system": f"{Path(push_environment.__file__)}:CrateScenario", "physics": "environment", "goal": GOAL}
    gymnasium.register("ichain/Crate-v0", "ichain_drake.environments:make_env", kwargs=system)
    env = gymnasium.make("ichain/Crate-v0")
    write_minari(env, "ichain/crate-v0")
    found = minari.load_dataset("ichain/crate-v0")
    played = list(played_script(env.unwrapped))
    assert found.total_episodes == len(played)
    np.testing.assert_array_equal(found[0].observations, played[0].observations)
    np.testing.assert_array_equal(found[0].actions, played[0].actions)
    np.testing.assert_array_equal(found[0].rewards, played[0].rewards)
    assert bool(found[0].truncations[-1]) != bool(found[0].terminations[-1])
    assert found.recover_environment().unwrapped.scenario.name == "crate"
    pieces = imported(tmp_path / "ichain" / "crate-v0")
    names = [*env.unwrapped.observation_names, *[f"command.{n}" for n in env.unwrapped.command_names]]
    for piece, episode in zip(pieces, played, strict=True):
        after = np.concatenate([episode.actions, episode.actions[-1:]])
        np.testing.assert_array_equal(piece.table[names], np.concatenate([episode.observations, after], axis=1))
        (whole,) = prepare([piece], env.unwrapped.scenario.graph, resampled=False, say=print)
        whole.check(env.unwrapped.scenario.graph)
    for bad in ("ichain/crate-v0", "no version"):
        with pytest.raises(ic.InputError, match=f"data set '{bad}'"):
            write_minari(env, bad)


def test_paths_and_a_missing_extra_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(ic.InputError, match="car_game: its demonstrations follow no path"):
        write_minari(ic.make_env("car_game"), "ichain/car-v0")
    monkeypatch.setitem(sys.modules, "minari", None)
    with pytest.raises(ic.InputError, match=r"pip install 'ichain_drake\[minari\]'"):
        write_minari(ic.make_env("water_dispenser"), "ichain/d-v0")
