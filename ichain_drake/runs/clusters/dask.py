"""A cluster of Dask: one of this machine, or one that SLURM, Kubernetes or a person has started.

Calls go to Dask's own client and not through joblib's backend for it: that never hears of a call whose worker was
killed too often, and waits for it for ever.
"""

from __future__ import annotations

import logging
import pickle
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from typing import Any

from ichain_drake.errors import InputError
from ichain_drake.runs.clusters.workers import Say, WorkersGoneError, extra

_TO_CONNECT = 30  # to a scheduler [s]
_STARTS = 3  # of a cluster on this machine: a worker that is killed while it begins takes the others along
_QUIET = {
    # A cluster that lives as long as this, and shows no dashboard: nobody looks at what these would tell.
    "distributed.worker.profile.enabled": False,  # samples of every call's stack, a hundred a second
    "distributed.admin.system-monitor.interval": "10s",
    "distributed.admin.tick.interval": "1s",
}


@dataclass(frozen=True)
class DaskCluster:
    """Workers of Dask.

    Attributes:
        client: Dask's.
        shares_files: whether they are on this machine.
    """

    client: Any
    shares_files: bool = False

    def each(self, function: Callable[..., Any], given: Sequence[tuple[Any, ...]]) -> Iterator[Any]:
        """See `Backend`; Dask itself does a call again whose worker was killed, three times."""
        distributed = extra("dask")
        closed = distributed.client.ClosedClientError
        gone = (
            distributed.scheduler.KilledWorker,
            distributed.CancelledError,
            closed,
            distributed.comm.CommClosedError,
        )
        dumps = distributed.protocol.pickle.dumps  # by value what a notebook defines
        futures: set[Any] = set()
        try:
            messages = (dumps(_Call(function, arguments)) for arguments in given)
            futures.update(self.client.submit(pickle.loads, message, pure=False) for message in messages)
            for future in distributed.as_completed(futures):
                result = future.result()
                futures.remove(future)
                future.release()  # else the call is done again if the worker that has its result is killed
                yield result
        except gone as error:
            raise WorkersGoneError(f"a worker of the cluster, or its scheduler, is gone ({_words(error)})") from None
        except ImportError as error:
            raise InputError(
                f"workers of the cluster can't load a trial ({_words(error)}): install ichain_drake there, and start "
                "them where a system of your own can be imported"
            ) from None
        finally:
            with suppress(closed):
                self.client.cancel(list(futures), force=True)


@dataclass(frozen=True)
class _Call:
    """A call that is done where it is unpickled: what can't be imported there raises there.

    Dask itself would unpickle calls in its scheduler, too, and wait for ever for a worker that can't.
    """

    function: Callable[..., Any]
    given: tuple[Any, ...]

    def __reduce__(self) -> tuple[Callable[..., Any], tuple[Any, ...]]:
        return self.function, self.given


@contextmanager
def dask_cluster(address: str, processes: int, say: Say) -> Iterator[DaskCluster]:
    """Connect to a cluster, or start one on this machine.

    Args:
        address: of the scheduler; empty for a cluster that lives as long as this.
        processes: of the one that is started.
        say: is told who works.

    Raises:
        InputError: if the scheduler does not answer, or no cluster can be started here.
    """
    distributed = extra("dask")
    logging.getLogger("distributed").setLevel(logging.CRITICAL)  # it speaks of lost workers, as we do
    with ExitStack() as stack:
        if address:
            try:
                client = stack.enter_context(distributed.Client(address, timeout=_TO_CONNECT))
            except (OSError, ValueError, TypeError) as error:
                raise InputError(f"--cluster dask={address}: {_words(error)}; is the scheduler there?") from None
            say(f"waiting for workers at {address}", None)
            client.wait_for_workers(1)
        else:
            stack.enter_context(distributed.dask.config.set(_QUIET))
            client = stack.enter_context(distributed.Client(stack.enter_context(_local_cluster(processes))))
        say(f"{sum(client.ncores().values())} workers of Dask at {client.scheduler.address}", None)
        yield DaskCluster(client, shares_files=not address)


def _local_cluster(processes: int) -> Any:
    for _ in range(_STARTS):
        try:
            # No limit of memory: Dask would pause or kill workers by a share that it takes from all there is.
            return extra("dask").LocalCluster(
                n_workers=processes, threads_per_worker=1, dashboard_address=None, memory_limit=None,
                silence_logs=logging.CRITICAL,
            )  # fmt: skip
        except (RuntimeError, OSError) as error:
            why = _words(error)
    raise InputError(
        f"--cluster dask: no cluster can be started on this machine: {why} (a script that evaluates needs "
        "`if __name__ == '__main__':` around what it does)"
    )


def _words(error: BaseException) -> str:
    return " ".join(str(error).split())[:200] or type(error).__name__
