"""A cluster of Ray: one of this machine, or one that runs."""

from __future__ import annotations

import logging
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from ichain_drake.errors import InputError
from ichain_drake.runs.clusters.workers import Say, WorkersGoneError, extra


@dataclass(frozen=True)
class RayCluster:
    """Workers of Ray.

    Attributes:
        shares_files: whether they are on this machine.
    """

    shares_files: bool = False

    def each(self, function: Callable[..., Any], given: Sequence[tuple[Any, ...]]) -> Iterator[Any]:
        """See `Backend`; Ray itself does a call again whose worker was killed, three times."""
        ray = extra("ray")
        remote = ray.remote(function)
        waiting = [remote.remote(*arguments) for arguments in given]
        try:
            while waiting:
                (done, *_), waiting = ray.wait(waiting)
                yield ray.get(done)
        except ray.exceptions.RayTaskError as error:
            raise (error.cause or error) from None
        except ray.exceptions.RayError as error:
            words = " ".join(str(error).split())[:200]
            raise WorkersGoneError(f"a worker of the cluster, or its head, is gone ({words})") from None
        finally:
            for call in waiting:
                ray.cancel(call, force=True)


@contextmanager
def ray_cluster(address: str, processes: int, say: Say) -> Iterator[RayCluster]:
    """Connect to a cluster, or start one on this machine.

    Args:
        address: of its head; empty for a cluster that lives as long as this.
        processes: of the one that is started.
        say: is told who works.

    Raises:
        InputError: if the head does not answer.
    """
    ray = extra("ray")
    quiet = {"include_dashboard": False, "log_to_driver": False, "logging_level": logging.ERROR}
    # What can be imported here can be there: systems of the user's, too.
    path = {"env_vars": {"PYTHONPATH": os.pathsep.join(p for p in sys.path if p)}}
    try:
        if address:
            ray.init(address=address, log_to_driver=False, logging_level=logging.ERROR)
        else:
            # On its own address, where no other machine reaches it.
            ray.init(num_cpus=processes, runtime_env=path, _node_ip_address="127.0.0.1", **quiet)
    except Exception as error:  # it raises bare ones, too
        words = " ".join(str(error).split())[:200]
        raise InputError(f"--cluster ray{'=' if address else ''}{address}: {words}") from None
    try:
        say(f"{int(ray.cluster_resources().get('CPU', 0))} workers of Ray", None)
        yield RayCluster(shares_files=not address)
    finally:
        ray.shutdown()
