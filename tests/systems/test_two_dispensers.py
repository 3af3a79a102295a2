"""Two dispensers in one scene: a goal that needs both is planned from pieces at the one or the other."""

from functools import cache

import pytest

from ichain_drake.control.planning.plan import Plan
from ichain_drake.demonstrations import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.learning import InteractionSpec
from ichain_drake.runs.goals.plan import make_plan
from ichain_drake.runs.learn import learn
from ichain_drake.simulation.wiring import look
from ichain_drake.systems import load_scenario
from ichain_drake.systems.two_dispensers.scenario import MACHINES, TwoDispensers


@cache
def scenario() -> TwoDispensers:
    return TwoDispensers((), "ideal")


@cache
def pieces() -> tuple[Demonstration, ...]:
    return tuple(scenario().record_demonstrations())


def test_every_piece_shows_one_machine_at_most_and_every_edge_is_shown() -> None:
    shown = set()
    for piece in pieces():
        active = {e.name for e in scenario().graph.interactions if (piece.table[e.name] > 0.5).any()}
        assert len({m for m in MACHINES if any(m in name for name in active)}) <= 1, piece.name
        shown |= active
    assert shown == {e.name for e in scenario().graph.interactions}


def test_a_goal_that_needs_both_machines() -> None:
    quick = InteractionSpec(status_estimators=InteractionSpec().status_estimators[:1])
    knowledge = learn(scenario().graph, pieces(), spec=quick)
    _, plan = make_plan(knowledge, scenario().config.goal, look(scenario().make_world(0)))
    assert isinstance(plan, Plan), plan
    last = {step.chain[-1].child for step in plan.steps}
    assert {"near_tank", "far_tank"} <= last
    end = plan.steps[-1].predicted
    assert end["near_tank"][0] >= 0.2
    assert end["near_tank"][1] <= 0.3
    assert end["cup"][5] >= 0.9


@pytest.mark.parametrize("physics", ["arm", "contact"])
def test_an_arm_does_not_reach_both(physics: str) -> None:
    with pytest.raises(InputError, match="--physics ideal"):
        load_scenario("two_dispensers", (), physics)  # type: ignore[arg-type]


def test_machines_that_overlap_are_refused() -> None:
    with pytest.raises(InputError, match=r"spacing is -0\.1 m; the machines need 0\.5 m"):
        TwoDispensers(["spacing=-0.1"], "ideal")
