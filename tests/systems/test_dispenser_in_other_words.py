"""Names, order and the camera's turn are no knowledge: another choice of them gives the same plan and success."""

import numpy as np
import pytest
from other_words import OtherWords, drive

from ichain_drake.control.execution.tasks import Mode
from ichain_drake.control.planning.plan import Plan
from ichain_drake.demonstrations import Demonstration
from ichain_drake.learning import InteractionModel, InteractionSpec
from ichain_drake.objects import CameraFrame
from ichain_drake.runs.goals.run import GraphRun, run_graph
from ichain_drake.runs.learn import learn
from ichain_drake.systems.water_dispenser.scenario import WaterDispenser

GOAL = ["cup.temperature >= 0.4", "cup.water >= 0.3", "keep cup.y within 0.02", "not hand->cup"]


@pytest.fixture(scope="module")
def plain(dispenser_model: InteractionModel) -> GraphRun:
    run = GraphRun(WaterDispenser((), "ideal"), tuple(GOAL))
    run_graph(run, known=dispenser_model)
    assert run.goal_reached, run.reason
    return run


def test_in_random_words_and_another_order_it_has_the_same_plan_and_success(
    plain: GraphRun, dispenser_pieces: list[Demonstration], quick_spec: InteractionSpec
) -> None:
    scenario = WaterDispenser((), "ideal")
    words = OtherWords(scenario.graph, 11)
    assert list(words.order["cup"]) != list(range(7))
    pieces = words.pieces(dispenser_pieces)
    assert [p.name for p in pieces] != [str(k) for k in range(len(pieces))]
    memory = drive(scenario, words, learn(words.graph, pieces, spec=quick_spec), GOAL)
    assert memory.mode == Mode.REACHED, memory.reason
    assert memory.reason == "goal reached"
    assert isinstance(plain.plan, Plan)
    assert [[e.name for e in step.chain] for step in memory.plans[0].steps] == words.plan(plain.plan)
    # The same numbers, but for the last bits of sums in another order.
    assert plain.memory is not None
    assert abs(memory.tick - plain.memory.tick) <= 20
    for new, old in zip(memory.plans[0].steps, plain.plan.steps, strict=True):
        for name, state in words.states(dict(old.predicted)).items():
            np.testing.assert_allclose(new.predicted[name], state, atol=0.02)


def seen_from(pieces: list[Demonstration], old: CameraFrame, new: CameraFrame) -> list[Demonstration]:
    """The same pieces as another camera sees them."""
    out = []
    for piece in pieces:
        table, place = piece.table.copy(), [f"cup.{a}" for a in "xyz"]
        table[place] = new.from_robot(old.to_robot(table[place].to_numpy()))
        out.append(Demonstration(table, piece.units, piece.name))
    return out


def test_with_the_camera_turned_by_40_degrees_it_succeeds_all_the_same(
    plain: GraphRun, dispenser_pieces: list[Demonstration], quick_spec: InteractionSpec
) -> None:
    before, scenario = WaterDispenser((), "ideal"), WaterDispenser(("camera.yaw_deg=40",), "ideal")
    assert scenario.camera().yaw != before.camera().yaw
    pieces = seen_from(dispenser_pieces, before.camera(), scenario.camera())
    run = GraphRun(scenario, tuple(GOAL))
    run_graph(run, known=learn(scenario.graph, pieces, spec=quick_spec))
    assert run.goal_reached, run.reason
    assert isinstance(run.plan, Plan)
    assert isinstance(plain.plan, Plan)
    assert [s.chain for s in run.plan.steps] == [s.chain for s in plain.plan.steps]
