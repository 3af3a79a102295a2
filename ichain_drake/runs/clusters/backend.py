"""One way to have calls done by others, whoever they are: processes of this machine, or a cluster of Dask or Ray."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, Protocol

from ichain_drake.runs.clusters.dask import dask_cluster
from ichain_drake.runs.clusters.local import LocalProcesses
from ichain_drake.runs.clusters.ray import ray_cluster
from ichain_drake.runs.clusters.workers import Say, Workers


class Backend(Protocol):
    """Does calls at the same time."""

    @property
    def shares_files(self) -> bool:
        """Whether a file that is written here can be written there."""

    def each(self, function: Callable[..., Any], given: Sequence[tuple[Any, ...]]) -> Iterator[Any]:
        """What calls return, in the order in which they are done.

        Args:
            function: called with each of `given`.
            given: arguments.

        Raises:
            WorkersGoneError: if a process was killed, or the cluster is gone; open calls are given up.
            Exception: what a call raises.
        """


@contextmanager
def opened(workers: Workers, say: Say | None = None) -> Iterator[Backend]:
    """Somebody to work, for the time of an evaluation.

    Args:
        workers: who.
        say: is told if they are fewer than asked for, and who they are.

    Raises:
        InputError: if a cluster can't be reached or started.
    """
    if workers.kind == "":
        yield LocalProcesses(workers.usable_processes(say))
        return
    tell: Say = say or (lambda line, fraction: None)
    open_cluster: Any = {"dask": dask_cluster, "ray": ray_cluster}[workers.kind]
    with open_cluster(workers.address, 0 if workers.address else workers.usable_processes(say), tell) as cluster:
        yield cluster
