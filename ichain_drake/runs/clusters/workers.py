"""Who works on the trials of an evaluation: how many processes, where, and how long a trial may take."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from types import ModuleType

import joblib

from ichain_drake.errors import InputError

Say = Callable[[str, float | None], None]

_KINDS = {"dask": "distributed", "ray": "ray"}  # kinds of clusters, and the module that the extra of that name brings
_SCHEMES = {"tcp": "dask", "tls": "dask", "ucx": "dask", "ray": "ray"}  # of an address that stands alone
_LIMITS = ("memory.max", "memory/memory.limit_in_bytes")  # of a container, control groups of both versions
_GROUPS = Path("/sys/fs/cgroup")


class WorkersGoneError(Exception):
    """A process that worked was killed, or a cluster is gone; the message says which."""


@dataclass(frozen=True)
class Workers:
    """Who works; the findings don't depend on it.

    Attributes:
        processes: that work at the same time on this machine; no more than `usable_processes`.
        cluster: `dask` or `ray` for one on this machine, `dask=ADDRESS` or `ray=ADDRESS` for one that runs; the kind
            may be left out before `tcp://` and `ray://`. Empty: processes that joblib starts.
        trial_timeout: a trial that takes longer is stopped, and fails with that reason [s]; None: it may take forever.
        trial_bytes: what a process needs at most [bytes]: processes that don't fit into the memory are not started.
            Trials of all shipped systems stay below it.

    Raises:
        InputError: on a number below 1, an unknown cluster, a missing extra, or processes asked of a cluster elsewhere.
    """

    processes: int = 1
    cluster: str = ""
    trial_timeout: float | None = None
    trial_bytes: int = 1 << 30

    def __post_init__(self) -> None:
        if self.processes < 1:
            raise InputError("--trials and --jobs: give numbers from 1")
        if self.trial_timeout is not None and not 0 < self.trial_timeout < math.inf:
            raise InputError(f"--trial-timeout {self.trial_timeout:g}: give seconds above 0")
        if self.cluster and self.kind not in _KINDS:
            raise InputError(f"--cluster {self.cluster}: give dask, dask=tcp://HOST:PORT, ray or ray=ADDRESS")
        if self.kind:
            extra(self.kind)
        if self.address and self.processes > 1:
            raise InputError(f"--jobs is for this machine: how many work at {self.address} is up to that cluster")

    @property
    def kind(self) -> str:
        """`dask`, `ray`, or nothing."""
        name, _, _ = self.cluster.partition("=")
        scheme = re.match(r"(\w+)://", name)
        return name if scheme is None else _SCHEMES.get(scheme[1], name)

    @property
    def address(self) -> str:
        """Of a cluster that runs; empty for one that is to be started here."""
        name, _, address = self.cluster.partition("=")
        return name if "://" in name else address

    def usable_processes(self, say: Say | None = None) -> int:
        """How many work on this machine: as many as asked for, as there are cores, and as its free memory holds.

        Args:
            say: is told if it is fewer.
        """
        cores = int(joblib.cpu_count())
        free = free_memory()
        most = {f"there are {cores} cores": cores}
        if free is not None:
            words = f"there are {free / 2**30:.1f} GiB of free memory, for {self.trial_bytes / 2**30:.2g} GiB each"
            most[words] = max(1, free // self.trial_bytes)
        reason, fewest = min(most.items(), key=lambda item: item[1])
        if fewest < self.processes and say is not None:
            say(f"{fewest} processes of the {self.processes} asked for: {reason}", None)
        return min(self.processes, fewest)


def extra(kind: str) -> ModuleType:
    """The module that works with a kind of cluster.

    Raises:
        InputError: if it is not installed.
    """
    try:
        return import_module(_KINDS[kind])
    except ImportError as error:
        raise InputError(f"--cluster {kind}: {error}; pip install 'ichain_drake[{kind}]'") from None


def free_memory() -> int | None:
    """What processes may still take before something is swapped out or killed [bytes]; None where nobody says."""
    try:
        known = dict(line.split(":", 1) for line in Path("/proc/meminfo").read_text().splitlines())
        free = [int(known["MemAvailable"].split()[0]) * 1024]
    except (OSError, KeyError, ValueError):
        free = []
    for name in _LIMITS:
        try:
            free.append(int((_GROUPS / name).read_text()))
        except (OSError, ValueError):  # no such group, or `max`
            continue
    return min(free, default=None)
