"""Trying the task with what was found so far: the surest test of a graph, and a piece about what matters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from ichain_drake.control.execution.memory import ExecutorSettings
from ichain_drake.control.execution.tasks import Mode
from ichain_drake.control.planning.goals import parse_goal
from ichain_drake.demonstrations import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.learning.discovery.edges import DiscoveredGraph
from ichain_drake.learning.discovery.labels import label_pieces
from ichain_drake.runs.goals.run import GraphRun, execute
from ichain_drake.runs.goals.settings import graph_spec
from ichain_drake.runs.goals.unlabelled import without_flags
from ichain_drake.runs.learn import learn
from ichain_drake.scenarios import build_world
from ichain_drake.scenarios.base import Progress
from ichain_drake.simulation.recorder import tabulate
from ichain_drake.simulation.wiring import look


@dataclass(frozen=True)
class Rehearsal:
    """What became of an attempt.

    Attributes:
        reached: whether the robot takes its goal for reached; nobody tells it.
        reason: why, or why not.
        piece: what was recorded in it, states alone; None if nothing could be tried.
    """

    reached: bool
    reason: str
    piece: Demonstration | None = None


def rehearse(
    scenario: Any,
    goal: Sequence[str],
    pieces: Sequence[Demonstration],
    found: DiscoveredGraph,
    number: int,
    ticks: int,
    say: Progress,
) -> Rehearsal:
    """Learn from pieces without flags, plan, and act, as `ichain run` does.

    Args:
        scenario: whose world it is in.
        goal: as text.
        pieces: states alone.
        found: the graph that they show.
        number: of the run; also names the piece.
        ticks: at most.
        say: called with a line at each plan.
    """
    declared = scenario.graph
    try:
        graph = InteractionGraph(declared.objects, [f.edge for f in found.found], declared.origins)
        labels = label_pieces(pieces, graph)
        model = learn(labels.graph, labels.pieces, spec=graph_spec(scenario.config))
        wanted = parse_goal(goal, model, look(build_world(scenario, run=number)))
    except InputError as error:
        return Rehearsal(False, str(error))
    run = GraphRun(scenario, goal, number, model=model)
    execute(run, model, wanted, build_world(scenario, run=number), None, ExecutorSettings(ticks=ticks), say)
    assert run.memory is not None and run.log is not None
    piece = tabulate(declared, run.log, tuple(declared.objects), f"rehearsed_{number}")
    return Rehearsal(run.memory.mode == Mode.REACHED, run.memory.reason, without_flags(piece))
