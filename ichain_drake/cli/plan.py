"""The command `plan`."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Any

from ichain_drake.cli.console import Reporter
from ichain_drake.cli.run import check_there, goal_of, known_of
from ichain_drake.control.planning.format import format_plan
from ichain_drake.control.planning.plan import Plan
from ichain_drake.demonstrations import Demonstration
from ichain_drake.graph import Interaction
from ichain_drake.learning import InteractionModel
from ichain_drake.runs.goals.plan import make_plan
from ichain_drake.runs.goals.settings import graph_spec, planner_of
from ichain_drake.runs.goals.unlabelled import Taught
from ichain_drake.runs.learn import learn_rest
from ichain_drake.runs.pieces import read_for, record_pieces
from ichain_drake.simulation.wiring import look


def print_plan(
    scenario: Any,
    expressions: list[str],
    demos: Path | None,
    library: Path | None = None,
    *,
    lift: bool = False,
    resampled: bool = False,
    explain: bool = False,
    taught: Taught | None = None,
) -> int:
    """`ichain plan`: learn (what the library doesn't know of the graph), look, plan, print.

    Returns:
        The exit status: 0 with a plan, 1 without.

    Raises:
        InputError: on bad input.
    """
    goal = goal_of(scenario, expressions)
    spec = graph_spec(scenario.config)
    before = known_of(scenario, library, lift=lift)
    check_there(demos)
    taught = taught or Taught()
    graph, unlabelled = taught.graph(scenario.graph), taught.unlabelled
    with Reporter() as say:

        def show(known: Collection[Interaction]) -> Sequence[Demonstration]:
            if demos is not None:
                return read_for(
                    scenario, demos, known, graph=graph, resampled=resampled, unlabelled=unlabelled, say=say.note
                )
            say("recording demonstrations")
            pieces: list[Demonstration] = []
            record_pieces(scenario, pieces, say=say, known=[e.name for e in known])
            return pieces

        if unlabelled and not isinstance(before, InteractionModel):
            labels = taught.labelled(show(()), graph, say.note, recorded=demos is None)
            model = learn_rest(lambda known: labels.pieces, labels.graph, before, spec, say)
        else:
            model = learn_rest(show, graph, before, spec, say)
        start = look(scenario.make_world(0))
        say("planning")
        _, plan = make_plan(model, goal, start, planner_of(scenario.config))
    if isinstance(plan, Plan):
        print(format_plan(plan, scenario.graph, start, likely=explain))
        return 0
    print("\n".join([plan.reason, *(plan.tree if explain else ())]))
    return 1
