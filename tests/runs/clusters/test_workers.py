"""Who works: how many fit, where, and what is refused."""

import joblib
import pytest

from ichain_drake.errors import InputError
from ichain_drake.runs.clusters import workers
from ichain_drake.runs.clusters.backend import opened
from ichain_drake.runs.clusters.workers import Workers, free_memory


@pytest.fixture
def plenty(monkeypatch):
    monkeypatch.setattr(workers, "free_memory", lambda: 1 << 40)


def test_no_more_processes_than_cores(plenty):
    said = []
    cores = joblib.cpu_count()
    assert Workers(1000).usable_processes(lambda line, fraction: said.append(line)) == cores
    assert said == [f"{cores} processes of the 1000 asked for: there are {cores} cores"]
    assert Workers(1).usable_processes(lambda line, fraction: said.append(line)) == 1
    assert len(said) == 1


@pytest.mark.parametrize(("free", "fit"), [(5 << 29, 2), (1 << 20, 1)])
def test_no_more_processes_than_the_memory_holds(monkeypatch, free, fit):
    monkeypatch.setattr(workers, "free_memory", lambda: free)
    monkeypatch.setattr(joblib, "cpu_count", lambda: 64)
    said = []
    with opened(Workers(8), lambda line, fraction: said.append(line)) as backend:
        assert backend.processes == fit
    assert said == [
        f"{fit} processes of the 8 asked for: there are {free / 2**30:.1f} GiB of free memory, for 1 GiB each"
    ]


def test_memory_is_that_of_the_container_where_it_has_less(monkeypatch, tmp_path):
    free = free_memory()
    assert free is not None and free > 1 << 20
    (tmp_path / "memory.max").write_text("max\n")
    monkeypatch.setattr(workers, "_GROUPS", tmp_path)
    assert free_memory() > 4096
    (tmp_path / "memory.max").write_text("4096\n")
    assert free_memory() == 4096


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"processes": 0}, "give numbers from 1"),
        ({"trial_timeout": 0.0}, "--trial-timeout 0: give seconds above 0"),
        ({"trial_timeout": float("inf")}, "give seconds above 0"),
        ({"cluster": "slurm"}, "--cluster slurm: give dask, dask=tcp://HOST:PORT, ray or ray=ADDRESS"),
        ({"cluster": "http://host"}, "--cluster http://host: give dask"),
    ],
)
def test_what_is_refused(given, words):
    with pytest.raises(InputError, match=words.replace("?", r"\?")):
        Workers(**given)


def test_a_missing_extra_is_named(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "ray", None)
    with pytest.raises(InputError, match=r"--cluster ray: .*; pip install 'ichain_drake\[ray\]'"):
        Workers(cluster="ray")


def test_kind_and_address(monkeypatch):
    monkeypatch.setattr(workers, "extra", lambda kind: None)
    found = [
        Workers(cluster=c) for c in ("", "dask", "dask=tcp://a:1", "tcp://a:1", "tls://a:1", "ray=auto", "ray://a:1")
    ]
    assert [(w.kind, w.address) for w in found] == [
        ("", ""), ("dask", ""), ("dask", "tcp://a:1"), ("dask", "tcp://a:1"), ("dask", "tls://a:1"), ("ray", "auto"),
        ("ray", "ray://a:1"),
    ]  # fmt: skip
    with pytest.raises(InputError, match="--jobs is for this machine: how many work at tcp://a:1"):
        Workers(2, "tcp://a:1")
