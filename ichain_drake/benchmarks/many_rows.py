"""How time and memory of learning grow with the number of rows, each size in a process of its own."""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ichain_drake.benchmarks.measure import line_fit
from ichain_drake.demonstrations import Demonstration, column
from ichain_drake.errors import IchainError, InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.learning.noise import change_noise
from ichain_drake.runs.learn import learn
from ichain_drake.systems.water_dispenser.scenario import WaterDispenser

_SEEDS = 2  # whose pieces are recorded; the others repeat them


def repeated(pieces: Sequence[Demonstration], graph: InteractionGraph, rows: int, seed: int = 0) -> list[Demonstration]:
    """Pieces of so many rows in all: those given, then the same again and again, each read with noise of its own.

    Recording 10^6 rows would take an hour; what learning costs does not ask where rows come from.

    Args:
        pieces: recorded ones.
        graph: their objects.
        rows: at least so many; no more than a piece beyond.
        seed: of the noise.
    """
    noise: dict[str, float] = {}
    for name, space in graph.objects.items():
        std = change_noise(space.observable, [p.states(name, space) for p in pieces])
        kinds = zip(space.observable.variables, std, strict=True)
        noise |= {column(name, v.name): s for v, s in kinds if v.kind in ("real", "angle")}
    random, out, total = np.random.default_rng(seed), list[Demonstration](), 0
    while total < rows:
        piece = pieces[len(out) % len(pieces)]
        table = piece.table
        if len(out) >= len(pieces):
            read = {c: table[c].to_numpy() + s * random.standard_normal(len(table)) for c, s in noise.items()}
            table = table.assign(**read)
        out.append(replace(piece, table=table, name=f"piece {len(out)}"))
        total += len(table)
    return out


def measure_rows(rows: int) -> dict[str, Any]:
    """Learn from so many rows of the water dispenser, in this process.

    Args:
        rows: how many, at least.

    Returns:
        `rows` and `pieces` there were, `seconds` of processor time that learning took, `peak_mb` of this process.

    Raises:
        InputError: if that is none.
    """
    if rows < 1:
        raise InputError(f"{rows} rows: give a number from 1")
    recorded = [
        piece for seed in range(_SEEDS) for piece in WaterDispenser((), "ideal", 100 + seed).record_demonstrations()
    ]
    scenario = WaterDispenser((), "ideal", 100)
    pieces = repeated(recorded, scenario.graph, rows)
    begin = time.process_time()
    learn(scenario, pieces)
    seconds = time.process_time() - begin
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1000.0
    return {"rows": sum(map(len, pieces)), "pieces": len(pieces), "seconds": seconds, "peak_mb": peak}


def benchmark_rows(rows: Sequence[int]) -> dict[str, Any]:
    """Time and memory of learning against the number of rows.

    Args:
        rows: sizes.

    Returns:
        `sizes`, one entry a size (see `measure_rows`), and `fit`: a line through the seconds, per row.

    Raises:
        IchainError: if a size could not be measured.
    """
    sizes = []
    for count in rows:
        code = f"import json; from {__name__} import measure_rows; print(json.dumps(measure_rows({count})))"
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
        if done.returncode:
            last = (done.stderr.strip().splitlines() or [f"it ended with status {done.returncode}"])[-1]
            raise IchainError(f"learning from {count} rows could not be measured: {last}")
        sizes.append(json.loads(done.stdout))
    return {"sizes": sizes, "fit": line_fit([s["rows"] for s in sizes], [s["seconds"] for s in sizes])}
