"""The table of a path evaluation beside the same figures by hand."""

from __future__ import annotations

import numpy as np
import pytest

from ichain_drake.runs.intervals import success_interval
from ichain_drake.runs.paths.summary import ORACLE, summarise


def row(method: str, seed: int, error: float | None, case: str = "eight", samples: int = 100) -> dict[str, object]:
    return {
        "method": method, "samples": samples, "case": case, "seed": seed, "success": error is not None,
        "error": error, "unit": "px",
    }  # fmt: skip


def test_errors_are_of_completed_runs_and_ratios_of_seeds_that_both_completed() -> None:
    rows = [row("own", 1, 2.0), row("own", 2, 4.0), row("own", 3, 9.0), row("own", 4, None)]
    rows += [row(ORACLE, 1, 1.0), row(ORACLE, 2, 2.0), row(ORACLE, 3, None), row(ORACLE, 4, 5.0)]
    own, oracle = summarise(rows)
    assert (own["method"], own["case"], own["samples"], own["unit"]) == ("own", "eight", 100, "px")
    assert (own["runs"], own["completed"]) == (4, 3)
    assert own["interval"] == success_interval(3, 4)
    assert (own["mean_error"], own["max_error"]) == (5.0, 9.0)
    assert own["std_error"] == pytest.approx(np.std([2.0, 4.0, 9.0]))
    assert own["ratio_to_oracle"] == pytest.approx((2.0 + 4.0) / (1.0 + 2.0))
    assert oracle["ratio_to_oracle"] == 1.0


def test_a_line_a_method_number_and_path_in_the_order_of_the_rows() -> None:
    rows = [row("b", 1, 1.0, samples=200), row("b", 1, 1.0), row("a", 1, None), row("b", 1, 3.0, "line")]
    table = summarise(rows)
    assert [(t["method"], t["samples"], t["case"]) for t in table] == [
        ("b", 200, "eight"), ("b", 100, "eight"), ("a", 100, "eight"), ("b", 100, "line"),
    ]  # fmt: skip
    lost = table[2]
    assert [lost[k] for k in ("completed", "mean_error", "std_error", "max_error", "ratio_to_oracle")] == [0] + [
        None
    ] * 4
    assert summarise([]) == []
