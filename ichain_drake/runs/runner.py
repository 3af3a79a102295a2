"""Trials in processes of their own, here or on a cluster: none ends the others, nothing is lost, nothing done twice."""

from __future__ import annotations

import json
import os
import tempfile
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import Any

from ichain_drake import rules
from ichain_drake.errors import InputError, WorkerLostError
from ichain_drake.runs.clusters.backend import Backend, opened
from ichain_drake.runs.clusters.isolated import Job, TrialKilledError, die_with_parent, findings
from ichain_drake.runs.clusters.local import LocalProcesses
from ichain_drake.runs.clusters.workers import Say, Workers, WorkersGoneError
from ichain_drake.runs.provenance import code_hash
from ichain_drake.runs.row_file import RowFile

_LOSSES = 3
"""Processes that may be killed one after another without anything found in between: then nothing more will be."""


_EVERY = 1.0  # [s] that a finding waits at most until it is kept

_keep: ContextVar[Callable[[Mapping[str, Any]], None] | None] = ContextVar("keep", default=None)
"""Who keeps what this process finds itself; none where the processes that find are others."""


class EvaluationInterrupted(KeyboardInterrupt):
    """Ctrl-C in the middle of an evaluation.

    Attributes:
        found: what was finished.
    """

    def __init__(self, found: dict[str, Any]) -> None:
        super().__init__("interrupted")
        self.found = found


def run_jobs(
    jobs: Sequence[Job],
    backend: Backend | None = None,
    rows: RowFile | None = None,
    say: Say | None = None,
    label: Callable[[str, int, int], str] | None = None,
    timeout: float | None = None,
) -> list[Any]:
    """Run what is not in `rows` yet, and keep each finding there as it comes.

    A trial that raises, crashes or takes too long gives a finding with its reason (`Job.failed`). What a killed process
    had not finished is done again. Rules that are switched off here are in the processes too.

    Args:
        jobs: what to run; their order is that of the result, whoever is done first.
        backend: who works, from `opened`; by default this process.
        rows: what is known, and where it is kept.
        say: is told as trials are done, with what is left and the fraction done.
        label: words for that, from the id of its last finding, and how many trials are done of how many.
        timeout: of each trial [s].

    Returns:
        The findings of all jobs in order.

    Raises:
        WorkerLostError: if processes were killed again and again, or a cluster is gone; what was finished is in `rows`.
        InputError: if a worker elsewhere has other code than this process.
        KeyboardInterrupt: on Ctrl-C; what was finished is in `rows`.
    """
    backend, rows = backend or LocalProcesses(), rows or RowFile()
    left = sum(len(ids) for _, ids in _left(jobs, rows))
    progress = _Progress(sum(len(job.ids) for job in jobs), left, say, label)
    losses, kept = 0, len(rows.found)
    with tempfile.TemporaryDirectory(prefix="ichain-", ignore_cleanup_errors=True) as folder:
        while work := _left(jobs, rows):
            try:
                _attempt(work, backend, rows, progress, timeout, Path(tempfile.mkdtemp(dir=folder)))
            except _LostError as lost:
                losses, kept = (losses + 1 if len(rows.found) == kept else 1), len(rows.found)
                if losses > _LOSSES:
                    raise _worker_lost(lost, rows) from None
                progress.tell(f"{lost}; going on with what is left")
    return rows.of(i for job in jobs for i in job.ids)


def evaluate_jobs(
    jobs: Sequence[Job],
    workers: Workers,
    rows: RowFile,
    found: Callable[[], dict[str, Any]],
    say: Say | None = None,
    label: Callable[[str, int, int], str] | None = None,
) -> dict[str, Any]:
    """Run an evaluation's jobs to their end, or say what was found up to where they ended.

    Args:
        workers: who works.
        found: makes what is told out of `rows`.
        jobs, rows, say, label: see `run_jobs`.

    Raises:
        EvaluationInterrupted: on Ctrl-C, with what was found.
        WorkerLostError: if processes were killed again and again, with the same.
    """
    try:
        with opened(workers, say) as backend:
            run_jobs(jobs, backend, rows, say, label, workers.trial_timeout)
    except WorkerLostError as lost:
        lost.found = found()
        raise
    except KeyboardInterrupt:
        raise EvaluationInterrupted(found()) from None
    return found()


class _LostError(Exception):
    """A process was killed.

    Attributes:
        during: ids of what was begun and not finished, a group for each process; empty where nobody knows.
    """

    def __init__(self, message: str, during: Sequence[Sequence[str]]) -> None:
        super().__init__(message)
        self.during = during


def _left(jobs: Sequence[Job], rows: RowFile) -> list[tuple[Job, tuple[str, ...]]]:
    work = [(job, tuple(i for i in job.ids if i not in rows.found)) for job in jobs]
    return [(job, ids) for job, ids in work if ids]


def _attempt(
    work: Sequence[tuple[Job, tuple[str, ...]]],
    backend: Backend,
    rows: RowFile,
    progress: _Progress,
    timeout: float | None,
    folder: Path,
) -> None:
    """Do the work, as far as nobody is killed.

    Raises:
        _LostError: if somebody was; what others had finished is in `rows`.
    """
    notes = [folder / str(k) if backend.shares_files else None for k in range(len(work))]
    code = "" if backend.shares_files else code_hash()
    off = rules.switched_off()
    client = os.getpid()
    given = [(job, ids, off, timeout, code, note, client) for (job, ids), note in zip(work, notes, strict=True)]
    keeper = _Keeper(folder, rows, progress)
    try:
        with keeper.watching(), closing(backend.each(_run, given)) as results:  # type: ignore[type-var] # a generator, see there
            for found in results:
                keeper.keep(found)
    except (WorkersGoneError, TrialKilledError) as error:
        keeper.collect()
        begun = [ids for (_, ids), note in zip(work, notes, strict=True) if note is not None and note.exists()]
        open_ids = [[i for i in ids if i not in rows.found] for ids in begun]
        raise _LostError(str(error), [ids for ids in open_ids if ids]) from None
    except BaseException:
        keeper.collect()
        raise


class _Keeper:
    """Keeps findings as they come: those of whole jobs, and those that a process has noted of the job that it is at.

    Args:
        folder: where processes note what they found; see `_run`.
        rows, progress: of the evaluation.
    """

    def __init__(self, folder: Path, rows: RowFile, progress: _Progress) -> None:
        self._folder, self._rows, self._progress = folder, rows, progress
        self._lock, self._read = threading.Lock(), dict[Path, int]()
        self._over = threading.Event()

    def keep(self, found: Mapping[str, Any]) -> None:
        """Keep what is new of some findings."""
        with self._lock:
            new = {key: value for key, value in found.items() if key not in self._rows.found}
            if new:
                self._rows.add(new)
                self._progress.done(new)

    def collect(self) -> None:
        """Keep what processes have noted."""
        for file in sorted(self._folder.glob("*.json")):
            changed = file.stat().st_mtime_ns
            if self._read.get(file) != changed:
                self.keep(json.loads(file.read_text()))
                self._read[file] = changed

    @contextmanager
    def watching(self) -> Iterator[None]:
        """Meanwhile keep what this process finds at once, and what others have noted every second."""
        token = _keep.set(self.keep)
        watcher = threading.Thread(target=self._watch, daemon=True)
        watcher.start()
        try:
            yield
        finally:
            _keep.reset(token)
            self._over.set()
            watcher.join()

    def _watch(self) -> None:
        while not self._over.wait(_EVERY):
            try:
                self.collect()
            except (InputError, OSError):  # a full disk; whoever waits for the job will be told
                return


def _run(
    job: Job,
    ids: tuple[str, ...],
    off: frozenset[str],
    timeout: float | None,
    code: str,
    note: Path | None,
    client: int,
) -> dict[str, Any]:
    """A job, at a worker; what it finds is noted for those who wait, should this process be killed."""
    if code and code != code_hash():
        raise InputError(
            f"a worker has other code of ichain_drake ({code_hash()}, here {code}): install the same there"
        )
    if os.getppid() == client:
        die_with_parent()  # else a killed evaluation's workers would go on to the end of their trials
    found: dict[str, Any] = {}
    keep = _keep.get()
    if note is not None:
        note.touch()
    with rules.without(off):
        for key, value in findings(job, ids, timeout):
            found[key] = value
            if keep is not None:
                keep({key: value})
            elif note is not None:
                part = note.with_suffix(".part")
                part.write_text(json.dumps(found))
                part.replace(note.with_suffix(".json"))
    return found


def _worker_lost(lost: _LostError, rows: RowFile) -> WorkerLostError:
    """The error about killed processes: what ran in them, and what is left of the evaluation."""
    kept = f"{len(rows.found)} findings are kept"
    left = f"{kept}; give --report, so that --resume can go on" if rows.file is None else (
        f"{kept} in {rows.file}; go on with --resume"
    )  # fmt: skip
    names = [ids[0] if len(ids) == 1 else f"{ids[0]} (and {len(ids) - 1} more with it)" for ids in lost.during]
    during = f" during {' or '.join(names)}" if names else ""
    return WorkerLostError(f"{lost}{during}, {_LOSSES + 1} times; {left}")


class _Progress:
    """What is said after each job: how many trials are done, and how long the others will take.

    Args:
        total: number of trials.
        left: of them, those that are to be done.
        say, label: see `run_jobs`.
    """

    def __init__(self, total: int, left: int, say: Say | None, label: Callable[[str, int, int], str] | None) -> None:
        self._total, self._before, self._done = total, total - left, total - left
        self._say, self._label, self._began = say, label, time.monotonic()
        if self._before:
            self.tell(f"{self._before} of {total} were done before")

    def done(self, found: Iterable[str]) -> None:
        """These trials are finished, some of a job or all."""
        *_, last = names = list(found)
        self._done += len(names)
        done, total = self._done, self._total
        line = self._label(last, done, total) if self._label else f"{done} of {total}: {last}"
        each = (time.monotonic() - self._began) / (done - self._before)
        self.tell(line if done == total else f"{line}; {about(each * (total - done))} left")

    def tell(self, line: str) -> None:
        """Say it, with the fraction done."""
        if self._say is not None:
            self._say(line, self._done / self._total)


def about(seconds: float) -> str:
    """A time that is still to come, in words.

    Args:
        seconds: how long [s].
    """
    for size, unit in ((3600.0, "h"), (60.0, "min")):
        if seconds >= 1.5 * size:
            return f"about {seconds / size:.2g} {unit}"
    return f"about {seconds:.0f} s"


def run_all(calls: Iterable[Any], backend: Backend, what: str) -> list[Any]:
    """What calls give, in their order, with the same rules switched off; for preparations that are no trials.

    Args:
        calls: made by `joblib.delayed`.
        backend: who works, from `opened`.
        what: they do, for the error.

    Raises:
        WorkerLostError: if a process was killed.
        Exception: what a call raises.
    """
    off = rules.switched_off()
    given = [(off, number, *call) for number, call in enumerate(calls)]
    try:
        found = dict(backend.each(_call, given))
    except WorkersGoneError as gone:
        raise WorkerLostError(f"{gone} while {what}; begin anew") from None
    return [found[number] for number in range(len(given))]


def _call(
    off: frozenset[str], number: int, function: Callable[..., Any], given: tuple[Any, ...], named: dict[str, Any]
) -> tuple[int, Any]:
    with rules.without(off):
        return number, function(*given, **named)
