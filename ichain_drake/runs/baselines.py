"""What others' packages find in the same logs, run as they are: extra `baselines`.

Edges by PCMCI+ (Runge 2020, package tigramite): conditional independence of columns at the same and the last row, by
partial correlation. Cuts by kernel change points (Arlot et al. 2019, package ruptures), with the penalty of its manual.
"""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from typing import Any

import numpy as np

from ichain_drake.demonstrations import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction, InteractionGraph

PCMCI, RUPTURES = "edges@pcmci+", "cuts@ruptures"
BASELINES = (PCMCI, RUPTURES)
"""Methods of `ichain evaluate`."""

_LEVEL = 0.01  # of its tests: PCMCI+'s own default
_PENALTY = 10.0  # of a change point, as in the manual of ruptures


def _package(name: str) -> Any:
    """A module of an optional package.

    Raises:
        InputError: says how to install it.
    """
    try:
        return import_module(name)
    except ImportError:
        package = name.split(".", maxsplit=1)[0]
        raise InputError(f"{package} is missing: pip install 'ichain_drake[baselines]'") from None


def check_baselines(methods: Sequence[str]) -> None:
    """Refuse methods whose package isn't there, before minutes of recording.

    Raises:
        InputError: says how to install it.
    """
    for method, module in ((PCMCI, "tigramite"), (RUPTURES, "ruptures")):
        if method in methods:
            _package(module)


def pcmci_edges(pieces: Sequence[Demonstration], graph: InteractionGraph) -> set[Interaction]:
    """Edges by PCMCI+: an object acts on another if one of its columns is found to cause one of the other's.

    Args:
        pieces: with all objects.
        graph: declares the objects, and which is the robot.

    Raises:
        InputError: if tigramite is missing.
    """
    data_processing = _package("tigramite.data_processing")
    pcmci = _package("tigramite.pcmci").PCMCI
    test = _package("tigramite.independence_tests.parcorr").ParCorr()
    owner, states = _columns(pieces, graph)
    data = data_processing.DataFrame(dict(enumerate(states)), analysis_mode="multiple")
    found = pcmci(data, test, verbosity=0).run_pcmciplus(tau_min=0, tau_max=1, pc_alpha=_LEVEL)["graph"]
    return {
        Interaction(owner[i], owner[j])
        for i, j in zip(*np.nonzero((found == "-->").any(axis=2)), strict=True)
        if owner[i] != owner[j] and owner[j] != graph.root
    }


def ruptures_cuts(log: Demonstration, graph: InteractionGraph) -> list[int]:
    """Rows behind change points of a recording, by kernels on standardised columns.

    Args:
        log: one recording.
        graph: declares the objects; those that it holds are looked at.

    Raises:
        InputError: if ruptures is missing.
    """
    held = {n: s for n, s in graph.objects.items() if log.has(n, s)}
    values = np.hstack([log.states(n, s) for n, s in held.items()])
    values = values[:, np.ptp(values, axis=0) > 0]
    standard = (values - values.mean(axis=0)) / values.std(axis=0)
    detector = _package("ruptures").KernelCPD(kernel="rbf", min_size=2)
    return [int(row) for row in detector.fit(standard).predict(pen=_PENALTY)[:-1]]


def _columns(pieces: Sequence[Demonstration], graph: InteractionGraph) -> tuple[list[str], list[np.ndarray]]:
    """Columns that change, and whose they are."""
    owner = [n for n, s in graph.objects.items() for _ in s.observable.names]
    states = [np.hstack([p.states(n, s) for n, s in graph.objects.items()]) for p in pieces]
    change = np.ptp(np.vstack(states), axis=0) > 0
    return [n for n, kept in zip(owner, change, strict=True) if kept], [x[:, change] for x in states]
