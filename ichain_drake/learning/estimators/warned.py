"""What estimators warn of, in one line instead of one for each of hundreds of fits."""

from __future__ import annotations

import re
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from sklearn.exceptions import ConvergenceWarning, DataConversionWarning, FitFailedWarning, UndefinedMetricWarning

_ABOUT_FITS = (ConvergenceWarning, DataConversionWarning, FitFailedWarning, UndefinedMetricWarning, RuntimeWarning)


class EstimatorWarning(UserWarning):
    """A line about warnings that were collected."""


@contextmanager
def collected_warnings(say: Callable[[str], None] | None = None) -> Iterator[None]:
    """Hold back what estimators warn of inside, and say it in one line at the end.

    Args:
        say: called with the line; without it, it is given as an `EstimatorWarning`.
    """
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("default")
        for kind in (*_ABOUT_FITS, EstimatorWarning):
            warnings.simplefilter("always", kind)
        try:
            yield
        finally:
            held = list(caught)
    counts: Counter[str] = Counter()
    for one in held:
        if issubclass(one.category, EstimatorWarning):
            counts[str(one.message)] += 1
        elif issubclass(one.category, _ABOUT_FITS):
            counts[f"{one.category.__name__}: {_short(str(one.message))}"] += 1
        else:
            warnings.warn_explicit(one.message, one.category, one.filename, one.lineno, source=one.source)
    if not counts:
        return
    total = sum(counts.values())
    line = "; ".join(text if count == 1 else f"{text} ({count} times)" for text, count in counts.most_common(3))
    if total > 1 or not line.startswith("estimators warned"):
        line = f"estimators warned {total} times: {line}"
    if say is not None:
        say(line)
    else:
        warnings.warn(line, EstimatorWarning, stacklevel=3)


def _short(text: str) -> str:
    """The first sentence."""
    return re.split(r"[.:\n]\s", " ".join(text.split()) + " ", maxsplit=1)[0].strip()[:120]
