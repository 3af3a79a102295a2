"""The benchmarks' structure and what doesn't depend on the machine; never a time."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydrake.systems.framework import LeafSystem

from ichain_drake.benchmarks import BenchmarkSizes, format_profile, format_table, profile_run, run_benchmarks
from ichain_drake.benchmarks.chain_length import learn_dial, mirrored, synthetic_chain, synthetic_world
from ichain_drake.benchmarks.diagram import BarePlant
from ichain_drake.benchmarks.games import games_installed
from ichain_drake.benchmarks.measure import interleaved, line_fit
from ichain_drake.benchmarks.phases import PHASES
from ichain_drake.benchmarks.stopwatch import timed_callbacks
from ichain_drake.control.tracking.path import TimedPath
from ichain_drake.errors import InputError
from ichain_drake.scenarios.joystick_demonstrations import Player
from ichain_drake.simulation.episode import Episode
from ichain_drake.systems import load_scenario
from ichain_drake.systems.car_game.scenario import CarGame

ROOT = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def results() -> dict[str, Any]:
    sizes = BenchmarkSizes(
        ("learning.samples=80",), seconds=1.0, repeats=1, ticks=4, lengths=(2, 3, 4), trials=5, alone=2
    )
    lines: list[str] = []
    out = run_benchmarks(lines.append, sizes)
    assert len(lines) == 7
    return out


def test_results_are_plain_json(results: dict[str, Any]) -> None:
    assert json.loads(json.dumps(results, allow_nan=False)) == results


def test_trials_together_are_what_they_are_alone(results: dict[str, Any]) -> None:
    together = results["together"]
    assert (together["equal"], together["compared"], together["trials"]) == (2, 2, 5)
    assert together["ratio"] > 0
    assert "2 of 2 compared are equal to the bit" in format_table(results)


def test_the_bare_plant_repeats_the_run(results: dict[str, Any]) -> None:
    diagram = results["diagram"]
    assert diagram["playback_difference"] < 1e-9
    assert diagram["ratio"] > 0
    assert diagram["ratio_recorded"] > 0
    assert list(diagram["ratio_other_methods"]) == ["inverse"]
    assert {key: len(us) for key, us in diagram["steps_us"].items()} == {"bare": 4, "whole": 4}
    assert all(us > 0 for steps in diagram["steps_us"].values() for us in steps)
    systems = [row["system"] for row in diagram["breakdown"]]
    assert {"controller", "follower", "car", "joystick", "hand/motion", "hand/touch"} <= set(systems)
    assert systems[-1] == "plant and C++"


def test_python_runs_once_or_twice_a_frame_and_never_on_every_plant_step(results: dict[str, Any]) -> None:
    calls = {r["system"]: r["calls_a_second"] for r in results["diagram"]["breakdown"]}
    assert calls["hand/motion"] <= 4 * 30 + 3 * 3  # begin, plan, no more plan, update; the plans of a tick, made once
    assert calls["hand/touch"] <= 30
    assert calls["hand/hand_sensor"] <= 3  # at decisions alone


def test_decisions_chain_lengths_and_frozen_models(results: dict[str, Any]) -> None:
    decision = results["decision"]
    assert decision["objects"] == 3
    for method in ("predictive", "inverse"):
        assert decision[method]["decisions"] == 4
        assert 0 < decision[method]["median_ms"] <= decision[method]["longest_ms"]
    chain = results["chain_length"]
    assert chain["lengths"] == [2, 3, 4]
    assert set(chain["ms"]) == {"decision_predictive", "decision_inverse", "world_tick"} == set(chain["fit"])
    assert all(len(v) == 3 and min(v) > 0 for v in chain["ms"].values())
    for row in results["frozen_models"]:
        assert row["difference"] < 1e-9
        assert row["speedup"] > 0


def test_games_are_measured_where_they_are_installed(results: dict[str, Any]) -> None:
    games = results["games"]
    if not games_installed():
        assert games is None
        assert "the extra `games` is not installed" in format_table(results)
        return
    assert games["counted_steps"] == 50
    assert min(games["bare_steps"], games["steps"], games["diagram_steps"]) > 0


def test_the_table_shows_every_part(results: dict[str, Any]) -> None:
    text = format_table(results)
    for words in ("bare plant", "predictive", "R^2", "extra_trees", "hand/touch", "longest ms", "place in the frame"):
        assert words in text
    assert max(map(len, text.splitlines())) <= 120


def test_a_synthetic_chain_hands_the_wanted_state_down() -> None:
    chain = synthetic_chain(learn_dial(), 5)
    assert chain.names == ("o0", "o1", "o2", "o3", "o4")
    hand = np.array([0.15, -0.1])
    shown = hand
    for _ in range(4):
        shown = mirrored(shown)
    for link in reversed(chain.links):
        shown = link.best_inverse.model(np.zeros((1, 2)), shown[None])[0]
    np.testing.assert_allclose(shown, hand, atol=0.02)


def test_a_synthetic_world_passes_the_command_on() -> None:
    simulator = synthetic_world(4)
    simulator.AdvanceTo(1.0)
    world = simulator.get_system().GetSubsystemByName("world")
    context = world.GetMyContextFromRoot(simulator.get_context())
    expected = np.array([0.3, 0.1])
    for name in ("o1", "o2", "o3"):
        expected = mirrored(expected)
        np.testing.assert_allclose(world.GetOutputPort(f"{name}.state").Eval(context), expected, atol=0.05)


def test_a_stopwatch_restores_drake_and_counts_callbacks() -> None:
    before = LeafSystem.DeclareVectorOutputPort
    with timed_callbacks() as watch:
        simulator = synthetic_world(3)
    assert LeafSystem.DeclareVectorOutputPort is before
    watch.reset()
    simulator.AdvanceTo(1.0)
    calls = {system.get_name(): count for system, count in watch.calls.items()}
    assert calls["o1"] == calls["o2"] == 30
    assert all(seconds >= 0 for seconds in watch.seconds.values())


def test_a_robot_without_a_plant_is_refused() -> None:
    game = CarGame((), "ideal")
    world = game.make_world(TimedPath(game.reference_paths()["eight"], game.path_limits()), 0)
    player = Player(np.array([0.5, 0.0]), 0.01, 0.01, 3, [0])
    with pytest.raises(InputError, match="needs a robot with a plant"):
        BarePlant(Episode(world, player, log=False), 1.0)


def test_measures() -> None:
    fit = line_fit([1, 2, 4], [3.0, 5.0, 9.0])
    assert fit["slope"] == pytest.approx(2.0)
    assert fit["intercept"] == pytest.approx(1.0)
    assert fit["r_squared"] == pytest.approx(1.0)
    assert line_fit([1, 2, 3], [1.0, 1.0, 1.0])["r_squared"] == 0.0
    order: list[str] = []
    interleaved({n: lambda n=n: order.append(n) or 0.0 for n in "ab"}, 2)
    assert order == ["a", "b", "a", "b"]


class ShortGame(CarGame):
    """The car game with a path of a few seconds."""

    def reference_paths(self) -> dict[str, Any]:
        t = np.linspace(0.0, 1.0, 200)[:, None]
        return {"line": np.concatenate([300 + 100 * t, 300 + 0 * t], axis=1)}


@pytest.mark.parametrize("kind", ["path", "goal"])
def test_a_run_s_time_by_phase_and_by_system(kind: str) -> None:
    settings = ["learning.samples=60", "control.efforts=[0.05]", "control.horizons=[5]"]
    bath = ROOT / "examples" / "own_system" / "bath.py"
    scenario = ShortGame(settings, "ideal", 0) if kind == "path" else load_scenario(str(bath), (), "ideal", 0)
    asked = {"validate", "oracle"} if kind == "path" else {"plan"}
    said: list[str] = []
    found = profile_run(scenario, said.append)
    assert json.loads(json.dumps(found, allow_nan=False)) == found
    assert said[-1] == "write"
    phases = {row["phase"]: row["processor"] for row in found["phases"]}
    assert list(phases) == [p for p in PHASES if p not in {"validate", "oracle", "plan"} - asked]
    assert all(seconds > 0 for seconds in phases.values())
    systems = {row["system"]: row["processor"] for row in found["systems"]}
    assert {"controller", *scenario.graph.objects} - {scenario.graph.root} <= set(systems)
    assert sum(systems.values()) == pytest.approx(sum(phases.get(p, 0.0) for p in ("plan", "control", "objects")))
    text = format_profile(found)
    assert all(word in text for word in [*phases, *systems, "ideal physics, seed 0"])
