"""How far a prediction of one tick may be off, and who decides that."""

from types import SimpleNamespace
from typing import Any

import numpy as np

from ichain_drake.graph import Interaction
from ichain_drake.learning.spreads import acted_on, spread_of

POUR, HEAT = Interaction("jug", "cup"), Interaction("stove", "cup")
NOISE = np.array([0.1, 0.2, 0.3])
PASSIVE: Any = SimpleNamespace(
    variables=[
        SimpleNamespace(kind="hold", std=0.5, amount=-1),
        SimpleNamespace(kind="change", std=9.0, amount=0),
        SimpleNamespace(kind="hold", std=0.4, amount=-1),
    ]
)


def acting(**stds: float) -> Any:
    """An interaction with effects on variables, by their spreads."""
    effects = [SimpleNamespace(variable=int(k[1:]), regression=SimpleNamespace(std=v)) for k, v in stds.items()]
    return SimpleNamespace(effects=effects)


def test_the_largest_spread_of_all_that_acts_counts() -> None:
    spread, source = spread_of(PASSIVE, {}, NOISE)
    change = np.sqrt(0.5**2 - 2 * 0.1**2 + 0.2**2)
    np.testing.assert_allclose(spread, [0.5, change, 0.4])
    assert source == (None, None, None)
    spread, source = spread_of(PASSIVE, {POUR: acting(v0=0.8, v2=0.3), HEAT: acting(v0=0.6, v2=0.7)}, NOISE)
    np.testing.assert_allclose(spread, [0.8, np.sqrt(0.8**2 - 2 * 0.1**2 + 0.2**2), 0.7])
    assert source == (POUR, POUR, HEAT), "a change goes with its amount"


def test_of_an_amount_that_is_all_noise_the_change_has_its_own_alone() -> None:
    spread, _ = spread_of(PASSIVE, {}, np.array([0.5, 0.2, 0.3]))
    np.testing.assert_allclose(spread[1], 0.2)


def test_who_changes_an_amount_changes_its_change() -> None:
    learned = {POUR: acting(v0=0.1), HEAT: acting(v2=0.1)}
    assert acted_on(PASSIVE, [POUR, HEAT], learned) == {POUR: frozenset({0, 1}), HEAT: frozenset({2})}
    assert acted_on(PASSIVE, [HEAT], learned) == {HEAT: frozenset({2})}
