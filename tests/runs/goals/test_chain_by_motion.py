"""A goal at the end of a chain that works by motion alone, from demonstrations to the end of a run."""

import pytest
from well import Well

from ichain_drake.control.planning.plan import Plan
from ichain_drake.runs.goals.run import GraphRun, run_graph

pytestmark = pytest.mark.slow


def test_a_tray_is_wound_up_by_a_capstan_that_turns_more_than_once() -> None:
    run = GraphRun(Well((), "ideal", 7100))
    run_graph(run)
    assert run.goal_reached, (run.reason, run.memory and run.memory.log)
    assert isinstance(run.plan, Plan)
    (step,) = run.plan.steps
    assert [e.name for e in step.chain] == ["hand->capstan", "capstan->drum", "drum->tray"]
    assert step.predicted["drum"][0] > 6.5  # more than a turn
    for number in (1, 2, 3):
        again = GraphRun(Well((), "ideal", 7100), number=number)
        run_graph(again, known=run.model)
        assert again.goal_reached, (number, again.reason, again.memory and again.memory.log)
