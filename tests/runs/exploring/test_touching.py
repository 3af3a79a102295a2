"""A hand that tries out objects by itself, in the world of a stove."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ichain_drake.demonstrations import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.learning.discovery.experiments import Experiment
from ichain_drake.runs.exploring.settings import EXPLORING
from ichain_drake.runs.exploring.touching import Reach, Toucher
from ichain_drake.scenarios import build_world
from ichain_drake.simulation.recorder import record
from ichain_drake.simulation.wiring import start_command
from ichain_drake.state import StateSpace, Variable
from ichain_drake.systems import load_scenario

STOVE = str(Path(__file__).parents[2] / "helpers" / "stove.py")
SEED = 41000


def tried(*touched: str, ticks: int = 90, **settings: float) -> Demonstration:
    """A piece with true flags."""
    scenario = load_scenario(STOVE, (), "ideal", SEED)
    world, reach = build_world(scenario, run=900), Reach(scenario.graph)
    chosen = replace(EXPLORING, **settings)  # type: ignore[arg-type]
    toucher = Toucher(reach, Experiment(touched), start_command(world), [SEED, 0], chosen)
    return record(world, toucher, ticks, tuple(reach.spaces), "tried")


@pytest.fixture(scope="module")
def dial() -> Demonstration:
    """The dial, touched over and over."""
    return tried("dial")


def test_it_looks_before_it_touches(dial: Demonstration) -> None:
    hand = dial.table[["command.x", "command.y", "command.grip"]].to_numpy()[: EXPLORING.rest]
    assert (hand == hand[0]).all()


def test_what_it_touches_goes_along_and_is_mostly_put_back(dial: Demonstration) -> None:
    x, held = dial.table["dial.x"].to_numpy(), dial.table["hand->dial"].to_numpy() > 0.5
    assert held.any()
    assert not held.all()
    assert np.ptp(x) > 0.08  # of the .2 that are declared
    let_go = np.flatnonzero(held[:-1] & ~held[1:]) + 1
    back = np.abs(x[let_go] - x[0]) < 0.01
    assert back.any()
    assert back.mean() >= 0.5


def test_it_also_closes_beside_it(dial: Demonstration) -> None:
    grip = dial.table["hand.grip"].to_numpy() > 0.5
    closes = np.flatnonzero(~grip[:-1] & grip[1:]) + 1
    assert (dial.table["hand->dial"].to_numpy()[closes] < 0.5).any()


def test_of_two_each_is_left_while_the_other_is_touched() -> None:
    both = tried("dial", "lamp").table
    lamp, on = both["hand->lamp"].to_numpy() > 0.5, both["dial->pot"].to_numpy() > 0.5
    assert (lamp & on).any()  # the lamp is kept dark while the pot is heated


def test_it_stays_within_what_is_there_and_a_margin(dial: Demonstration) -> None:
    x, y = (dial.table[f"command.{a}"].to_numpy() for a in "xy")
    scenario = load_scenario(STOVE, (), "ideal", SEED)
    home = scenario.config.robot.home_hand()
    for values, ends, start in ((x, (0.40, 0.60), home[0]), (y, (-0.11, 0.11), home[1])):
        assert values.min() >= min(*ends, start) - EXPLORING.margin - 2e-3
        assert values.max() <= max(*ends, start) + EXPLORING.margin + 2e-3


def test_it_is_a_function_of_the_seed() -> None:
    a, b = (tried("dial", ticks=40).table for _ in range(2))
    assert a.equals(b)


def test_a_hand_that_touches_nothing_moves_freely() -> None:
    piece = tried(ticks=60).table
    assert np.ptp(piece["hand.x"]) > 0.05
    assert np.ptp(piece["dial.x"]) < 0.01


def test_what_is_declared_nowhere_can_not_be_touched() -> None:
    reach = Reach(load_scenario(STOVE, (), "ideal", SEED).graph)
    assert reach.touchable == ("dial", "lamp")
    assert reach.declared("dial", "x") == (0.40, 0.60)
    assert reach.declared("pot", "x") == (-np.inf, np.inf)


def test_a_robot_that_is_no_hand_is_refused() -> None:
    spaces = {"crane": StateSpace("crane", (Variable("boom"),)), "load": StateSpace("load", (Variable("height"),))}
    with pytest.raises(InputError, match="crane is no hand"):
        Reach(InteractionGraph(spaces, ["crane->load"]))


def test_two_robots_are_refused() -> None:
    with pytest.raises(InputError, match="exploring"):
        Reach(load_scenario("lidded_pot", (), "ideal", SEED).graph)
