"""What a search begins with: ticks that are perturbed, and the sides of an input on which they are."""

import numpy as np
import pytest

from ichain_drake.learning.discovery.inputs import gate_inputs
from ichain_drake.learning.discovery.log import Log, RawPiece, make_log
from ichain_drake.learning.discovery.passive_kind import constant_values
from ichain_drake.learning.discovery.residual import Residual
from ichain_drake.learning.discovery.starts import starts
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import StateSpace, Variable

HAND, TANK = StateSpace("hand", (Variable("x", "m"),)), StateSpace("tank", (Variable("level", lower=0.0, upper=9.0),))
NOISE = 1e-3
ROWS = 240


def log(act: float, side: int, *, spring: bool = False) -> tuple[Log, np.ndarray]:
    """A hand that goes about; beyond .6 (or below -.6) it fills the tank by `act` a tick; a spring forgets that."""
    rng = np.random.default_rng(0)
    x = np.repeat(rng.uniform(-1.0, 1.0, ROWS // 6), 6)
    on = side * x > 0.6
    level = np.where(on, 1.0 + act, 1.0) if spring else 1.0 + np.r_[0.0, np.cumsum(act * on[1:])]
    states = {"hand": x[:, None] + NOISE * rng.normal(size=(ROWS, 1)), "tank": level[:, None]}
    states["tank"] = states["tank"] + NOISE * rng.normal(size=(ROWS, 1))
    made = make_log([RawPiece("p", states)], {"hand": HAND, "tank": TANK}, "hand", {})
    return made, on[made.t + 1]


def begun(made: Log) -> list[np.ndarray]:
    residual = Residual(made, "tank", {0: None})
    inputs = gate_inputs(made, "hand", "tank", None)
    return starts(residual, inputs, np.ones(len(made.t), dtype=bool))


def test_on_either_side_of_an_input_the_search_begins_where_it_acts() -> None:
    for side in (1, -1):
        made, on = log(0.02, side)
        sets = begun(made)
        assert np.mean(sets[0] == on) > 0.95, "what is perturbed comes first"
        assert max(np.mean(rows == on) for rows in sets[1:]) > 0.95


def test_an_effect_that_drowns_in_a_ticks_noise_is_begun_by_its_side_alone() -> None:
    made, on = log(0.0025, 1)
    found = [np.mean(rows == on) for rows in begun(made)]
    assert max(found) > 0.9


def test_where_nothing_acts_nothing_is_begun() -> None:
    made, _ = log(0.0, 1)
    assert begun(made) == []


def test_only_ticks_that_may_be_used_are() -> None:
    made, on = log(0.02, 1)
    train = np.arange(len(made.t)) % 2 == 0
    residual = Residual(made, "tank", {0: None})
    for rows in starts(residual, gate_inputs(made, "hand", "tank", None), train):
        assert not (rows & ~train).any()
        assert (rows & on).any()


def test_what_goes_back_at_once_has_its_rest_value_and_what_stays_has_none() -> None:
    spring, _ = log(0.5, 1, spring=True)
    back = constant_values(spring, "tank", ["hand"])[0]
    assert back is not None
    assert abs(back - 1.0) < 3 * NOISE
    filled, _ = log(0.02, 1)
    assert constant_values(filled, "tank", ["hand"]) == {0: None}


@pytest.mark.parametrize(("ticks", "begun_there"), [(LEARNING.rows, True), (LEARNING.rows - 1, False)])
def test_so_few_ticks_are_enough_to_begin_with(ticks: int, begun_there: bool) -> None:
    """Of a tank that nothing else happens to, jolts in ticks that no side of an input has in common."""
    rng = np.random.default_rng(4)
    at = rng.choice(np.arange(5, ROWS - 5), ticks, replace=False)
    level = np.full(ROWS, 3.0)
    for k, row in enumerate(at):
        level[row:] += 0.5 * (-1) ** k
    states = {"hand": rng.uniform(-1, 1, (ROWS, 1)), "tank": level[:, None] + NOISE * rng.normal(size=(ROWS, 1))}
    made = make_log([RawPiece("p", states)], {"hand": HAND, "tank": TANK}, "hand", {})
    jolted = np.isin(made.t + 1, at)
    assert any(np.array_equal(rows, jolted) for rows in begun(made)) == begun_there
