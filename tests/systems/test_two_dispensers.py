"""Two dispensers in one scene: a goal that needs both is planned from pieces at the one or the other."""

from functools import cache

import numpy as np
import pytest

from ichain_drake.control.planning.plan import Plan
from ichain_drake.demonstrations import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.learning import InteractionSpec
from ichain_drake.runs.goals.plan import make_plan
from ichain_drake.runs.learn import learn
from ichain_drake.simulation.wiring import look
from ichain_drake.systems import load_scenario
from ichain_drake.systems.two_dispensers.scenario import TwoDispensers


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
        assert len({m for m in scenario().machines if any(m in name for name in active)}) <= 1, piece.name
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


def test_more_machines_stand_in_a_row() -> None:
    row = TwoDispensers(["machines=4", "spacing=-0.7"], "ideal")
    assert row.machines == ("near", "far", "more1", "more2")
    places = [row.button_mount(f"{m}_power").top[1] for m in row.machines]
    assert [round(a - b, 6) for a, b in zip(places[:-1], places[1:], strict=True)] == [0.7] * 3
    assert len(row.graph.objects) == 2 + 3 * 4
    assert {e.parent for e in row.graph.incoming("cup")} == {"hand", *(f"{m}_tank" for m in row.machines)}
    assert len(list(row.script(np.random.default_rng(0)))) > len(list(scenario().script(np.random.default_rng(0))))


def test_one_machine_needs_no_spacing_and_none_is_no_row() -> None:
    assert TwoDispensers(["machines=1", "spacing=0"], "ideal").machines == ("near",)
    with pytest.raises(InputError, match=r"machines is 0; give a whole number from 1 to 64"):
        TwoDispensers(["machines=0"], "ideal")
