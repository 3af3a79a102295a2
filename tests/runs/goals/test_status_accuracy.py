"""Figures of status classifiers beside the same counted by hand."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from moved_thing import EDGE, model

from ichain_drake.demonstrations import Demonstration
from ichain_drake.runs.goals.status_accuracy import count_events, held_out_scores, probe_scores


def piece(flags: list[int], xs: list[float]) -> Demonstration:
    n = len(flags)
    columns = {"time": np.arange(n) / 3, "robot.x": np.zeros(n), "robot.grip": np.ones(n)}
    return Demonstration(pd.DataFrame({**columns, "thing.x": xs, "thing.water": 0.5, EDGE.name: flags}))


def learned():
    """Active where the thing is at less than .5; once it is, up to .7."""
    toy = model()
    toy.decide = lambda edge, states: 0.5 - states["thing"][..., 0]
    toy.active = lambda states, before: {EDGE: states["thing"][0] < (0.7 if before and before[EDGE] else 0.5)}
    return toy


def test_rows_and_events_are_counted_and_the_status_is_followed_from_row_to_row() -> None:
    one = piece([0, 1, 1, 1, 0, 0], [0.9, 0.1, 0.6, 0.6, 0.9, 0.9])
    two = piece([1, 1, 0, 0], [0.1, 0.1, 0.1, 0.9])
    assert [count_events([p], EDGE) for p in (one, two)] == [2, 1]
    scores = held_out_scores(learned(), [one, two])[EDGE]
    # Row by row: hits at rows 1 of the first and 0, 1 of the second; two missed, one wrong.
    assert (scores["rows"], scores["events"]) == (10, 3)
    assert scores["status_f1"] == pytest.approx(2 * 3 / (2 * 3 + 3))
    assert scores["event_f1"] == 1.0, "within one row, with hysteresis"


def test_near_misses_are_told_apart_from_what_is_inside() -> None:
    active = np.array([True, True, False, False, False])
    true = {"thing": np.array([[0.1, 0], [0.6, 0], [0.9, 0], [0.8, 0], [0.4, 0]])}
    read = {"thing": np.array([[0.1, 0], [0.2, 0], [0.9, 0], [0.8, 0], [0.7, 0]])}
    gate = np.array([True, False, False, True, False])
    probes = SimpleNamespace(active=active, true=true, read=read, gate=gate, border=["a", "a", "a", "b", "b"])
    found = probe_scores(learned(), EDGE, probes)  # type: ignore[arg-type]
    borders = found.pop("borders")
    assert found == pytest.approx(
        {"near_misses": 3, "near_miss_f1": 0.5, "near_miss_read_f1": 1.0, "gate_read_f1": 0.5}
    )
    assert borders["a"] == pytest.approx(
        {"near_misses": 1, "near_miss_f1": 2 / 3, "near_miss_read_f1": 1.0, "gate_read_f1": 2 / 3}
    )
    assert borders["b"]["near_misses"] == 2
    probes.border = ["a"] * 5
    assert probe_scores(learned(), EDGE, probes)["borders"] == {}  # type: ignore[arg-type]
    assert probe_scores(learned(), EDGE, None) == {
        **dict.fromkeys(("near_misses", "near_miss_f1", "near_miss_read_f1", "gate_read_f1")), "borders": {},
    }  # fmt: skip
