"""Clusters find what one process finds, and a killed worker, or a scheduler that is gone, loses nothing."""

import importlib
import sys
import threading
import time

import pytest
from toy_jobs import ToyJob

from ichain_drake.errors import InputError, WorkerLostError
from ichain_drake.runs import runner
from ichain_drake.runs.clusters.backend import opened
from ichain_drake.runs.clusters.workers import Workers
from ichain_drake.runs.row_file import RowFile
from ichain_drake.runs.runner import run_jobs


@pytest.fixture(params=["dask", "ray"])
def kind(request):
    pytest.importorskip({"dask": "distributed", "ray": "ray"}[request.param], reason="an extra that is not installed")
    return request.param


def jobs(folder, **deeds):
    return [ToyJob((f"{a}1", f"{a}2"), folder, tuple(deeds.items())) for a in "abcd"]


def test_a_cluster_finds_what_one_process_finds_whoever_is_killed(kind, tmp_path):
    said, rows = [], RowFile(tmp_path / "rows.jsonl")
    deeds = {"a2": "release", "b2": "kill worker once", "c1": "die once", "d1": "crash", "d2": "hang"}
    with opened(Workers(2, kind), lambda line, fraction: said.append(line)) as backend:
        found = run_jobs(jobs(tmp_path, **deeds), backend, rows, timeout=5.0)
    assert said == [line for line in said if line.startswith("2 workers of ")]
    undisturbed = run_jobs(jobs(tmp_path))
    assert found[:6] == undisturbed[:6]
    assert [f["reason"] for f in found[6:]] == ["ended its process by SIGABRT", "took longer than 5 s and was stopped"]
    assert RowFile(tmp_path / "rows.jsonl", resume=True).of(i for job in jobs(tmp_path) for i in job.ids) == found


def test_a_cluster_of_this_machine_is_for_this_machine_alone():
    pytest.importorskip("distributed", reason="the extra `dask` is not installed")
    with opened(Workers(1, "dask")) as backend:
        assert backend.client.scheduler.address.startswith("tcp://127.0.0.1:")


def test_a_cluster_of_dask_whose_worker_is_killed_as_it_begins_is_started_again(monkeypatch):
    distributed = pytest.importorskip("distributed", reason="the extra `dask` is not installed")
    started, start = [], distributed.LocalCluster

    def killed(**given):
        started.append(given["n_workers"])
        if len(started) < at_last:
            raise RuntimeError("Nanny failed to start.")
        return start(**given)

    monkeypatch.setattr(distributed, "LocalCluster", killed)
    at_last = 2
    with opened(Workers(1, "dask")) as backend:
        assert list(backend.each(abs, [(-1,)])) == [1]
    assert started == [1, 1]
    at_last = 9
    with pytest.raises(InputError, match="no cluster can be started on this machine: Nanny failed to start"):
        opened(Workers(1, "dask")).__enter__()
    assert len(started) == 2 + 3


def test_a_worker_that_is_killed_again_and_again_ends_the_evaluation_with_what_was_found(kind, tmp_path, monkeypatch):
    monkeypatch.setattr(runner, "_LOSSES", 1)
    (tmp_path / "others are done").touch()
    rows = RowFile()
    with opened(Workers(1, kind)) as backend, pytest.raises(WorkerLostError, match="2 findings are kept"):
        run_jobs([ToyJob(("a1", "a2", "a3"), tmp_path, (("a3", "die"),))], backend, rows)
    assert set(rows.found) == {"a1", "a2"}


def close_later(cluster, rows):
    while not rows.found:
        time.sleep(0.05)
    cluster.close()


class TestOtherMachines:
    """A scheduler that runs elsewhere: no files are shared."""

    @pytest.fixture
    def cluster(self, tmp_path):
        distributed = pytest.importorskip("distributed", reason="the extra `dask` is not installed")
        with distributed.LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=None) as cluster:
            yield cluster

    def test_findings_are_the_same_and_the_scheduler_may_go(self, cluster, tmp_path, monkeypatch):
        monkeypatch.setattr(sys.modules["ichain_drake.runs.clusters.dask"], "_TO_CONNECT", 1)
        monkeypatch.setattr(runner, "_LOSSES", 1)
        with opened(Workers(cluster=cluster.scheduler_address)) as backend:
            assert not backend.shares_files
            assert run_jobs(jobs(tmp_path), backend) == run_jobs(jobs(tmp_path))
            rows = RowFile()
            closing = threading.Thread(target=close_later, args=(cluster, rows))
            closing.start()
            with pytest.raises(WorkerLostError, match="its scheduler, is gone .* 1 findings are kept"):
                run_jobs([ToyJob(("a",), tmp_path), ToyJob(("b",), tmp_path, (("b", "hang"),))], backend, rows)
            closing.join()

    def test_other_code_there_is_refused(self, cluster, tmp_path, monkeypatch):
        monkeypatch.setattr(runner, "code_hash", lambda: "other")
        with (
            opened(Workers(cluster=cluster.scheduler_address)) as backend,
            pytest.raises(InputError, match=r"other code of ichain_drake \(\w{12}, here other\): install the same"),
        ):
            run_jobs(jobs(tmp_path), backend)

    def test_a_system_that_can_not_be_imported_there_is_named(self, cluster, tmp_path, monkeypatch):
        (tmp_path / "only_here.py").write_text("import toy_jobs\nclass OwnJob(toy_jobs.ToyJob):\n    pass\n")
        with opened(Workers(cluster=cluster.scheduler_address)) as backend:
            backend.client.wait_for_workers(1)  # it has this process's path of before
            monkeypatch.syspath_prepend(tmp_path)
            job = importlib.import_module("only_here").OwnJob(("a",), tmp_path)
            with pytest.raises(InputError, match="can't load a trial .*only_here.*: install ichain_drake there"):
                run_jobs([job], backend)

    def test_nobody_answers(self, monkeypatch):
        pytest.importorskip("distributed", reason="the extra `dask` is not installed")
        monkeypatch.setattr(sys.modules["ichain_drake.runs.clusters.dask"], "_TO_CONNECT", 1)
        with (
            pytest.raises(InputError, match=r"--cluster dask=tcp://127.0.0.1:9: .*is the scheduler there\?"),
            opened(Workers(cluster="tcp://127.0.0.1:9")),
        ):
            pass
