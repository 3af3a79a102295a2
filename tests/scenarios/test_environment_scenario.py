"""A goal in somebody else's environment, by public names alone: recorded, learned, planned, reached, reported."""

import json
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("gymnasium", reason="Gymnasium is missing: pip install 'ichain_drake[games]'")

import push_environment
from push_environment import CrateScenario

import ichain_drake as ic
from ichain_drake.cli.main import main

GOAL = ("crate.x >= 0.8", "not claw->crate")


@pytest.fixture(scope="module")
def model() -> ic.InteractionModel:
    scenario = CrateScenario(seed=0)
    return ic.learn(scenario.graph, list(scenario.record_demonstrations()))


@pytest.mark.parametrize("seed", [10, 11, 12])
def test_what_was_learned_on_one_seed_reaches_the_goal_on_others(model: ic.InteractionModel, seed: int) -> None:
    run = ic.GraphRun(CrateScenario(seed=seed), GOAL)
    ic.run_graph(run, known=model)
    assert run.goal_reached, run.reason
    assert run.log is not None
    assert run.log.states["crate"][-1, 0] >= 0.8
    given = run.report()["given"]
    assert given["environment"]["actions"] == {"0: x": 1.0, "1: y": 1.0, "2: grip": 1.0}
    assert "robot" not in given


def test_the_command_runs_it_by_its_file_in_its_own_physics(tmp_path: Path) -> None:
    name = f"{Path(push_environment.__file__)}:CrateScenario"
    report = tmp_path / "report.json"
    assert main(["run", name, "--goal", GOAL[0], "--report", str(report), "-o", str(tmp_path / "run")]) == 0
    found = json.loads(report.read_text())
    assert found["physics"] == "environment"
    assert found["goal_reached"]
    assert (tmp_path / "run" / "playback.html").stat().st_size > 1000


def test_what_needs_no_physics_works_without_naming_one(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    name = f"{Path(push_environment.__file__)}:CrateScenario"
    demos, library = tmp_path / "demos", tmp_path / "library"
    assert main(["graph", name]) == 0
    assert "claw" in capsys.readouterr().out
    assert main(["teach", name, "-o", str(demos)]) == 0
    assert main(["learn", name, "--demos", str(demos), "-o", str(library)]) == 0
    assert [f.name for f in library.iterdir()] == ["graph.crate"]


def test_another_physics_is_refused_and_an_environment_is_none_of_ours() -> None:
    with pytest.raises(ic.InputError, match="physics 'ideal': choose environment"):
        CrateScenario(physics="ideal")
    with pytest.raises(ic.InputError, match="physics 'environment': choose ideal, arm or contact"):
        ic.load_scenario("car_game", physics="environment")


def test_its_world_alone_and_as_an_environment_again_begin_at_the_start_of_a_run() -> None:
    scenario = CrateScenario("noise.scale=0", seed=4)
    start = scenario.start_states(scenario.start(0))
    world = ic.build_world(scenario)
    context = world.CreateDefaultContext()
    np.testing.assert_array_equal(world.GetOutputPort("crate.state").Eval(context)[:2], start["crate"])
    env = ic.make_env(scenario, goal=GOAL)
    seen, info = env.reset(seed=1)
    again = CrateScenario("noise.scale=0", seed=info["seed"])
    np.testing.assert_array_equal(seen, np.concatenate(list(again.start_states(again.start(0)).values())))
    assert env.step(seen[:3])[1] == 0.0
