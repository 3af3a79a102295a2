"""Where the time of one run goes: by phase, and in its Diagram by system."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits

from ichain_drake import control
from ichain_drake.benchmarks.stopwatch import Stopwatch, timed_callbacks
from ichain_drake.control.tracking.chain import make_controller
from ichain_drake.learning.chain.chain import learn_chain
from ichain_drake.runs.goals import run as goals
from ichain_drake.runs.goals.knowledge import learn_graph
from ichain_drake.runs.goals.output import write_graph_pictures, write_graph_recording
from ichain_drake.runs.goals.settings import graph_spec
from ichain_drake.runs.paths.choice import choose_paths
from ichain_drake.runs.paths.following import follow, oracle_follow
from ichain_drake.runs.paths.output import write_pictures, write_recording, write_report
from ichain_drake.runs.paths.result import PathRun
from ichain_drake.runs.paths.run import check_settings, record_pieces, recorded_seconds
from ichain_drake.scenarios.base import PathScenario, Progress
from ichain_drake.scenarios.goal_scenario import GoalScenario

PHASES = ("record", "learn", "validate", "plan", "control", "objects", "plant", "oracle", "write")
"""In their order. `control`, `objects` and `plant` are one: the run; `plan` is what planning takes of it."""


class _Clock:
    """Wall and processor time of phases [s]."""

    def __init__(self, say: Progress) -> None:
        self.spent: dict[str, tuple[float, float]] = {}
        self._say = say

    @contextmanager
    def phase(self, name: str) -> Iterator[None]:
        self._say(name)
        wall, busy = time.perf_counter(), time.process_time()
        yield
        self.spent[name] = (time.perf_counter() - wall, time.process_time() - busy)


def profile_run(scenario: PathScenario | GoalScenario, say: Progress | None = None) -> dict[str, Any]:
    """Run a scenario once, as `ichain run --oracle` does, and see where the time goes.

    Args:
        scenario: what runs.
        say: called with a line before each phase.

    Returns:
        Plain data: `scenario`, `physics`, `seed`, `simulated_seconds` of the run, `phases` (`phase`, `wall` and
        `processor` seconds) and `systems` (`system`, `processor` seconds, `calls`), the most expensive first.
    """
    clock = _Clock(say or (lambda line: None))
    with threadpool_limits(limits=1), tempfile.TemporaryDirectory(prefix="ichain-") as folder:
        if isinstance(scenario, PathScenario):
            watch, planning, simulated = _paths(scenario, clock, Path(folder))
        else:
            watch, planning, simulated = _goal(scenario, clock, Path(folder))
    phases = clock.spent | _parts(watch, planning, *clock.spent.pop("run"))
    return {
        "scenario": scenario.name,
        "physics": scenario.physics,
        "seed": scenario.seed,
        "simulated_seconds": simulated,
        "phases": [{"phase": p, "wall": phases[p][0], "processor": phases[p][1]} for p in PHASES if p in phases],
        "systems": [
            {"system": name, "processor": seconds, "calls": calls} for name, (seconds, calls) in watch.by_name().items()
        ],
    }


def _parts(watch: Stopwatch, planning: float, wall: float, busy: float) -> dict[str, tuple[float, float]]:
    """The run's time by who spent it; its wall time is divided as its processor time is."""
    ours = control.__name__ + "."
    deciding = sum(seconds for system, seconds in watch.seconds.items() if type(system).__module__.startswith(ours))
    python = sum(watch.seconds.values())
    parts = {
        "plan": planning,
        "control": deciding - planning,
        "objects": python - deciding,
        "plant": busy - python,
    }
    return {name: (wall * part / busy, part) for name, part in parts.items() if name != "plan" or planning}


def _paths(scenario: PathScenario, clock: _Clock, folder: Path) -> tuple[Stopwatch, float, float]:
    """A run that follows paths: its stopwatch, nothing planned, and simulated seconds."""
    check_settings(scenario)
    run = PathRun(scenario, choose_paths(scenario))
    with clock.phase("record"):
        record_pieces(run, None, lambda line: None)
    with clock.phase("learn"):
        candidates, seconds = scenario.config.learning.candidates(), recorded_seconds(run.pieces, scenario.graph)
        target = scenario.target, scenario.target_variables
        run.chain = learn_chain(run.pieces, scenario.graph, *target, candidates, seconds)
    with clock.phase("validate"):
        given = scenario.config.control
        run.controller = make_controller(run.chain, given.method, scenario.path_limits(), given.candidates())
    with timed_callbacks() as watch, clock.phase("run"):
        for number, (name, path) in enumerate(run.paths.items()):
            run.results.append(follow(scenario, run.chain, run.controller, name, path, number))
    if not scenario.no_oracle:
        with clock.phase("oracle"):
            for number, (name, path) in enumerate(run.paths.items()):
                oracle_follow(scenario, name, path, number)
    with clock.phase("write"):
        write_report(run.report(), folder / "report.json")
        write_recording(run, folder / "playback.html")
        write_pictures(run, folder)
    return watch, 0.0, sum(float(result.log.times[-1]) for result in run.results)


def _goal(scenario: GoalScenario, clock: _Clock, folder: Path) -> tuple[Stopwatch, float, float]:
    """A run towards the scenario's own goal: its stopwatch, seconds of planning, and simulated seconds."""
    run = goals.GraphRun(scenario)
    spec = graph_spec(scenario.config)
    with clock.phase("record"):
        goals.record_pieces(run)
    with clock.phase("learn"):
        knowledge = learn_graph(run.pieces, scenario.graph, spec)
    with timed_callbacks() as watch, clock.phase("run"):
        goals.run_graph(run, knowledge=knowledge)
    with clock.phase("write"):
        write_report(run.report(), folder / "report.json")
        write_graph_recording(run, folder / "playback.html")
        write_graph_pictures(run, folder)
    return watch, run.plan_seconds, 0.0 if run.log is None else float(run.log.times[-1])
