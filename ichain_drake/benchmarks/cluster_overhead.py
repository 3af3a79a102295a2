"""What a cluster costs beside processes of this machine: the same short trials, from nothing to the last finding."""

from __future__ import annotations

import resource
import time
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any

import numpy as np
from joblib.externals.loky import get_reusable_executor

from ichain_drake.benchmarks.measure import interleaved
from ichain_drake.runs.clusters.backend import opened
from ichain_drake.runs.clusters.workers import Workers
from ichain_drake.runs.runner import run_jobs


@dataclass(frozen=True)
class BusyJob:
    """One trial that computes for a given time and finds its own number.

    Attributes:
        number: of the trial.
        seconds: processor time [s].
    """

    number: int
    seconds: float

    @property
    def ids(self) -> Sequence[str]:
        """Its number."""
        return (str(self.number),)

    def run(self, ids: Collection[str]) -> Iterator[tuple[str, Any]]:
        """Be busy; see `Job`."""
        for name in ids:
            until = time.process_time() + self.seconds
            while time.process_time() < until:
                np.linalg.inv(np.eye(50))
            yield name, self.number

    def failed(self, name: str, reason: str) -> Any:
        """See `Job`."""
        return reason


def benchmark_clusters(trials: int, seconds: float, workers: int, repeats: int) -> dict[str, Any] | None:
    """Wall time of many short trials on a cluster of Dask against that on joblib's processes, startup and end included.

    Args:
        trials: how many.
        seconds: processor time of each [s].
        workers: processes that work at the same time.
        repeats: rounds, in turns.

    Returns:
        Median wall times `loky` and `dask` [s], `ratio`, the median of the rounds' ratios, `processor_ratio`, that of
        the processor time of all that took part, and the sizes; None without the extra `dask`.
    """
    if find_spec("distributed") is None:
        return None
    jobs = [BusyJob(k, seconds) for k in range(trials)]

    def run(cluster: str) -> float:
        get_reusable_executor().shutdown(wait=True)  # what is left of an earlier round would be a head start
        begin, busy = time.perf_counter(), _processor_seconds()
        with opened(Workers(workers, cluster)) as backend:
            found = run_jobs(jobs, backend)
        if not cluster:
            get_reusable_executor().shutdown(wait=True)
        assert found == list(range(trials))
        processor[cluster or "loky"].append(_processor_seconds() - busy)
        return time.perf_counter() - begin

    processor: dict[str, list[float]] = {"loky": [], "dask": []}
    times = interleaved({"loky": lambda: run(""), "dask": lambda: run("dask")}, repeats)
    return {
        "trials": trials,
        "seconds": seconds,
        "workers": workers,
        **{kind: float(np.median(found)) for kind, found in times.items()},
        "ratio": _ratio(times),
        "processor_ratio": _ratio(processor),
    }


def _ratio(times: Mapping[str, Sequence[float]]) -> float:
    return float(np.median(np.array(times["dask"]) / np.array(times["loky"])))


def _processor_seconds() -> float:
    """Processor time of this process and of all that it started and that have ended [s]."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(u.ru_utime + u.ru_stime for u in used)
