"""What a log says about one object: inputs of its gates, and what is left of its motion."""

import numpy as np
import pytest

from ichain_drake.learning.discovery.inputs import GateInput, caused, gate_inputs
from ichain_drake.learning.discovery.log import Log, RawPiece, make_log
from ichain_drake.learning.discovery.residual import Residual
from ichain_drake.learning.discovery.settings import DISCOVERY
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
