"""The table of a path evaluation: one line a method and path, out of one row a run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from ichain_drake.runs.intervals import seed_words, success_interval

ORACLE = "oracle"
"""The method that ratios are to."""


def summarise(rows: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """One line per method, samples and path: runs, completed ones, mean and spread of their error, ratio to the oracle.

    The ratio is of means over the seeds that both completed.
    """
    if not rows:
        return []
    frame = pd.DataFrame(rows)
    oracle = frame[frame.method == ORACLE].set_index(["case", "seed"])["error"]
    table = []
    for (method, _, case), group in frame.groupby(["method", "samples", "case"], sort=False):
        done = group[group.success]
        errors = done.error.astype(float)
        both = done.join(oracle.rename("oracle_error"), on=["case", "seed"])
        both = both.dropna(subset=["oracle_error"])
        ratio = float(both.error.mean() / both.oracle_error.mean()) if len(both) else None
        table.append(
            {
                "method": method,
                "samples": int(group.samples.iloc[0]),
                "case": case,
                "runs": len(group),
                "completed": len(done),
                "interval": success_interval(len(done), len(group)),
                "seeds": seed_words(group.seed),
                "mean_error": float(errors.mean()) if len(done) else None,
                "std_error": float(np.std(errors)) if len(done) else None,
                "max_error": float(errors.max()) if len(done) else None,
                "ratio_to_oracle": ratio,
                "unit": str(group.unit.iloc[0]),
            }
        )
    return table
