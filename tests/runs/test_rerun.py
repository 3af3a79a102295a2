"""A run's recording for rerun: what is in the file is what is in the run's logs."""

from pathlib import Path

import numpy as np
import pytest
from rrd import read_rrd

import ichain_drake as ic
from ichain_drake.runs.output import write_rerun_of

pytest.importorskip("rerun", reason="rerun is missing: pip install 'ichain_drake[rerun]'")


def test_paths_are_one_after_another_with_all_that_was_measured_and_commanded(tmp_path: Path) -> None:
    scenario = ic.load_scenario("car_game", ["learning.samples=120"], physics="ideal")
    pieces = list(scenario.record_demonstrations())
    candidates = scenario.config.learning.candidates()
    chain = ic.learn_chain(pieces, scenario.graph, scenario.target, scenario.target_variables, candidates)
    limits = scenario.path_limits()
    controller = ic.make_controller(chain, "inverse", limits)
    points = scenario.reference_paths()["eight"]
    results = [
        ic.follow(scenario, chain, controller, name, ic.TimedPath(points[:end], limits), k)
        for k, (name, end) in enumerate([("short", 30), ("longer", 40)])
    ]
    run = ic.PathRun(scenario, results=results)
    assert write_rerun_of(run, tmp_path / "run.rrd") == [tmp_path / "run.rrd"]
    found = read_rrd(tmp_path / "run.rrd")

    first, second = (r.log for r in results)
    graph = scenario.graph
    wanted = {
        f"/command/{v}": [x.command[:, i] for x in (first, second)] for i, v in enumerate(graph.objects["hand"].names)
    }
    for name, space in graph.objects.items():
        seen = space.observable
        wanted |= {
            f"/measured/{name}/{v}": [x.measured[name][:, i] for x in (first, second)] for i, v in enumerate(seen.names)
        }
        shown = scenario.shown()[name]
        columns = space.indices(shown.names)
        wanted |= {
            f"/true/{name}/{v.name}": [x.states[name][:, columns[i]] for x in (first, second)]
            for i, v in enumerate(shown.variables)
            if not v.hidden
        }
    wanted["/active/hand->joystick"] = [(x.active["joystick"][:, 0] > 0.5).astype(float) for x in (first, second)]
    later = first.times[-1] - first.times[0] + 1.0
    times = np.concatenate([first.times - first.times[0], second.times - second.times[0] + later])
    for entity, values in wanted.items():
        at, got = found[entity, "Scalars:scalars"]
        np.testing.assert_array_equal(np.array(got)[:, 0], np.concatenate(values), err_msg=entity)
        np.testing.assert_allclose(at, times, atol=1e-6, err_msg=entity)
    assert {e.split("/")[1] for e, c in found if c == "Scalars:scalars"} == {
        "command",
        "measured",
        "true",
        "active",
        "shown",
    }
    assert found["/measured/car/x", "SeriesLines:names"][1] == [["car/x [px]"]]
    assert found["/command/x", "SeriesLines:names"][1] == [["x [m]"]]


def test_what_was_not_run_leaves_no_file(tmp_path: Path) -> None:
    path_run = ic.PathRun(ic.load_scenario("car_game", physics="ideal"))
    goal_run = ic.GraphRun(ic.load_scenario("water_dispenser", physics="ideal"), ("cup.water >= 0.3",))
    for run in (path_run, goal_run):
        assert write_rerun_of(run, tmp_path / "run.rrd") == []
    assert not list(tmp_path.iterdir())
