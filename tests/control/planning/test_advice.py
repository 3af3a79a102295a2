"""What to demonstrate next: about the step that failed, like the nearest piece, where the run was elsewhere."""

from dataclasses import replace

import numpy as np
import pytest

from ichain_drake.control.planning.advice import helpful_demonstration
from ichain_drake.control.planning.experience import Contradiction
from ichain_drake.control.planning.goals import parse_goal
from ichain_drake.control.planning.plan import Condition, NoPlan, Plan, PlanStep
from ichain_drake.graph import Interaction
from ichain_drake.learning import InteractionModel
from ichain_drake.simulation.wiring import look, make_planner
from ichain_drake.state import FloatArray
from ichain_drake.systems.water_dispenser.scenario import WaterDispenser

TAKE, PRESS = Interaction("hand", "cup"), Interaction("hand", "power")


@pytest.fixture(scope="module")
def start(dispenser_model: InteractionModel) -> dict[str, FloatArray]:
    return dict(look(WaterDispenser((), "ideal", 3).make_world(0)))


@pytest.fixture(scope="module")
def steps(dispenser_model: InteractionModel, start: dict[str, FloatArray]) -> tuple[PlanStep, ...]:
    plan = make_planner(dispenser_model).plan(start, parse_goal(["cup.temperature >= 0.9"], dispenser_model, start))
    assert isinstance(plan, Plan)
    return plan.steps


def refusal(edge: Interaction | None) -> NoPlan:
    return NoPlan(Condition("cup", "water", 0.9, 1.0), 0.1, edge, "no")


def test_where_nothing_failed_there_is_nothing_to_go_by(
    dispenser_model: InteractionModel, start: dict[str, FloatArray]
) -> None:
    assert helpful_demonstration(dispenser_model, (), None, start) is None
    assert helpful_demonstration(dispenser_model, (), refusal(None), start) is None


def test_what_no_interaction_is_to_blame_for_nothing_shown_would_change(
    dispenser_model: InteractionModel, start: dict[str, FloatArray], steps: tuple[PlanStep, ...]
) -> None:
    failed = [Contradiction(steps[0], start)]
    assert helpful_demonstration(dispenser_model, failed, refusal(None), start) is None
    assert helpful_demonstration(dispenser_model, failed, None, start) is not None


def test_what_a_plan_lacked_is_to_be_shown_where_the_run_was(
    dispenser_model: InteractionModel, start: dict[str, FloatArray]
) -> None:
    graph = dispenser_model.graph
    away = {n: s.copy() for n, s in start.items()}
    away["cup"][graph.objects["cup"].observable.index("y")] += 1.0
    advice = helpful_demonstration(dispenser_model, (), refusal(TAKE), away)
    assert advice is not None
    assert advice.edge == TAKE
    assert advice.piece in dispenser_model.edges[TAKE].examples.activations.pieces
    assert next(iter(advice.region)) == ("cup", "y")
    assert advice.region["cup", "y"] == away["cup"][1]
    said = advice.text(graph)
    assert said.startswith(f"what would have helped most: another piece that shows hand->cup, like {advice.piece}, but")
    assert f"cup.y about {away['cup'][1]:.3g} m" in said
    region = {f"{n}.{v}": x for (n, v), x in advice.region.items()}
    assert advice.report() == {"interaction": "hand->cup", "like": advice.piece, "with": region}


def test_as_it_was_shown_it_is_to_be_shown_again(
    dispenser_model: InteractionModel, start: dict[str, FloatArray]
) -> None:
    shown = dispenser_model.edges[PRESS].examples.activations
    advice = helpful_demonstration(dispenser_model, (), refusal(PRESS), {n: v[0] for n, v in shown.before.items()})
    assert advice is not None
    assert advice.region == {}
    assert advice.text(dispenser_model.graph).endswith(f"shows hand->power, such as {shown.pieces[0]}")


def test_of_steps_that_failed_the_one_that_did_most_often_counts(
    dispenser_model: InteractionModel, start: dict[str, FloatArray], steps: tuple[PlanStep, ...]
) -> None:
    often, once = steps[0], steps[-1]
    assert often.chain != once.chain
    failed = [Contradiction(s, start) for s in (often, often, once)]
    for few in (failed, failed[::-1]):
        advice = helpful_demonstration(dispenser_model, few, refusal(TAKE), start)
        assert advice is not None
        assert advice.edge in often.chain
    odd = {n: np.array(s) + (n == "tank") for n, s in start.items()}
    advice = helpful_demonstration(dispenser_model, [replace(failed[0], began=odd)], None, start)
    assert advice is not None
    assert {n for n, _ in advice.region} <= {"tank", *(e.child for e in often.chain)}
