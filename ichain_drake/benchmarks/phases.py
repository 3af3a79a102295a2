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
from ichain_drake.runs.goals.run import run_graph
from ichain_drake.runs.learn import learn
from ichain_drake.runs.output import write_pictures_of, write_playback_of
from ichain_drake.runs.paths.following import follow, oracle_follow
from ichain_drake.runs.paths.output import write_report
from ichain_drake.runs.paths.result import PathRun
from ichain_drake.runs.pieces import check_settings, record_pieces
from ichain_drake.runs.run import start_run
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
    check_settings(scenario)
    run = start_run(scenario)
    with threadpool_limits(limits=1):
        with clock.phase("record"):
            record_pieces(scenario, run.pieces)
        with clock.phase("learn"):
            run.model = learn(scenario, run.pieces)
        if isinstance(run, PathRun):
            watch, planning, simulated = _follow(run, clock)
        else:
            with timed_callbacks() as watch, clock.phase("run"):
                run_graph(run, known=run.model)
            planning, simulated = run.plan_seconds, 0.0 if run.log is None else float(run.log.times[-1])
        with clock.phase("write"), tempfile.TemporaryDirectory(prefix="ichain-") as name:
            folder = Path(name)
            write_report(run.report(), folder / "report.json")
            write_playback_of(run, folder / "playback.html")
            write_pictures_of(run, folder)
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


def _follow(run: PathRun, clock: _Clock) -> tuple[Stopwatch, float, float]:
    """Follow every path: the stopwatch, nothing planned, and simulated seconds."""
    scenario, given = run.scenario, run.scenario.config.control
    assert run.model is not None
    chain = run.model.for_paths()
    with clock.phase("validate"):
        run.controller = make_controller(chain, given.method, scenario.path_limits(), given.candidates())
    with timed_callbacks() as watch, clock.phase("run"):
        for number, (name, path) in enumerate(run.paths.items()):
            run.results.append(follow(scenario, chain, run.controller, name, path, number))
    if not scenario.no_oracle:
        with clock.phase("oracle"):
            for number, (name, path) in enumerate(run.paths.items()):
                oracle_follow(scenario, name, path, number)
    return watch, 0.0, sum(float(result.log.times[-1]) for result in run.results)
