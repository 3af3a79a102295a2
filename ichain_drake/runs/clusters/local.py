"""Processes of this machine, started by joblib."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from typing import Any

from joblib import Parallel, delayed

from ichain_drake.errors import InputError
from ichain_drake.runs.clusters.workers import WorkersGoneError


@dataclass(frozen=True)
class LocalProcesses:
    """Processes of this machine; with one of them, this one.

    Attributes:
        processes: how many.
    """

    processes: int = 1
    shares_files: bool = True

    def each(self, function: Callable[..., Any], given: Sequence[tuple[Any, ...]]) -> Iterator[Any]:
        """See `Backend`.

        Raises:
            WorkersGoneError: if a process was killed.
            InputError: if a process can't load what it is to do.
        """
        # One call a message: what a killed process was given goes with it.
        pool = Parallel(
            n_jobs=min(self.processes, len(given) or 1), return_as="generator_unordered", batch_size=1
        )  # fmt: skip
        try:
            yield from pool(delayed(function)(*arguments) for arguments in given)
        except BrokenProcessPool as broken:
            if broken.__cause__ is not None:  # the traceback of a process that could not unpickle a call
                why = str(broken.__cause__).strip(' \n"').splitlines()[-1]
                raise InputError(
                    f"worker processes can't load a trial ({why}): start where a system of your own can be imported"
                ) from None
            raise WorkersGoneError("a worker process was killed (out of memory?)") from None
