"""How noisy readings are, told from the readings alone."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ichain_drake.demonstrations.columns import as_numbers, column
from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.graph import InteractionGraph

_FEWEST = 20  # pairs of steps from which anything is told
_OPPOSED = -0.2  # correlation of a step with the next: -1/2 for nothing but noise, positive for smooth motion
_MOST = 0.03  # of a column's range: what goes to and fro further is a motion


def column_noise(pieces: Sequence[Demonstration], graph: InteractionGraph) -> dict[str, float]:
    """Standard deviation of the noise of each measured column, by its name; 0 where none is seen.

    Noise makes a reading that went up go down again: successive steps are opposed. Slow steps alone are asked, so that
    motion doesn't hide it.

    Args:
        pieces: checked demonstrations.
        graph: declares what is measured.
    """
    noise = {}
    for obj, space in graph.objects.items():
        for variable in space.observable.variables:
            name = column(obj, variable.name)
            shown = [as_numbers(p.table[name]) for p in pieces if name in p.table]
            noise[name] = 0.0
            if shown and variable.kind in ("real", "angle"):
                steps = [np.diff(np.unwrap(v) if variable.kind == "angle" else v) for v in shown]
                found = _std(np.concatenate([np.stack([s[:-1], s[1:]], axis=1) for s in steps]))
                noise[name] = found if found < _MOST * np.ptp(np.concatenate(shown)) else 0.0
    return noise


def _std(pairs: np.ndarray) -> float:
    moving = pairs[(pairs != 0).all(axis=1)]
    if len(moving) < _FEWEST:
        return 0.0
    size = np.abs(moving).max(axis=1)
    slow = moving[size <= np.median(size)]
    power = float(np.mean(slow**2))
    opposed = float(np.mean(slow[:, 0] * slow[:, 1]))
    return float(np.sqrt(-opposed)) if power > 0 and opposed < _OPPOSED * power else 0.0
