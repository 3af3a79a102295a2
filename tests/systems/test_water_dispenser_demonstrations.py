"""The scripted pieces: how many, what they show, and what they must not show."""

import numpy as np
import pytest

from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.systems.water_dispenser.demonstrations import script_pieces
from ichain_drake.systems.water_dispenser.scenario import WaterDispenser
from ichain_drake.systems.water_dispenser.teleoperation import FORWARD, Teleoperation
from ichain_drake.timing import TICK

STEPS = ("pour", "heat", "place", "dispense", "retrieve")


@pytest.fixture(scope="module")
def scenario() -> WaterDispenser:
    return WaterDispenser((), "ideal", seed=0)


@pytest.fixture(scope="module")
def pieces(dispenser_pieces: list[Demonstration]) -> list[Demonstration]:
    return dispenser_pieces


def steps_of(piece: Demonstration) -> set[str]:
    """Which steps of the solution a piece shows."""
    table, on = piece.table, lambda name: piece.table[name].to_numpy() > 0.5
    cup, tank = table["cup.water"].to_numpy(), table["tank.amount"].to_numpy()
    found = set()
    if on("cup->tank").any() and tank[-1] - tank[0] > 0.1:
        found.add("pour")
    if on("power->tank").any():
        found.add("heat")
    under, held = on("tank->cup"), on("hand->cup")
    changes = np.flatnonzero(under[1:] != under[:-1])
    if any(under[k + 1] and held[k] for k in changes) and under[-1]:
        found.add("place")
    if any(under[k] and held[k] for k in changes) and not under[-1]:
        found.add("retrieve")
    if on("dispense->tank").any() or (under.any() and cup[-1] - cup[0] > 0.1):
        found.add("dispense")
    return found


def test_there_are_at_most_sixteen_of_the_right_length(pieces: list[Demonstration]) -> None:
    assert len(pieces) <= 16
    assert len({p.name for p in pieces}) == len(pieces)
    assert 270 <= TICK * sum(len(p) - 1 for p in pieces) <= 480
    assert max(len(p) for p in pieces) * TICK < 70


def test_they_pass_the_table_checks_with_all_objects_and_flags(
    scenario: WaterDispenser, pieces: list[Demonstration]
) -> None:
    for piece in pieces:
        piece.check(scenario.graph, tuple(scenario.graph.objects))
        assert all(e.name in piece.table for e in scenario.graph.interactions)
        assert not [c for c in piece.table if "spilled" in c or "past" in c]


def test_every_interaction_is_switched_on_and_off_at_least_three_times(
    scenario: WaterDispenser, pieces: list[Demonstration]
) -> None:
    for edge in scenario.graph.interactions:
        flags = [np.diff(p.table[edge.name].to_numpy()) for p in pieces]
        assert sum((f > 0).sum() for f in flags) >= 3, edge.name
        assert sum((f < 0).sum() for f in flags) >= 3, edge.name
        assert sum(p.table[edge.name].any() for p in pieces) >= 3, edge.name


def test_no_piece_holds_two_consecutive_steps_of_the_solution(pieces: list[Demonstration]) -> None:
    shown = [steps_of(p) for p in pieces]
    for piece, steps in zip(pieces, shown, strict=True):
        for first, second in zip(STEPS, STEPS[1:], strict=False):
            assert not {first, second} <= steps, f"{piece.name}: {steps}"
    assert set.union(*shown) == set(STEPS)


def test_every_effect_is_shown_in_three_pieces(pieces: list[Demonstration]) -> None:
    def count(flag: str, column: str, least: float) -> int:
        moved = 0
        for piece in pieces:
            on = piece.table[flag].to_numpy() > 0.5
            step = np.diff(piece.table[column].to_numpy(), prepend=piece.table[column].iloc[0])
            moved += np.abs(np.cumsum(on * step)).max() > least
        return moved

    for flag, column, least in (
        ("hand->cup", "cup.z", 0.02),
        ("cup->tank", "tank.amount", 0.1),
        ("cup->tank", "tank.temperature", 0.1),
        ("dispense->tank", "tank.amount", 0.1),
        ("power->tank", "tank.temperature", 0.03),
        ("tank->cup", "cup.water", 0.1),
        ("tank->cup", "cup.temperature", 0.1),
        ("hand->power", "power.level", 1.0),
        ("hand->dispense", "dispense.level", 1.0),
    ):
        assert count(flag, column, least) >= 3, f"{flag} on {column}"


def test_the_commands_can_be_followed_tick_by_tick() -> None:
    for piece in script_pieces(np.random.default_rng(5)):
        steps = np.diff(np.vstack([piece.start.hand, piece.commands]), axis=0)
        assert np.linalg.norm(steps[:, :3], axis=1).max() < 0.062
        assert np.abs(steps[:, 3:5]).max() < 0.26
        assert set(np.unique(piece.commands[:, 5])) <= {0.0, 1.0}


def test_another_seed_gives_other_pieces_and_the_same_seed_the_same() -> None:
    first, again, other = (list(script_pieces(np.random.default_rng(s))) for s in (0, 0, 1))
    for a, b, c in zip(first, again, other, strict=True):
        np.testing.assert_array_equal(a.commands, b.commands)
        assert a.start.cup != c.start.cup
    runs = {WaterDispenser((), "ideal", 0).start(r).cup for r in range(50)}
    assert not runs & {p.start.cup for p in first}


def test_nothing_is_recorded_where_every_interaction_is_known(scenario: WaterDispenser) -> None:
    names = [e.name for e in scenario.graph.interactions]
    assert not list(scenario.record_demonstrations(None, names))
    lines: list[str] = []
    assert len(next(scenario.record_demonstrations(lines.append, names[:-1]))) > 1
    assert lines[0].endswith("ticks (ideal)")


def test_a_tilt_keeps_the_rim_where_it_is() -> None:
    hand = Teleoperation((0.6, 0.0, 0.4, 0.0, FORWARD, 1.0)).tilt(-1.9)
    x, y, z, roll = hand.commands[:, :4].T
    np.testing.assert_allclose(y - 0.04 * np.sin(roll), 0.0, atol=1e-12)
    np.testing.assert_allclose(z + 0.04 * np.cos(roll), 0.44, atol=1e-12)
    np.testing.assert_allclose(x, 0.6)
