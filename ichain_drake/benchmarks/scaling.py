"""How cost grows: with objects, with rows of demonstrations, and what a cluster adds to many trials."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from threadpoolctl import threadpool_limits

from ichain_drake.benchmarks.chain_length import learn_dial
from ichain_drake.benchmarks.cluster_overhead import benchmark_clusters
from ichain_drake.benchmarks.many_objects import benchmark_objects
from ichain_drake.benchmarks.many_rows import benchmark_rows
from ichain_drake.benchmarks.table import columns
from ichain_drake.runs.learn import learn
from ichain_drake.scenarios.base import Progress
from ichain_drake.systems.water_dispenser.scenario import WaterDispenser


@dataclass(frozen=True)
class ScalingSizes:
    """How much is measured; the defaults take about a quarter of an hour.

    Attributes:
        objects: numbers of objects of learned graphs.
        rows: of demonstrations that are learned from.
        trials: that a cluster runs; 0 leaves clusters out.
        trial_seconds: processor time of each of them [s].
        workers: that run them.
        repeats: rounds of everything but learning.
    """

    objects: tuple[int, ...] = (4, 10, 30, 100, 300, 1000)
    rows: tuple[int, ...] = (10**3, 10**4, 10**5, 10**6)
    trials: int = 64
    trial_seconds: float = 0.5
    workers: int = 2
    repeats: int = 3


def run_scaling(progress: Progress | None = None, sizes: ScalingSizes | None = None) -> dict[str, Any]:
    """Measure how cost grows.

    Args:
        progress: called with a line before each part.
        sizes: see `ScalingSizes`.

    Returns:
        Plain data, ready for JSON: `objects`, `rows`, and `clusters` (None without the extra `dask` or any trials).
    """
    sizes, say = sizes or ScalingSizes(), progress or (lambda line: None)
    with threadpool_limits(limits=1):
        say("learning the machine that is copied")
        scenario = WaterDispenser((), "ideal", 0)
        machine = learn(scenario, list(scenario.record_demonstrations()))
        say("a tick of the learned graph against the number of objects")
        objects = benchmark_objects(machine, learn_dial(), sizes.objects, sizes.repeats)
    say("learning against the number of rows")
    rows = benchmark_rows(sizes.rows)
    say("short trials on a cluster")
    clusters = (
        benchmark_clusters(sizes.trials, sizes.trial_seconds, sizes.workers, sizes.repeats) if sizes.trials else None
    )
    return {"objects": objects, "rows": rows, "clusters": clusters}


def format_scaling(results: Mapping[str, Any]) -> str:
    """What `run_scaling` returned, as text to print."""
    parts = (_objects(results["objects"]), _rows(results["rows"]), _clusters(results["clusters"]))
    return "\n\n".join("\n".join(part) for part in parts)


def _objects(o: Mapping[str, Any]) -> list[str]:
    labels = {
        "step": "goals, one state",
        "step_batch": f"goals, {o['batch']} states at once",
        "diagram": "goals, as a Drake diagram",
        "chain": "paths, one chain",
    }
    rows = [
        [
            labels[key],
            *(f"{v:.2f}" for v in values),
            f"{1000.0 * o['fit'][key]['slope']:.1f}",
            f"{o['fit'][key]['r_squared']:.4f}",
        ]
        for key, values in o["ms"].items()
    ]
    header = ["objects", *map(str, o["objects"]), "us an object", "R^2"]
    return ["One tick of a learned graph [ms]: copies of the water dispenser under one hand", *columns(header, rows)]


def _rows(r: Mapping[str, Any]) -> list[str]:
    table = [[str(s["rows"]), str(s["pieces"]), f"{s['seconds']:.1f}", f"{s['peak_mb']:.0f}"] for s in r["sizes"]]
    return [
        "Learning the water dispenser from many rows, processor time",
        *columns(["rows", "pieces", "s", "peak MB"], table),
        f"  {1e6 * r['fit']['slope']:.0f} us a row, R^2 {r['fit']['r_squared']:.4f}",
    ]


def _clusters(c: Mapping[str, Any] | None) -> list[str]:
    title = "Short trials on a cluster of this machine, wall time with its start and end"
    if c is None:
        return [title, "  not measured: the extra `dask` is not installed"]
    what = f"{c['trials']} trials of {c['seconds']:g} s, {c['workers']} workers"
    table = [
        [f"{what}, processes of joblib", f"{c['loky']:.1f}", "1.00", "1.00"],
        [f"{what}, Dask", f"{c['dask']:.1f}", f"{c['ratio']:.2f}", f"{c['processor_ratio']:.2f}"],
    ]
    return [title, *columns(["", "s", "x", "x processor time"], table)]
