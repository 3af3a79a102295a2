"""The runner: nothing is lost and nothing done twice, whatever ends it."""

import importlib
import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from joblib import delayed
from toy_jobs import ToyJob, exhaust

from ichain_drake.errors import InputError, WorkerLostError
from ichain_drake.runs import runner
from ichain_drake.runs.clusters.isolated import reason_of
from ichain_drake.runs.clusters.local import LocalProcesses
from ichain_drake.runs.row_file import RowFile, rows_beside
from ichain_drake.runs.runner import about, run_all, run_jobs

HELPERS = str(Path(__file__).parents[1] / "helpers")


def jobs(folder, **deeds):
    return [ToyJob((f"{a}1", f"{a}2"), folder, tuple(deeds.items())) for a in "abc"]


def test_findings_come_in_the_order_of_the_jobs_whoever_is_done_first(tmp_path):
    said = []
    found = run_jobs(jobs(tmp_path), LocalProcesses(2), say=lambda *words: said.append(words))
    assert [f["name"] for f in found] == ["a1", "a2", "b1", "b2", "c1", "c2"]
    fractions = [fraction for _, fraction in said]
    assert fractions == sorted(set(fractions)) and len(said) >= 3 and fractions[-1] == 1.0
    assert all(line.endswith(" s left") for line, _ in said[:-1])
    assert said[-1][0].startswith("6 of 6: ") and not said[-1][0].endswith("left")
    assert [about(seconds) for seconds in (7.4, 100, 5 * 60, 9000)] == [
        "about 7 s", "about 1.7 min", "about 5 min", "about 2.5 h",
    ]  # fmt: skip


def test_a_job_that_raises_is_a_finding_and_ends_nothing(tmp_path):
    found = run_jobs(jobs(tmp_path, b1="raise"))
    assert [f["name"] for f in found] == ["a1", "a2", "b1", "b2", "c1", "c2"]
    reasons = [f.get("reason") for f in found]
    assert reasons[:2] == reasons[4:] == [None, None]
    assert all(r.startswith("ZeroDivisionError: by nought (toy_jobs.py, line") for r in reasons[2:4])
    assert reason_of(InputError("two\n lines")) == "two lines"


def test_a_system_that_workers_can_not_import_is_named(tmp_path, monkeypatch):
    (tmp_path / "only_mine.py").write_text("import toy_jobs\nclass OwnJob(toy_jobs.ToyJob):\n    pass\n")
    with monkeypatch.context() as patch:
        patch.syspath_prepend(tmp_path)
        made = importlib.import_module("only_mine").OwnJob
    (tmp_path / "only_mine.py").unlink()
    own = [made((name,), tmp_path) for name in "ab"]
    with pytest.raises(InputError, match=r"can't load a trial \(ModuleNotFoundError: .*only_mine.*\): start where"):
        run_jobs(own, LocalProcesses(2))


def test_what_was_found_before_is_not_done_again(tmp_path):
    rows = RowFile(tmp_path / "rows.jsonl", {"seed": 1})
    with pytest.raises(KeyboardInterrupt):
        run_jobs(jobs(tmp_path, c1="interrupt"), rows=rows)
    again = RowFile(tmp_path / "rows.jsonl", {"seed": 1}, resume=True)
    assert set(again.found) == {"a1", "a2", "b1", "b2"}
    (tmp_path / "ran").unlink()
    assert [f["name"] for f in run_jobs(jobs(tmp_path), rows=again)] == ["a1", "a2", "b1", "b2", "c1", "c2"]
    assert ToyJob((), tmp_path).ran() == ["c1", "c2"]


def test_of_a_job_that_was_half_done_the_rest_is_done(tmp_path):
    rows = RowFile()
    rows.add({"a1": "known"})
    assert run_jobs(jobs(tmp_path)[:1], rows=rows) == ["known", {"name": "a2", "off": []}]
    assert ToyJob((), tmp_path).ran() == ["a2"]


@pytest.mark.parametrize("processes", [1, 2])
def test_what_a_job_has_found_is_kept_before_it_is_done_also_if_the_client_is_killed(tmp_path, processes):
    code = f"""
from pathlib import Path
from toy_jobs import ToyJob
from ichain_drake.runs.clusters.local import LocalProcesses
from ichain_drake.runs.row_file import RowFile
from ichain_drake.runs.runner import run_jobs
folder = Path({str(tmp_path)!r})
jobs = [ToyJob(("a1", "a2", "a3"), folder, (("a2", "hang"),)), ToyJob(("b1",), folder)]
say = lambda line, share: print(line, flush=True)
run_jobs(jobs, LocalProcesses({processes}), RowFile(folder / "rows.jsonl"), say=say)
"""
    client = subprocess.Popen(
        [sys.executable, "-c", code], env=os.environ | {"PYTHONPATH": HELPERS}, stdout=subprocess.PIPE
    )
    assert client.stdout is not None
    wanted = {"a1"} if processes == 1 else {"a1", "b1"}
    try:
        for _ in wanted:
            assert b" of 4: " in client.stdout.readline()
    finally:
        client.kill()
        client.wait()
        client.stdout.close()
    rows = RowFile(tmp_path / "rows.jsonl", resume=True)
    assert set(rows.found) == wanted
    left = [ToyJob(("a1", "a2", "a3"), tmp_path), ToyJob(("b1",), tmp_path)]
    assert [f["name"] for f in run_jobs(left, None, rows)] == ["a1", "a2", "a3", "b1"]
    assert ToyJob((), tmp_path).ran().count("a1") == 1


def test_findings_that_can_not_be_kept_end_the_evaluation(tmp_path):
    rows = RowFile(tmp_path / "rows.jsonl")
    (tmp_path / "rows.jsonl").unlink()
    (tmp_path / "rows.jsonl").mkdir()
    with pytest.raises(InputError, match="can't keep rows there"):
        run_jobs(jobs(tmp_path), LocalProcesses(2), rows)


@pytest.mark.parametrize("deed", ["die once", "kill worker once"])
def test_what_a_killed_process_had_not_finished_is_done_again(tmp_path, deed):
    rows, said = RowFile(tmp_path / "rows.jsonl"), []
    work = jobs(tmp_path, b2=deed, a2="release")
    found = run_jobs(work, LocalProcesses(2), rows, say=lambda line, fraction: said.append(line))
    assert found == run_jobs(jobs(tmp_path))
    assert sum("killed" in line and line.endswith("going on with what is left") for line in said) == 1
    ran = ToyJob((), tmp_path).ran()[:-6]  # without those of the undisturbed run
    assert [ran.count(name) for name in ("a1", "a2", "b1", "b2")] == [1, 1, 1, 2]


def test_a_trial_that_is_killed_again_and_again_loses_no_finished_row_and_is_named(tmp_path):
    rows = RowFile(tmp_path / "rows.jsonl")
    work = jobs(tmp_path, b2="die", a2="release")
    with pytest.raises(WorkerLostError) as lost:
        run_jobs(work, LocalProcesses(2), rows)
    assert set(rows.found) == {"a1", "a2", "b1", "c1", "c2"}
    assert "killed (out of memory?) during b2, 4 times" in str(lost.value)
    assert f"kept in {tmp_path / 'rows.jsonl'}; go on with --resume" in str(lost.value)
    again = RowFile(tmp_path / "rows.jsonl", resume=True)
    assert again.found == rows.found
    assert [f["name"] for f in run_jobs(jobs(tmp_path), None, again)] == ["a1", "a2", "b1", "b2", "c1", "c2"]


@pytest.mark.parametrize("processes", [1, 2])
def test_a_trial_that_crashes_or_hangs_is_a_finding_with_its_reason(tmp_path, processes):
    found = run_jobs(jobs(tmp_path, a1="crash", b1="hang", c2="exit"), LocalProcesses(processes), timeout=2.0)
    assert [f.get("reason") for f in found] == [
        "ended its process by SIGABRT", None, "took longer than 2 s and was stopped", None, None,
        "ended its process with status 3",
    ]  # fmt: skip


def test_ctrl_c_in_the_midst_of_a_fork_is_not_lost(tmp_path, monkeypatch):
    fork = os.fork

    def interrupted_fork():
        os.kill(os.getpid(), signal.SIGINT)
        return fork()

    monkeypatch.setattr(os, "fork", interrupted_fork)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            run_jobs(jobs(tmp_path, a1="hang"))
    finally:
        signal.signal(signal.SIGINT, before)
    assert not ToyJob((), tmp_path).ran()[1:]


def test_rules_are_off_in_every_process(tmp_path, monkeypatch):
    from ichain_drake import rules

    name = next(iter(rules.RULES))
    with rules.without([name]):
        found = run_jobs(jobs(tmp_path), LocalProcesses(2))
    assert all(f["off"] == [name] for f in found)


def test_preparations_are_no_trials(tmp_path):
    assert run_all((delayed(divmod)(k, 2) for k in (4, 5)), LocalProcesses(2), "dividing") == [(2, 0), (2, 1)]
    with pytest.raises(ZeroDivisionError):
        run_all([delayed(divmod)(1, 0)], LocalProcesses(), "dividing")
    (tmp_path / "others are done").touch()
    dying = ToyJob(("a",), tmp_path, (("a", "die"),))
    with pytest.raises(WorkerLostError, match=r"killed \(out of memory\?\) while recording; begin anew"):
        run_all([delayed(exhaust)(dying), delayed(exhaust)(dying)], LocalProcesses(2), "recording")


class TestRowFile:
    """Rows on disk."""

    def test_a_half_written_line_is_dropped_and_the_next_stands_by_itself(self, tmp_path):
        file = tmp_path / "deep" / "rows.jsonl"
        RowFile(file, {"seed": 1}).add({"a": 1, "b": {"x": None}})
        with file.open("a") as stream:
            stream.write('{"id": "c", "fou')
        again = RowFile(file, {"seed": 1}, resume=True)
        assert again.found == {"a": 1, "b": {"x": None}}
        again.add({"c": 3})
        assert [json.loads(line).get("id") for line in file.read_text().splitlines()] == [None, "a", "b", "c"]
        assert RowFile(file, {"seed": 1}, resume=True).of(["c", "z", "a"]) == [3, 1]

    def test_rows_of_another_evaluation_are_refused(self, tmp_path):
        file = tmp_path / "rows.jsonl"
        RowFile(file, {"seed": 1, "scenario": "x"}).add({"a": 1})
        with pytest.raises(InputError, match=r"another evaluation \(seed: 1, now 2\); leave --resume out"):
            RowFile(file, {"seed": 2, "scenario": "x"}, resume=True)
        assert RowFile(file, {"seed": 2}).found == {}  # begun anew

    def test_nothing_to_go_on_from_is_a_beginning(self, tmp_path):
        assert RowFile(tmp_path / "rows.jsonl", resume=True).found == {}
        (tmp_path / "other.jsonl").write_text("no rows\n")
        assert RowFile(tmp_path / "other.jsonl", resume=True).found == {}

    def test_a_place_that_can_not_be_written_is_named(self, tmp_path):
        (tmp_path / "file").write_text("")
        with pytest.raises(InputError, match="can't keep rows there"):
            RowFile(tmp_path / "file" / "rows.jsonl")
        assert rows_beside(tmp_path / "report.json").name == "report.rows.jsonl"


def test_what_is_left_is_told_by_what_a_job_took_so_far(monkeypatch):
    said: list[str] = []
    clock = iter([100.0, 110.0, 130.0, 145.0])
    monkeypatch.setattr(runner.time, "monotonic", lambda: next(clock))
    progress = runner._Progress(6, 4, lambda line, fraction: said.append(f"{fraction:.2f} {line}"), None)
    progress.done(["a"])
    progress.done(["b"])
    progress.done({"c": {}, "d": {}})
    assert said == [
        "0.33 2 of 6 were done before",
        "0.50 3 of 6: a; about 30 s left",
        "0.67 4 of 6: b; about 30 s left",
        "1.00 6 of 6: d",
    ]


@pytest.mark.parametrize(("found_before_loss", "attempts"), [([], 4), ([1], 5), ([0, 1, 2, 4, 5], 9)])
def test_losses_are_counted_from_the_last_that_something_was_found_before(
    tmp_path, monkeypatch, found_before_loss, attempts
):
    """Four one after another end it, of which the first may have found something."""
    tried, rows = [], RowFile()

    def lose(work, backend, rows, *rest):
        tried.append(len(work))
        if len(tried) - 1 in found_before_loss:
            rows.add({work[0][1][0]: "found"})
        raise runner._LostError("a process was killed", [])

    monkeypatch.setattr(runner, "_attempt", lose)
    work = [ToyJob((str(k),), tmp_path) for k in range(9)]
    with pytest.raises(WorkerLostError, match=rf"4 times; {len(found_before_loss)} findings are kept"):
        run_jobs(work, rows=rows)
    assert len(tried) == attempts
