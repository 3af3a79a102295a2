"""Worlds with latches, tools and obstacles that nobody declared: learned on one bell, for two, around a post."""

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("gymnasium", reason="Gymnasium is missing: pip install 'ichain_drake[games]'")

from latch_environment import FAR, POST, BellScenario, TwoBells

import ichain_drake as ic
from ichain_drake.control.planning.planner import GraphPlanner
from ichain_drake.learning import KnownParts

RUNG = ("bell0.rung >= 0.5",)


@pytest.fixture(scope="module")
def model() -> ic.InteractionModel:
    scenario = BellScenario(seed=0)
    return ic.learn(scenario.graph, list(scenario.record_demonstrations()))


def test_what_is_done_at_first_touch_is_an_effect_of_either_and_a_drive(model: ic.InteractionModel) -> None:
    effects = {e.name: [f.variable for f in learned.effects] for e, learned in model.edges.items()}
    assert effects == {"claw->pole": [0, 1], "claw->bell0": [2], "pole->bell0": [2]}
    drives = {tuple(e.name for e in d.chain) for d in GraphPlanner(model).options.drives}
    assert drives == {("claw->bell0",), ("claw->pole", "pole->bell0")}


@pytest.mark.parametrize("seed", [12, 16, 18, 22])
def test_a_bell_is_rung_past_a_post_by_the_claw_or_by_the_pole_where_that_is_too_far(
    model: ic.InteractionModel, seed: int
) -> None:
    scenario = BellScenario(seed=seed)
    run = ic.GraphRun(scenario, RUNG)
    ic.run_graph(run, known=model)
    assert run.goal_reached, run.reason
    assert run.memory is not None
    assert run.memory.replans == 0
    assert run.memory.blocked is not None  # the straight way leads into it
    assert run.log is not None
    place = run.log.states["claw"][:, :2]
    assert not ((place > POST[0]) & (place < POST[1])).all(axis=1).any()
    too_far = scenario.start_states(scenario.start(0))["bell0"][1] > FAR
    assert (run.memory.plans[0].steps[0].chain[0].name == "claw->pole") == too_far


def test_what_was_learned_on_one_holds_for_all_of_its_type_if_that_is_said(
    model: ic.InteractionModel, tmp_path: Path
) -> None:
    ic.save(model, tmp_path, BellScenario.name)
    scenario = TwoBells(seed=31)
    guessed = ic.load(tmp_path, scenario)
    assert isinstance(guessed, KnownParts)
    assert set(guessed.names) == {"claw->pole", "claw->bell0", "pole->bell0"}
    lifted = ic.load(tmp_path, scenario, lift=True)
    assert isinstance(lifted, KnownParts)
    assert lifted.is_whole(scenario.graph)
    run = ic.GraphRun(scenario, (*RUNG, "bell1.rung >= 0.5"))
    ic.run_graph(run, known=lifted)
    assert run.goal_reached, run.reason
    assert not run.pieces
    assert run.log is not None
    assert np.array([run.log.states[n][-1, 2] for n in ("bell0", "bell1")]).all()
