"""A piece says what it shows: just what it does show, so that nobody records what is known."""

from collections.abc import Callable, Sequence

import numpy as np
import pytest
from kettle_pieces import kettle, kettle_pieces
from oven_pieces import oven, oven_pieces

from ichain_drake.demonstrations import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.scenarios.graph_scenario import GraphScenario
from ichain_drake.scenarios.scripted_piece import ScriptedPiece
from ichain_drake.systems.two_dispensers.scenario import TwoDispensers
from ichain_drake.systems.water_dispenser.scenario import WaterDispenser


def scripted(scenario: GraphScenario) -> dict[str, ScriptedPiece]:
    """The script's pieces before they are recorded, by name."""
    return {p.name: p for p in scenario.script(np.random.default_rng([scenario.seed, scenario.script_purpose]))}


def check(scenario: GraphScenario, recorded: Sequence[Demonstration]) -> None:
    found = scripted(scenario)
    assert [p.name for p in recorded] == list(found)
    for piece in recorded:
        on = {e.name for e in scenario.graph.interactions if (piece.table[e.name] > 0.5).any()}
        assert set(found[piece.name].shows) == on, piece.name


def test_the_dispenser_s_pieces_show_what_they_say(dispenser_pieces: list[Demonstration]) -> None:
    check(WaterDispenser((), "ideal"), dispenser_pieces)


@pytest.mark.parametrize(("scenario", "pieces"), [(kettle, kettle_pieces), (oven, oven_pieces)])
def test_so_do_those_of_others(scenario: Callable, pieces: Callable) -> None:
    check(scenario(), pieces())


def test_those_of_two_machines_are_each_about_one() -> None:
    for piece in scripted(TwoDispensers((), "ideal")).values():
        machine = piece.name.partition("_")[0]
        others = [name for name in piece.shows if name != "hand->cup"]
        assert all(machine in name for name in others)


def test_what_shows_known_interactions_alone_is_left_out() -> None:
    scenario = WaterDispenser((), "ideal")
    known = [e.name for e in scenario.graph.interactions if e.name != "power->tank"]
    assert [p.name for p in scenario.record_demonstrations(None, known)] == ["heat_edges", "heat_long", "heat_levels"]


def test_a_piece_that_says_nothing_is_always_needed() -> None:
    commands = np.zeros((2, 6))
    assert ScriptedPiece("still", None, commands).is_needed(["hand->cup"])
    assert not ScriptedPiece("still", None, commands, ("hand->cup",)).is_needed(["hand->cup", "cup->tank"])
    assert ScriptedPiece("still", None, commands, ("hand->cup", "tank->cup")).is_needed(["hand->cup"])


def test_what_is_no_interaction_can_not_be_shown() -> None:
    piece = ScriptedPiece("still", None, np.zeros((2, 6)), ("hand->jug",))
    with pytest.raises(
        InputError, match="piece still: it is to show hand->jug, which is no interaction; there are hand->cup"
    ):
        piece.check(WaterDispenser((), "ideal").graph)
