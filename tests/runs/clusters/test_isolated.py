"""What a job in a process of its own is said to have found."""

from __future__ import annotations

import sys
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from toy_jobs import ToyJob

from ichain_drake.errors import InputError
from ichain_drake.runs.clusters.isolated import findings, reason_of


class ShortJob(ToyJob):
    """Comes to its end before it has found everything."""

    def run(self, ids):
        yield from list(super().run(ids))[:1] if len(ids) > 1 else ()


class LeavingJob(ToyJob):
    def run(self, ids):
        sys.exit("no number" if self.deeds else 0)
        yield


def test_what_a_job_does_not_find_is_said(tmp_path: Path) -> None:
    found = dict(findings(ShortJob(("a", "b"), tmp_path), ("a", "b")))
    assert found["a"]["name"] == "a"
    assert found["b"] == {"name": "b", "reason": "came to an end without a finding"}


@pytest.mark.parametrize(("deeds", "reason"), [((), "came to an end without a finding"), ((("a", ""),), "status 1")])
def test_a_process_that_leaves_says_its_status(tmp_path: Path, deeds: tuple, reason: str) -> None:
    ((_, found),) = findings(LeavingJob(("a",), tmp_path, deeds), ("a",))
    assert found["reason"].endswith(reason)


def test_the_trials_behind_one_that_raises_are_findings_of_the_same_error(tmp_path: Path) -> None:
    """What has been found before stays; the job itself is over."""
    job = ToyJob(("a", "b", "c"), tmp_path, (("b", "raise"),))
    found = dict(findings(job, job.ids))
    assert list(found) == ["a", "b", "c"]
    assert "reason" not in found["a"]
    assert found["b"]["reason"] == found["c"]["reason"]
    assert found["b"]["reason"].startswith("ZeroDivisionError: by nought (toy_jobs.py, line ")


def test_an_interrupt_in_a_process_is_one_here(tmp_path: Path) -> None:
    job = ToyJob(("a", "b"), tmp_path, (("b", "interrupt"),))
    seen = findings(job, job.ids)
    assert next(seen)[0] == "a"
    with pytest.raises(KeyboardInterrupt):
        next(seen)


def test_what_finds_a_lot_is_read_to_its_end(tmp_path: Path) -> None:
    class LongJob(ToyJob):
        def run(self, ids):
            yield from ((key, key * 100_000) for key in ids)

    assert dict(findings(LongJob(("a", "b"), tmp_path), ("a", "b"), 30.0)) == {"a": "a" * 100_000, "b": "b" * 100_000}


def test_an_error_in_a_line() -> None:
    assert reason_of(InputError("a\n  b")) == "a b"
    assert reason_of(ValueError("a\nb")) == "ValueError: a b"
    try:
        int("x")
    except ValueError as error:
        assert error.__traceback__ is not None
        assert reason_of(error).endswith(f"(test_isolated.py, line {error.__traceback__.tb_lineno})")


@dataclass(frozen=True)
class Joint:
    """Toy jobs in one."""

    apart: tuple[ToyJob, ...]

    @property
    def ids(self) -> tuple[str, ...]:
        return tuple(name for job in self.apart for name in job.ids)

    def run(self, ids: Collection[str]) -> Iterator[tuple[str, Any]]:
        return (pair for job in self.apart for pair in job.run([i for i in job.ids if i in ids]))

    def failed(self, name: str, reason: str) -> Any:
        raise AssertionError("nobody knows which it was")


@pytest.mark.parametrize(
    ("deed", "reason"),
    [("raise", "ZeroDivisionError: by nought"), ("crash", "by SIGABRT"), ("exit", "status 3"), ("hang", "took longer")],
)
def test_what_went_wrong_together_is_found_apart(tmp_path: Path, deed: str, reason: str) -> None:
    joint = Joint(tuple(ToyJob(tuple(names), tmp_path, (("b", deed),)) for names in ("a", "bc", "d")))
    found = dict(findings(joint, joint.ids, 1.0 if deed == "hang" else None))
    assert list(found) == ["a", "b", "c", "d"]
    assert reason in found["b"]["reason"]
    assert ["reason" in found[name] for name in "ad"] == [False, False]
    assert joint.apart[0].ran() == [*"ab", *(["b"] if deed == "raise" else ["b", "c"]), "d"], "a is not found again"
