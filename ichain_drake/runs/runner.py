"""Trials in processes of their own: as many as there are cores, none that ends the others, nothing done twice."""

from __future__ import annotations

import json
import tempfile
import traceback
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Any, Protocol

import joblib
from joblib import Parallel, delayed

from ichain_drake import rules
from ichain_drake.errors import IchainError, InputError, WorkerLostError
from ichain_drake.runs.row_file import RowFile

Say = Callable[[str, float | None], None]


class Job(Protocol):
    """Trials that share preparation, and so a process; it is pickled on its way there."""

    @property
    def ids(self) -> Sequence[str]:
        """Names of its findings: the same in every run of the evaluation, and no other job's."""

    def run(self, ids: Collection[str]) -> Iterator[tuple[str, Any]]:
        """Find what is asked for: id and plain data of each, as it is there."""

    def failed(self, name: str, reason: str) -> Any:
        """What is found for an id if the job raised before."""


class EvaluationInterrupted(KeyboardInterrupt):
    """Ctrl-C in the middle of an evaluation.

    Attributes:
        found: what was finished.
    """

    def __init__(self, found: dict[str, Any]) -> None:
        super().__init__("interrupted")
        self.found = found


def usable_processes(asked: int, say: Say | None = None) -> int:
    """How many processes work: as many as asked for, but no more than there are cores.

    Args:
        asked: by the user.
        say: is told if it is fewer.

    Raises:
        InputError: on a number below 1.
    """
    if asked < 1:
        raise InputError("--trials and --jobs: give numbers from 1")
    cores = int(joblib.cpu_count())
    if asked > cores and say is not None:
        say(f"{cores} processes of the {asked} asked for: there are {cores} cores", None)
    return min(asked, cores)


def run_jobs(
    jobs: Sequence[Job],
    processes: int = 1,
    rows: RowFile | None = None,
    say: Say | None = None,
    label: Callable[[str, int, int], str] | None = None,
) -> list[Any]:
    """Run what is not in `rows` yet, and keep each finding there as it comes.

    A job that raises gives findings with its reason (`Job.failed`). Rules that are switched off here are in the
    processes too.

    Args:
        jobs: what to run; their order is that of the result, whoever is done first.
        processes: that work at the same time, see `usable_processes`.
        rows: what is known, and where it is kept.
        say: is told after each job, with the fraction done.
        label: words for that, from the id of its last finding, and how many jobs are done of how many.

    Returns:
        The findings of all jobs in order.

    Raises:
        WorkerLostError: if a process was killed; what was finished is in `rows`.
        KeyboardInterrupt: on Ctrl-C; the same.
    """
    rows = rows or RowFile()
    work = [(job, tuple(i for i in job.ids if i not in rows.found)) for job in jobs]
    work = [(job, ids) for job, ids in work if ids]
    done = len(jobs) - len(work)
    if done and say:
        say(f"{done} of {len(jobs)} were done before", done / len(jobs))
    off = rules.switched_off()
    with tempfile.TemporaryDirectory(prefix="ichain-", ignore_cleanup_errors=True) as name:
        folder = Path(name)
        pool = Parallel(n_jobs=min(usable_processes(processes, say), len(work) or 1), return_as="generator_unordered")
        tasks = (delayed(_run)(job, ids, off, folder / str(k)) for k, (job, ids) in enumerate(work))
        try:
            for found in pool(tasks):
                rows.add(found)
                done += 1
                if say:
                    last, total = list(found)[-1], len(jobs)
                    say(label(last, done, total) if label else f"{done} of {total}: {last}", done / total)
        except BrokenProcessPool:
            _rescue(folder, rows)
            begun = [ids for k, (_, ids) in enumerate(work) if (folder / str(k)).exists()]
            raise _lost([ids for ids in begun if not all(i in rows.found for i in ids)], rows) from None
        except KeyboardInterrupt:
            _rescue(folder, rows)
            raise
    return rows.of(i for job in jobs for i in job.ids)


def run_all(calls: Iterable[Any], processes: int, what: str) -> list[Any]:
    """What calls give, in their order, with the same rules switched off; for preparations that are no trials.

    Args:
        calls: made by `joblib.delayed`.
        processes: see `usable_processes`.
        what: they do, for the error.

    Raises:
        WorkerLostError: if a process was killed.
        Exception: what a call raises.
    """
    try:
        off = rules.switched_off()
        return list(Parallel(n_jobs=usable_processes(processes))(delayed(_call)(off, *call) for call in calls))
    except BrokenProcessPool:
        raise WorkerLostError(f"a worker process was killed while {what} (out of memory?); begin anew") from None


def _call(off: frozenset[str], function: Callable[..., Any], given: tuple[Any, ...], named: dict[str, Any]) -> Any:
    with rules.without(off):
        return function(*given, **named)


def _run(job: Job, ids: tuple[str, ...], off: frozenset[str], note: Path) -> dict[str, Any]:
    """A job in its process; that it began and what it found is noted for a parent whose pool breaks meanwhile."""
    note.touch()
    found: dict[str, Any] = {}
    with rules.without(off):
        try:
            for key, value in job.run(ids):
                found[key] = value
        except Exception as error:  # whatever a trial raises is a finding about this trial
            found |= {key: job.failed(key, reason_of(error)) for key in ids if key not in found}
    whole = note.with_suffix(".json")
    part = note.with_suffix(".part")
    part.write_text(json.dumps(found))
    part.replace(whole)
    return found


def _lost(running: Sequence[Sequence[str]], rows: RowFile) -> WorkerLostError:
    """The error about a killed process: what ran in those that worked, and what is left of the evaluation."""
    kept = f"{len(rows.found)} findings are kept"
    left = f"{kept}; give --report, so that --resume can go on" if rows.file is None else (
        f"{kept} in {rows.file}; go on with --resume"
    )  # fmt: skip
    names = [ids[0] if len(ids) == 1 else f"{ids[0]} (and {len(ids) - 1} more with it)" for ids in running]
    return WorkerLostError(
        f"a worker process was killed (out of memory?) during {' or '.join(names) or 'its start'}; {left}"
    )


def _rescue(folder: Path, rows: RowFile) -> None:
    """Findings that were made but had not come back."""
    for file in sorted(folder.glob("*.json")):
        found = json.loads(file.read_text())
        rows.add({key: value for key, value in found.items() if key not in rows.found})


def reason_of(error: Exception) -> str:
    """An error in one line; of one that this library did not raise on purpose also the place."""
    text = " ".join(str(error).split())
    if isinstance(error, IchainError):
        return text
    frames = traceback.extract_tb(error.__traceback__)
    place = f" ({Path(frames[-1].filename).name}, line {frames[-1].lineno})" if frames else ""
    return f"{type(error).__name__}: {text}{place}"
