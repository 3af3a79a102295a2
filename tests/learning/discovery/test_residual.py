"""What a log says about one object: inputs of its gates, and what is left of its motion."""

import numpy as np
import pytest

from ichain_drake.learning.discovery.gate import Gate
from ichain_drake.learning.discovery.inputs import GateInput, caused, gate_inputs
from ichain_drake.learning.discovery.log import Log, RawPiece, make_log
from ichain_drake.learning.discovery.residual import Residual
from ichain_drake.learning.discovery.settings import DISCOVERY
from ichain_drake.learning.discovery.term import Term, VariableEffect
from ichain_drake.state import Role, StateSpace, Variable

PLACE = (Variable("x", role=Role("position", axis="x")), Variable("lit", kind="binary", lower=0, upper=1))
SPACES = {"hand": StateSpace("hand", PLACE), "cup": StateSpace("cup", (PLACE[0], Variable("heat", lower=0.0)))}


@pytest.fixture
def log() -> Log:
    rng = np.random.default_rng(0)
    states = [{n: rng.uniform(0.1, 1.0, (12, 2)) for n in SPACES} for _ in range(2)]
    for s in states:
        s["hand"][:, 1] = np.round(s["hand"][:, 1])
    return make_log([RawPiece(str(k), s) for k, s in enumerate(states)], SPACES, "hand", {})


def test_inputs_of_a_gate_are_later_of_the_parent_and_earlier_of_the_child(log: Log) -> None:
    found = gate_inputs(log, "hand", "cup", None)
    by = {i.label: (i, found.values[:, k]) for k, i in enumerate(found.items)}
    hand, cup, end = log.states["hand"], log.states["cup"], log.t + 1
    (label,) = (i.label for i in found.items if i.relative)
    assert by[label][0] == GateInput("hand", label, True, True, (), False, DISCOVERY.face)
    np.testing.assert_allclose(by[label][1], cup[log.back, 0] - hand[log.back, 0])
    np.testing.assert_array_equal(by["hand.lit"][1], hand[end, 1])
    np.testing.assert_array_equal(by["cup.heat"][1], cup[log.back, 1])
    assert by["hand.lit"][0] == GateInput("hand", "hand.lit", False, False, (1,), True, DISCOVERY.face)
    places = [(i.owner, i.variables, i.binary) for i in found.items if i.place and not i.relative]
    assert places == [("hand", (0,), False), ("cup", (0,), False)]
    np.testing.assert_array_equal(found.at([by["cup.heat"][0], by["hand.lit"][0]])[:, 1], hand[end, 1])
    assert len(found.items) == 5
    barred = dict(zip(by, caused(found, SPACES["cup"], "cup", "hand", [1]), strict=True))
    assert [name for name, never in barred.items() if not never] == ["hand.lit", label]
    assert not caused(found, SPACES["cup"], "cup", "cup", [1]).any()


def test_a_variable_that_goes_back_to_a_constant_has_the_noise_of_one_reading(log: Log) -> None:
    before, after = log.states["cup"][log.t], log.states["cup"][log.t + 1]
    residual = Residual(log, "cup", {0: None, 1: 0.25})
    np.testing.assert_allclose(residual.quiet, log.noise["cup"] * np.sqrt([2.0, 1.0]))
    np.testing.assert_allclose(residual.values, np.c_[after[:, 0] - before[:, 0], after[:, 1] - 0.25])
    np.testing.assert_array_equal(residual.lagged, log.states["cup"][log.back])
    np.testing.assert_allclose(residual.span, np.maximum(np.ptp(log.states["cup"], axis=0), 20 * residual.quiet))
    np.testing.assert_allclose(residual.clipped(np.array([-1.0, 1.0]), 1), [-0.25, 1.0])  # heat is from 0 on


@pytest.mark.parametrize("window", [1, 3, 4])
def test_means_stay_within_their_piece(log: Log, window: int) -> None:
    residual = Residual(log, "cup", {0: None, 1: None})
    change = residual.values[:, 1].copy()
    residual.leave((), window)
    for piece in np.unique(log.tick_piece):
        (rows,) = np.nonzero(log.tick_piece == piece)
        for i, row in enumerate(rows):
            first = max(i - window // 2, 0)
            part = change[rows][first : i - window // 2 + window]
            assert residual.values[row, 1] == pytest.approx(part.mean())
    assert np.any(residual.values[:, 0]) == (window == 1)  # a position moves at once: no means


def test_evidence_is_the_ratio_of_two_densities(log: Log) -> None:
    residual = Residual(log, "cup", {0: None, 1: None})
    left, quiet, span = residual.values[:, 1], residual.quiet[1], residual.span[1]
    change, std = np.where(np.arange(len(left)) % 2, left, 0.0), 2 * quiet

    def density(error: np.ndarray, spread: np.ndarray | float) -> np.ndarray:
        normal = np.exp(-0.5 * (error / spread) ** 2) / spread / np.sqrt(2 * np.pi)
        return (1 - DISCOVERY.outliers) * normal + DISCOVERY.outliers / span

    expected = np.log(density(left - change, np.where(change == 0, quiet, std)) / density(left, quiet))
    np.testing.assert_allclose(residual.evidence(change, 1, std), np.clip(expected, -DISCOVERY.clip, DISCOVERY.clip))
    assert residual.log_likelihood(1) == pytest.approx(np.log(density(left, quiet)).sum())


def acting(change: float, std: float, where: slice, window: int = 1) -> Term:
    """A term of the hand that adds `change` to the cup's heat in some of the 22 ticks."""
    on, predicted = np.zeros(22, dtype=bool), np.zeros((22, 2))
    on[where] = True
    predicted[:, 1] = change
    none = np.full(0, np.inf)
    effect = VariableEffect(1, False, (), np.array([change]), std)
    return Term(
        "hand", "cup", (effect,), Gate(-none, none), (), (), None, (), window, on, predicted, on * 1.0, 0.0, on * 0.0
    )


@pytest.mark.parametrize("change", [0.5, -0.5])
def test_what_terms_explain_is_taken_away_where_they_act_and_only_there_their_spread_counts(
    log: Log, change: float
) -> None:
    residual = Residual(log, "cup", {0: None, 1: None})
    first, quiet = residual.values.copy(), residual.quiet
    wide = 3.0 * float(quiet[1])
    residual.leave((acting(change, wide, slice(4, 9)), acting(change, 0.1 * wide, slice(9, 12))), 1)
    expected = first.copy()
    expected[4:12, 1] -= change
    np.testing.assert_allclose(residual.values, expected)
    np.testing.assert_allclose(residual.spread[4:9, 1], wide)
    np.testing.assert_allclose(np.delete(residual.spread[:, 1], range(4, 9)), quiet[1])  # never below the noise
    np.testing.assert_allclose(residual.spread[:, 0], quiet[0])
    residual.leave((acting(change, wide, slice(4, 9), window=6),), 1)
    np.testing.assert_allclose(residual.spread[:, 1], quiet[1])  # what it leaves of means says nothing of ticks
    residual.leave((), 1)
    np.testing.assert_array_equal(residual.values, first)


def test_what_has_no_memory_and_what_is_a_place_leave_no_means(log: Log) -> None:
    back = Residual(log, "cup", {0: None, 1: 0.25})
    back.leave((), 4)
    np.testing.assert_array_equal(back.values, 0.0)


def test_bounds_leave_of_a_change_what_is_on_the_way_to_them() -> None:
    tank = StateSpace("tank", (Variable("level", lower=0.0, upper=1.0), Variable("free")))
    level = np.array([0.5, 0.25, 0.0, 0.9, 0.5])
    states = {"tank": np.c_[level, level], "hand": np.zeros((5, 1))}
    made = make_log([RawPiece("p", states)], {"hand": StateSpace("hand", (Variable("x"),)), "tank": tank}, "hand", {})
    residual = Residual(made, "tank", {0: None, 1: None})
    residual.quiet[:] = 0.01
    np.testing.assert_allclose(residual.clipped(np.full(4, 2.0), 0), [0.5, 0.75, 1.0, 0.1])
    np.testing.assert_allclose(residual.clipped(np.full(4, -2.0), 0), [-0.5, -0.25, 0.0, -0.9])
    np.testing.assert_allclose(residual.clipped(np.full(4, 0.05), 0), 0.05)
    np.testing.assert_allclose(residual.clipped(np.full(4, -2.0), 1), -2.0)  # no bounds
    np.testing.assert_allclose(residual.clipped(np.full(2, 2.0), 0, np.array([1, 3])), [0.75, 0.1])
    residual.quiet[:] = 0.04  # .1 from a bound is within its noise: it stands there
    np.testing.assert_allclose(residual.clipped(np.full(4, 2.0), 0), [0.5, 0.75, 1.0, 0.0])


def test_an_angle_is_not_clipped_and_its_way_back_goes_the_short_way_round() -> None:
    arm = StateSpace("arm", (Variable("turn", "rad", -np.pi, np.pi, "angle"),))
    turn = np.array([3.0, -3.0, 3.1, 3.0])
    states = {"arm": turn[:, None], "hand": np.zeros((4, 1))}
    made = make_log([RawPiece("p", states)], {"hand": StateSpace("hand", (Variable("x"),)), "arm": arm}, "hand", {})
    np.testing.assert_allclose(Residual(made, "arm", {0: 3.1}).values[:, 0], [2 * np.pi - 6.1, 0.0, -0.1], atol=1e-12)
    np.testing.assert_array_equal(Residual(made, "arm", {0: None}).clipped(np.full(3, 4.0), 0), 4.0)


def test_a_temperature_says_nothing_while_its_vessel_is_all_but_empty() -> None:
    pot = StateSpace(
        "pot", (Variable("water", "ml", role=Role("amount")), Variable("heat", role=Role("intensive", of="water")))
    )
    rng = np.random.default_rng(0)
    water = np.r_[np.zeros(6), np.full(6, 500.0), np.zeros(3)]
    states = {"pot": np.c_[water, rng.uniform(10, 90, 15)], "hand": np.zeros((15, 1))}
    spaces = {"hand": StateSpace("hand", (Variable("x"),)), "pot": pot}
    made = make_log([RawPiece("p", states)], spaces, "hand", {})
    residual = Residual(made, "pot", {0: None, 1: None})
    expected = [False] * 6 + [True] * 5 + [False] * 3  # of a tick that fills or empties it neither
    assert residual.telling(1).tolist() == expected
    assert residual.telling(0).all()
    evidence = residual.evidence(residual.values[:, 1], 1, float(residual.quiet[1]))
    np.testing.assert_array_equal(evidence != 0, np.array(expected) & (np.abs(residual.values[:, 1]) > 0))
