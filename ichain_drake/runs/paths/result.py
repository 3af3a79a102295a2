"""What a run of a path scenario holds and reports."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ichain_drake.control.tracking.chain import ChainController
from ichain_drake.control.tracking.path import TimedPath
from ichain_drake.demonstrations import Demonstration
from ichain_drake.learning import InteractionModel
from ichain_drake.learning.chain.chain import LearnedChain
from ichain_drake.runs.provenance import given_of, versions
from ichain_drake.scenarios.base import PathScenario
from ichain_drake.simulation.episode import EpisodeLog
from ichain_drake.timing import FRAMES_PER_TICK


@dataclass(frozen=True)
class PathResult:
    """One followed path.

    Attributes:
        name: of the path.
        path: the timed path.
        log: everything logged.
        completed: whether all of it was followed and its end reached; see `Arrival`.
        error: mean distance of all executed 30 Hz positions to the sampled path, in its unit.
        paper_metric: the paper's metric (sec. IV) on the same run.
        oracle_error: the oracle's `error` under the same noise; NaN if there is none.
        oracle_reason: why there is none; empty where there is.
        reason: why it was not completed; empty if it was.
    """

    name: str
    path: TimedPath
    log: EpisodeLog
    completed: bool
    error: float
    paper_metric: float
    oracle_error: float = float("nan")
    oracle_reason: str = "the oracle was not run"
    reason: str = ""

    @property
    def control_steps(self) -> int:
        """Decisions taken."""
        return (len(self.log.times) - 1) // FRAMES_PER_TICK

    def metrics(self, unit: str) -> dict[str, Any]:
        """For the report. Its keys end in `px`, as for the games that they were made for; `unit` says what they are in.

        Args:
            unit: of the path, and so of every error.
        """
        return {
            "mean_error_px": self.error,
            "paper_metric_px": self.paper_metric,
            "completed": self.completed,
            "reason": self.reason,
            "oracle_error_px": None if np.isnan(self.oracle_error) else self.oracle_error,
            "oracle_reason": self.oracle_reason,
            "unit": unit,
        }


@dataclass
class PathRun:
    """A run of a path scenario, filled as it goes, so that an interrupted one keeps what it has.

    Attributes:
        scenario: what runs.
        paths: to follow, by name.
        pieces: demonstrations.
        model: learned from them, or from a library.
        controller: built from them.
        results: one per followed path.
        reason: why the goal was or was not reached.
        started: when, by the monotonic clock [s].
        smooth: whether corners of the paths are rounded as far as the demonstrations ask for.
        robot: address of a robot in another process; empty for a world in this one.
        line: how the line to it was.
    """

    scenario: PathScenario
    paths: dict[str, TimedPath] = field(default_factory=dict)
    pieces: list[Demonstration] = field(default_factory=list)
    model: InteractionModel | None = None
    controller: ChainController | None = None
    results: list[PathResult] = field(default_factory=list)
    reason: str = "interrupted"
    started: float = field(default_factory=time.monotonic)
    smooth: bool = False
    robot: str = ""
    line: dict[str, Any] = field(default_factory=dict)

    @property
    def chain(self) -> LearnedChain | None:
        """Learned links, once there are."""
        return None if self.model is None else self.model.chain

    @property
    def goal_reached(self) -> bool:
        """Whether every path was completed."""
        return len(self.results) == len(self.paths) > 0 and all(r.completed for r in self.results)

    def report(self) -> dict[str, Any]:
        """The contents of `report.json`."""
        scenario = self.scenario
        paths = {r.name: r.metrics(scenario.unit) for r in self.results}
        metrics: dict[str, Any] = {"paths": paths}
        if len(paths) == 1:
            metrics |= next(iter(paths.values()))
        return {
            "scenario": scenario.name,
            "physics": scenario.physics,
            "seed": scenario.seed,
            "goal_reached": self.goal_reached,
            "reason": self.reason,
            "control_steps": sum(r.control_steps for r in self.results),
            "sim_seconds": round(sum(float(r.log.times[-1]) for r in self.results), 6),
            "wall_seconds": time.monotonic() - self.started,
            "versions": versions(),
            "given": given_of(scenario),
            "models": {} if self.chain is None else models_report(self.chain),
            "control": {} if self.controller is None else control_report(self.controller),
            "metrics": metrics,
            **({"line": self.line} if self.robot else {}),
        }


def models_report(chain: LearnedChain) -> dict[str, Any]:
    """Per interaction: samples, simulated robot time, scores and where it came from."""
    out = {}
    for link in chain.links:
        inverse = link.best_inverse
        out[link.interaction.name] = {
            "samples": link.forward.samples,
            "robot_seconds": round(link.robot_seconds, 6),
            "cross_validation_score": link.forward.score,
            "inverse_cross_validation_score": inverse.score,
            "forward": str(link.forward.spec),
            "inverse": str(inverse.spec),
            "residual_std": {
                v: float(s)
                for v, s in zip(link.forward.model.child_space.names, link.forward.residual_std, strict=True)
            },
            "source": link.source,
        }
    return out


def control_report(controller: ChainController) -> dict[str, Any]:
    """What validation chose, and from what."""
    return {
        "method": controller.method,
        "chosen": controller.choice.label,
        "validation": {o.label: None if not np.isfinite(o.error) else o.error for o in controller.options},
    }
