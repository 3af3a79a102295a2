"""The demonstrations of a run, recorded or read, and the settings of learning: for paths and goals alike."""

from __future__ import annotations

from collections.abc import Callable, Collection
from contextlib import nullcontext
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits

from ichain_drake.demonstrations import Demonstration, read_demonstrations, write_demonstrations
from ichain_drake.demonstrations.quality import tell_findings
from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning import read_pieces
from ichain_drake.learning.enough import learned_bound
from ichain_drake.learning.estimators.trial import try_out
from ichain_drake.runs.goals.settings import graph_spec
from ichain_drake.runs.open_piece import OpenScript
from ichain_drake.runs.paths.demonstrations import check_in_plane, check_moves
from ichain_drake.scenarios.base import PathScenario
from ichain_drake.simulation.noting import noted_in
from ichain_drake.simulation.recorder import RecordingInterrupted


def check_settings(scenario: Any) -> None:
    """Refuse what learning would refuse, before minutes of recording; a scenario has checked the rest.

    Raises:
        InputError: on an unknown estimator or parameter, or a setting that is for the other kind of task; names it.
    """
    if not isinstance(scenario, PathScenario):
        graph_spec(scenario.config)
        return
    tried: set[str] = set()
    for name, link in scenario.config.learning.candidates().items():
        for spec in (*link.forward, *link.inverse, *([link.screening] if link.screening else [])):
            if str(spec) in tried:
                continue
            tried.add(str(spec))
            try:
                try_out(spec.make())
            except (ValueError, TypeError) as error:  # InputError is one; constructors may raise both
                raise InputError(f"{name}: {spec}: {error}") from None


def read_for(
    scenario: Any,
    folder: Path,
    known: Collection[Interaction] = (),
    *,
    graph: InteractionGraph | None = None,
    resampled: bool = False,
    unlabelled: bool = False,
    say: Callable[[str], None] = lambda line: None,
) -> list[Demonstration]:
    """Read and check the demonstrations of a folder, and say what is odd about them.

    Args:
        scenario: that will learn from them.
        folder: with the pieces.
        known: interactions that they need not show.
        graph: to learn, in place of the scenario's own.
        resampled: whether to take pieces of another period to the library's.
        unlabelled: whether flags may be missing or empty.
        say: called with a line on each thing that was done or found.

    Raises:
        InputError: as `read_demonstrations` and `read_pieces`, and if what follows paths is shown far from the plane.
    """
    if isinstance(scenario, PathScenario):
        pieces = read_demonstrations(folder, scenario.graph, resampled=resampled, say=say, bound=learned_bound())
        check_in_plane(pieces, scenario)
        check_moves(pieces, scenario)
    else:
        graph = graph or scenario.graph
        pieces = read_pieces(folder, graph, known, resampled=resampled, unlabelled=unlabelled, say=say)
    if not unlabelled:
        tell_findings(pieces, graph or scenario.graph, say)
    return pieces


def record_pieces(
    scenario: Any,
    pieces: list[Demonstration],
    keep: Path | None = None,
    say: Callable[[str], None] = lambda line: None,
    known: Collection[str] = (),
    *,
    overwrite: bool = False,
) -> None:
    """Record demonstrations, writing each as soon as it is there, and say what is odd about them.

    What Ctrl-C leaves of a piece is kept, too; what a kill leaves is in a hidden file (`save_left_behind`).

    Args:
        scenario: with a script.
        pieces: is given them.
        keep: folder for them.
        say: called with a line before each.
        known: names of interactions that need none.
        overwrite: whether files in that folder may be replaced.
    """
    notebook = None if keep is None else OpenScript(keep)
    try:
        with threadpool_limits(limits=1), nullcontext() if notebook is None else noted_in(notebook):
            for piece in scenario.record_demonstrations(say, known):
                pieces.append(piece)
                if keep is not None and notebook is not None:
                    write_demonstrations([piece], keep, overwrite=overwrite)
                    notebook.close()
    except RecordingInterrupted as stopped:
        pieces.append(stopped.piece)
        if keep is not None:
            write_demonstrations([stopped.piece], keep, overwrite=overwrite)
        raise
    finally:
        if notebook is not None:
            notebook.close()
    tell_findings(pieces, scenario.graph, say)
