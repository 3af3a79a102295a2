"""What one decision of a chain's controller costs, in the situations of a real run."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ichain_drake.benchmarks.diagram import make_episode
from ichain_drake.benchmarks.measure import seconds_a_call
from ichain_drake.control.tracking.chain import ChainController
from ichain_drake.control.tracking.move_to import MoveTo
from ichain_drake.control.tracking.path import TimedPath
from ichain_drake.learning.chain.chain import LearnedChain
from ichain_drake.scenarios.base import PathScenario
from ichain_drake.state import FloatArray

Situation = tuple[list[FloatArray], FloatArray, FloatArray]


@dataclass
class _Witness:
    """Decides as a policy does, and keeps what it was asked."""

    policy: MoveTo
    asked: list[Situation] = field(default_factory=list)

    @property
    def memory_size(self) -> int:
        return self.policy.memory_size

    @property
    def lookahead(self) -> int:
        return self.policy.lookahead

    def decide(
        self, states: Sequence[FloatArray], wanted: FloatArray, memory: FloatArray
    ) -> tuple[FloatArray, FloatArray, list[FloatArray]]:
        self.asked.append(([s.copy() for s in states], wanted.copy(), memory.copy()))
        return self.policy.decide(states, wanted, memory)


def benchmark_decisions(
    scenario: PathScenario, chain: LearnedChain, controllers: dict[str, ChainController], ticks: int, repeats: int
) -> dict[str, Any]:
    """Time of one decision, per method.

    Args:
        scenario: in `ideal` physics, where situations come from.
        chain: learned.
        controllers: by method.
        ticks: decisions of the run that are repeated.
        repeats: rounds.

    Returns:
        Per method: median and longest decision [ms].
    """
    _, points = next(iter(scenario.reference_paths().items()))
    path = TimedPath(points, scenario.path_limits())
    out: dict[str, Any] = {"objects": len(chain.names)}
    for method, controller in controllers.items():
        witness = _Witness(controller.policy)
        watched = ChainController(witness, method, controller.choice)  # type: ignore[arg-type]
        make_episode(scenario, chain, watched, path, log=False).run(ticks)
        times = [seconds_a_call(functools.partial(controller.policy.decide, *s), repeats, 1) for s in witness.asked]
        out[method] = {
            "decisions": len(times),
            "median_ms": 1000.0 * float(np.median(times)),
            "longest_ms": 1000.0 * float(np.max(times)),
        }
    return out
