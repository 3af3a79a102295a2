"""How cost grows: what is measured, and the text; never a time."""

import numpy as np
import pytest
import small_world

from ichain_drake.benchmarks.chain_length import learn_dial
from ichain_drake.benchmarks.cluster_overhead import benchmark_clusters
from ichain_drake.benchmarks.many_objects import benchmark_objects
from ichain_drake.benchmarks.many_rows import benchmark_rows, repeated
from ichain_drake.benchmarks.scaling import format_scaling
from ichain_drake.errors import IchainError
from ichain_drake.learning import learn_interactions


@pytest.fixture(scope="module")
def objects() -> dict:
    machine = learn_interactions(small_world.pieces(0), small_world.GRAPH)
    size = len(small_world.GRAPH.objects) - 1
    found = benchmark_objects(machine, learn_dial(), (1, 2 * size + 1, 3 * size), 1)
    assert found["objects"] == [size, 2 * size, 3 * size]
    return found


def test_a_tick_is_timed_in_every_way(objects: dict) -> None:
    assert set(objects["ms"]) == set(objects["fit"]) == {"step", "step_batch", "diagram", "chain"}
    assert all(ms > 0 for times in objects["ms"].values() for ms in times)


def test_repeated_pieces_differ_by_the_noise_of_readings_alone() -> None:
    pieces = small_world.pieces(0)
    rows = 3 * sum(map(len, pieces))
    more = repeated(pieces, small_world.GRAPH, rows)
    assert rows <= sum(map(len, more)) < rows + max(map(len, pieces))
    assert len({p.name for p in more}) == len(more)
    first, again = more[0].table, more[len(pieces)].table
    for name in first:
        difference = np.abs(first[name] - again[name])
        assert difference.max() < 0.1 * max(np.ptp(first[name]), 1e-9) or "->" not in name
        assert difference.max() == 0 or ("->" not in name and name != "time")
    for edge in small_world.GRAPH.interactions:
        assert np.array_equal(first[edge.name], again[edge.name])


def test_a_size_that_cannot_be_measured_is_told_with_the_reason() -> None:
    with pytest.raises(
        IchainError, match=r"learning from 0 rows could not be measured: .*0 rows: give a number from 1"
    ):
        benchmark_rows((0,))


def test_text(objects: dict) -> None:
    sizes = [{"rows": 1000, "pieces": 7, "seconds": 2.0, "peak_mb": 300.0}]
    rows = {"sizes": sizes, "fit": {"slope": 2e-3, "r_squared": 1.0}}
    text = format_scaling({"objects": objects, "rows": rows, "clusters": None})
    assert "1000       7  2.0      300" in text
    assert "not measured: the extra `dask` is not installed" in text


def test_a_cluster_finds_what_processes_find() -> None:
    pytest.importorskip("distributed", reason="the extra `dask` is not installed")
    found = benchmark_clusters(4, 0.05, 2, 1)
    assert found is not None
    assert found["ratio"] == pytest.approx(found["dask"] / found["loky"])
    text = format_scaling(
        {
            "objects": {"objects": [4], "batch": 2, "ms": {}, "fit": {}},
            "rows": {"sizes": [], "fit": {"slope": 1e-6, "r_squared": 1.0}},
            "clusters": found,
        }
    )
    assert "4 trials of 0.05 s, 2 workers, Dask" in text
