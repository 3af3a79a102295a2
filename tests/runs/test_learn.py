"""Learning, saving, loading and running, the same calls for a chain that follows paths and for a graph with a goal."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from lamp import LampScenario, Slider

import ichain_drake as ic
from ichain_drake.learning import KnownParts
from ichain_drake.scenarios import PathScenario
from ichain_drake.scenarios.config import LearningConfig

GOAL = ("0.55 <= lamp.light <= 0.65", "not hand->dimmer", "not hand->switch")


@pytest.fixture(scope="module")
def game() -> PathScenario:
    scenario = ic.load_scenario("car_game", ["learning.samples=120"], physics="ideal")
    assert isinstance(scenario, PathScenario)
    return scenario


@pytest.fixture(scope="module")
def car(game: PathScenario) -> ic.InteractionModel:
    return ic.learn(game, game.record_demonstrations())


@pytest.fixture(scope="module")
def lamp() -> ic.InteractionModel:
    return ic.learn(LampScenario(), LampScenario().record_demonstrations())


def test_a_graph_with_a_target_is_learned_as_its_scenario_is(game: PathScenario, car: ic.InteractionModel) -> None:
    pieces = list(game.record_demonstrations())
    spec = game.config.learning.candidates()
    alone = ic.learn(game.graph, pieces, target="car", spec=spec)
    assert alone.chain is not None
    assert car.chain is not None
    states = {n: np.tile(s.observable.lower.clip(-1, 1) * 0, (3, 1)) for n, s in game.graph.objects.items()}
    for name, ahead in alone.step(states, states["hand"] + 0.01)[0].items():
        np.testing.assert_array_equal(ahead, car.step(states, states["hand"] + 0.01)[0][name])
    assert [link.robot_seconds for link in alone.chain.links] == [pytest.approx(121 * ic.TICK), 0.0]
    assert alone.demonstrations_sha256 == car.demonstrations_sha256 != ""


def test_what_is_known_whole_is_not_learned_again(game: PathScenario, car: ic.InteractionModel) -> None:
    assert ic.learn(game, [], known=car) is car


def test_a_chain_comes_back_from_a_library_link_by_link(
    game: PathScenario, car: ic.InteractionModel, tmp_path: Path
) -> None:
    folders = ic.save(car, tmp_path / "library", game.name)
    assert [f.name for f in folders] == ["hand-joystick", "joystick-car"]
    known = ic.load(tmp_path / "library", game)
    assert isinstance(known, KnownParts)
    assert known.names == ("hand->joystick", "joystick->car")
    drive = list(game.record_demonstrations(known=known.names))
    assert [p.name for p in drive] == ["drive"]  # paths to validate the controller on are cut out of it
    again = ic.learn(game, drive, known=known)
    assert again.chain is not None
    assert {link.source for link in again.chain.links} == {str(tmp_path / "library")}
    less = known.without({game.graph.interactions[0]: "the stick was turned"})
    assert (less.names, less.command) == (("joystick->car",), None)
    assert known.without({game.graph.interactions[1]: "another car"}).command is known.command is not None


def test_a_graph_comes_back_from_a_library_whole(lamp: ic.InteractionModel, tmp_path: Path) -> None:
    assert [f.name for f in ic.save(lamp, tmp_path / "library", "lamp")] == ["graph.lamp"]
    again = ic.load(tmp_path / "library", LampScenario())
    assert isinstance(again, ic.InteractionModel)
    assert again.report() == lamp.report()
    assert again.source_of(LampScenario.graph.interactions[0]) == str(tmp_path / "library")
    assert again.robot_seconds == lamp.robot_seconds > 0
    assert {e: len(w) for e, w in again.activations.items()} == {e: len(w) for e, w in lamp.activations.items()}


def test_a_library_lifts_only_where_that_is_said(lamp: ic.InteractionModel, tmp_path: Path) -> None:
    ic.save(lamp, tmp_path / "library", "lamp")
    more = [*LampScenario.graph.interactions, "hand->other"]
    two = SimpleNamespace(
        name="lamps", graph=ic.InteractionGraph(LampScenario.spaces | {"other": Slider.state_space}, more)
    )
    counted = []
    for said in ({}, {"lift": True}):
        known = ic.load(tmp_path / "library", two, **said)
        assert isinstance(known, KnownParts)
        counted.append("hand->other" in known.names)
    assert counted == [False, True]


def test_the_estimator_that_a_scenario_asks_for_is_the_only_one(lamp: ic.InteractionModel) -> None:
    scenario = LampScenario()
    scenario.config = ic.ScenarioConfig(learning=LearningConfig(estimator="KernelRidge(kernel='rbf', alpha=0.01)"))
    pieces = list(scenario.record_demonstrations())
    asked, usual = (
        {e.regression.estimator for learned in m.edges.values() for e in learned.effects} - {"as declared"}
        for m in (ic.learn(scenario, pieces), lamp)
    )
    assert asked == {"KernelRidge(kernel='rbf', alpha=0.01)"}
    assert asked.isdisjoint(usual)


def test_one_call_does_a_goal_or_a_path(
    game: PathScenario, car: ic.InteractionModel, lamp: ic.InteractionModel
) -> None:
    reached = ic.run(LampScenario(), GOAL, known=lamp, number=1)
    assert reached.goal_reached, reached.reason
    followed = ic.run(game, "eight", known=car)
    assert followed.goal_reached, followed.reason
    assert list(followed.report()["metrics"]["paths"]) == ["eight"]
    with pytest.raises(ic.InputError, match="car_game has no path 'circle'"):
        ic.run(game, "circle")
    with pytest.raises(ic.InputError, match="the model was learned for goals; for a path, give `learn` a target"):
        ic.run(game, "eight", known=lamp)
    with pytest.raises(ic.InputError, match="the model was learned for following paths; for a goal, give `learn` no t"):
        ic.run(LampScenario(), GOAL, known=car)
