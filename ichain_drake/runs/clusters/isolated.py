"""A job in a process of its own, so that a trial that crashes or hangs is a finding, and ends nothing but itself."""

from __future__ import annotations

import ctypes
import gc
import json
import os
import select
import signal
import sys
import threading
import time
import traceback
from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Protocol, runtime_checkable

from ichain_drake.errors import IchainError

_PARENT_DIED = 1  # PR_SET_PDEATHSIG of prctl(2)
_INTERRUPTED = 130
_STOPS = (signal.SIGINT, signal.SIGTERM)
_STEP = 1 << 16  # bytes that are read at a time


class Job(Protocol):
    """Trials that share preparation, and so a process; it is pickled on its way there."""

    @property
    def ids(self) -> Sequence[str]:
        """Names of its findings: the same in every run of the evaluation, and no other job's."""

    def run(self, ids: Collection[str]) -> Iterator[tuple[str, Any]]:
        """Find what is asked for, in the order of `ids`: id and plain data of each, as it is there."""

    def failed(self, name: str, reason: str) -> Any:
        """What is found for an id if the job raised before."""


@runtime_checkable
class JointJob(Job, Protocol):
    """Trials that could be found apart too, with the same findings; then none of them is in another one's way."""

    @property
    def apart(self) -> Sequence[Job]:
        """The same trials, in jobs of their own."""


class TrialKilledError(Exception):
    """Somebody killed the process of a trial: the system, out of memory, or a person. No finding about the trial."""


def findings(job: Job, ids: Collection[str], timeout: float | None = None) -> Iterator[tuple[str, Any]]:
    """Run a job in a process of its own.

    A trial that raises, takes too long or ends its process gives a finding with the reason; those behind it get another
    process. Of a `JointJob` nobody knows which trial it was: what was not found yet is found apart. What is found comes
    back as JSON, whoever ran it.

    Args:
        job: what to run.
        ids: of it.
        timeout: of each trial, what its job prepares included [s].

    Yields:
        Id and finding, as they come.

    Raises:
        TrialKilledError: if the process was killed from outside.
        KeyboardInterrupt: if it was interrupted.
    """
    left = list(ids)
    while left:
        child = _Child(job, left)
        try:
            for key, value in child.lines(timeout):
                left.remove(key)
                yield key, value
            reason = child.reason()
        except TimeoutError:
            reason = f"took longer than {timeout:g} s and was stopped"
        finally:
            child.end()
        if left and isinstance(job, JointJob):
            for part in job.apart:
                yield from findings(part, [i for i in part.ids if i in left], timeout)
            return
        if left:
            name = left.pop(0)
            yield name, json.loads(json.dumps(job.failed(name, reason or "came to an end without a finding")))


class _Child:
    """A copy of this process that runs a job and writes what it finds into a pipe, a line each.

    A copy, not a process begun anew: what was imported and changed here holds there, and it is there at once.
    """

    def __init__(self, job: Job, ids: Sequence[str]) -> None:
        sys.stdout.flush()
        sys.stderr.flush()
        self._pipe, end = os.pipe()
        self._status: int | None = None
        self._id, parent, code = -1, os.getpid(), 1
        try:
            with _undisturbed():
                self._id = os.fork()
            if self._id == 0:
                die_with_parent()
                if os.getppid() == parent:  # else it died before
                    os.close(self._pipe)
                    gc.freeze()  # else it copies what it searches for garbage
                    code = _run(job, ids, end)
        except BaseException:
            if self._id > 0:
                self.end()
            raise
        finally:
            if os.getpid() != parent:
                os._exit(code)
            os.close(end)

    def lines(self, timeout: float | None) -> Iterator[tuple[str, Any]]:
        """What it finds, to its end.

        Raises:
            TimeoutError: if nothing came for so long.
        """
        waiting = b""
        until = None if timeout is None else time.monotonic() + timeout
        while True:
            left = None if until is None else max(0.0, until - time.monotonic())
            if not select.select([self._pipe], [], [], left)[0]:
                raise TimeoutError
            read = os.read(self._pipe, _STEP)
            if not read:
                return
            *lines, waiting = (waiting + read).split(b"\n")
            for line in lines:
                yield tuple(json.loads(line))
                until = None if timeout is None else time.monotonic() + timeout

    def reason(self) -> str:
        """Why it ended, in words; nothing if it came to its end.

        Raises:
            TrialKilledError, KeyboardInterrupt: see `findings`.
        """
        code = self._wait()
        if code == _INTERRUPTED:
            raise KeyboardInterrupt
        if code == -signal.SIGKILL:
            raise TrialKilledError("a worker process was killed (out of memory?)")
        if code < 0:
            return f"ended its process by {signal.Signals(-code).name}"
        return f"ended its process with status {code}" if code else ""

    def end(self) -> None:
        """See that it is gone."""
        os.close(self._pipe)
        if self._status is None:
            os.kill(self._id, signal.SIGKILL)
            self._wait()

    def _wait(self) -> int:
        if self._status is None:
            self._status = os.waitstatus_to_exitcode(os.waitpid(self._id, 0)[1])
        return self._status


@contextmanager
def _undisturbed() -> Iterator[None]:
    """Answer signals that come in the midst of a fork when it is done: Python ignores what is raised in there."""
    caught: list[int] = []
    before: dict[int, Any] = {}
    if threading.current_thread() is threading.main_thread():  # no other is disturbed
        before = {number: signal.getsignal(number) for number in _STOPS}
        before = {number: handler for number, handler in before.items() if callable(handler)}
    for number in before:
        signal.signal(number, lambda number, frame: caught.append(number))
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
    for number in caught:
        before[number](number, None)


def _run(job: Job, ids: Sequence[str], end: int) -> int:
    """In the new process: all that the job finds; returns its exit status."""
    left = list(ids)
    with os.fdopen(end, "w") as pipe:

        def tell(key: str, value: Any) -> None:
            pipe.write(json.dumps([key, value]) + "\n")
            pipe.flush()
            left.remove(key)

        try:
            for key, value in job.run(ids):
                tell(key, value)
        except Exception as error:  # whatever a trial raises is a finding about this trial
            for key in [] if isinstance(job, JointJob) else list(left):
                tell(key, job.failed(key, reason_of(error)))
        except KeyboardInterrupt:
            return _INTERRUPTED
        except SystemExit as error:
            return error.code if isinstance(error.code, int) else 1
        finally:
            sys.stdout.flush()
            sys.stderr.flush()
    return 0


def die_with_parent() -> None:
    """Have Linux kill this process when the one that made it dies, however that dies."""
    ctypes.CDLL(None).prctl(_PARENT_DIED, int(signal.SIGKILL))


def reason_of(error: Exception) -> str:
    """An error in one line; of one that this library did not raise on purpose also the place."""
    text = " ".join(str(error).split())
    if isinstance(error, IchainError):
        return text
    frames = traceback.extract_tb(error.__traceback__)
    place = f" ({Path(frames[-1].filename).name}, line {frames[-1].lineno})" if frames else ""
    return f"{type(error).__name__}: {text}{place}"
