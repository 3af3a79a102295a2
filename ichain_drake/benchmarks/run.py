"""All benchmarks in one run, on one thread."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

from threadpoolctl import threadpool_limits

from ichain_drake.benchmarks.chain_length import benchmark_chain_length
from ichain_drake.benchmarks.decisions import benchmark_decisions
from ichain_drake.benchmarks.diagram import benchmark_diagram
from ichain_drake.benchmarks.frozen_models import benchmark_frozen_models
from ichain_drake.benchmarks.games import benchmark_games
from ichain_drake.benchmarks.together import benchmark_together
from ichain_drake.control.tracking.chain import METHODS, make_controller
from ichain_drake.runs.learn import learn
from ichain_drake.scenarios.base import Progress
from ichain_drake.systems.car_game.scenario import CarGame


@dataclass(frozen=True)
class BenchmarkSizes:
    """How much is measured; the defaults take about two minutes on one core.

    Attributes:
        overrides: settings of the car game, such as `learning.samples=100`.
        seconds: simulated time of each run of the whole diagram [s].
        repeats: rounds of each measurement; medians are reported.
        ticks: decisions that are timed.
        lengths: numbers of objects in the synthetic chains.
        trials: that are calculated together.
        alone: of them, those that are run one after another too.
    """

    overrides: tuple[str, ...] = ()
    seconds: float = 10.0
    repeats: int = 5
    ticks: int = 30
    lengths: tuple[int, ...] = (2, 4, 8, 16, 32, 64)
    trials: int = 256
    alone: int = 32


def run_benchmarks(progress: Progress | None = None, sizes: BenchmarkSizes | None = None) -> dict[str, Any]:
    """Measure everything; all but the times is the same in every run.

    The models are learned from demonstrations recorded in `ideal` physics; the diagram is that of the car game in
    `contact`. Times are processor times of this process on one thread.

    Args:
        progress: called with a line before each part.
        sizes: see `BenchmarkSizes`.

    Returns:
        Plain data, ready for JSON: `diagram`, `decision`, `together`, `chain_length`, `frozen_models`, `games`
        (None without that extra).
    """
    sizes = sizes or BenchmarkSizes()
    say = progress or (lambda line: None)
    with threadpool_limits(limits=1):
        ideal = CarGame(sizes.overrides, "ideal")
        say("learning the car game")
        began = time.process_time()
        chain = learn(ideal, list(ideal.record_demonstrations())).for_paths()
        default = ideal.config.control.method
        methods = (default, *(m for m in METHODS if m != default))
        limits, candidates = ideal.path_limits(), ideal.config.control.candidates()
        controllers = {default: make_controller(chain, default, limits, candidates)}
        learning = time.process_time() - began
        controllers |= {m: make_controller(chain, m, limits, candidates) for m in methods[1:]}
        say("one control decision")
        decision = benchmark_decisions(ideal, chain, controllers, sizes.ticks, sizes.repeats)
        say("the whole diagram against the bare plant")
        contact = CarGame(sizes.overrides, "contact")
        diagram = benchmark_diagram(contact, chain, controllers, sizes.seconds, sizes.repeats)
        say("trials together against one after another")
        together = benchmark_together(ideal, chain, controllers[default], sizes.trials, sizes.alone, learning)
        say("cost against chain length")
        chain_length = benchmark_chain_length(sizes.lengths, methods, sizes.repeats)
        say("frozen models against scikit-learn")
        frozen = benchmark_frozen_models(sizes.repeats)
        say("a game of somebody else's")
        games = benchmark_games(sizes.seconds, sizes.repeats)
    return {
        "diagram": diagram,
        "decision": decision,
        "together": together,
        "chain_length": chain_length,
        "frozen_models": frozen,
        "games": games,
    }
