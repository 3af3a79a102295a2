"""What a gated effect costs, and how it reads."""

import numpy as np
import pytest

from ichain_drake.learning.discovery.gate import Gate
from ichain_drake.learning.discovery.inputs import GateInput
from ichain_drake.learning.discovery.settings import DISCOVERY
from ichain_drake.learning.discovery.term import Curve, Term, VariableEffect

LINE = VariableEffect(0, False, (0, 2), np.array([0.5, 2.0, -1.0]), 0.1)
DECLARED = VariableEffect(1, True, (1,), np.array([0.0, 1.0]), 0.1)
CONSTANT = VariableEffect(1, False, (), np.array([0.25]), 0.1)


def term(*effects: VariableEffect, parent: str = "hand", low: float = -np.inf, high: float = np.inf) -> Term:
    """With faces on an input of the hand, and none on one of the lid unless its first has one."""
    items = tuple(GateInput(o, f"{o}.x", False, False, (0,), False, 4.0) for o in ("hand", "lid"))
    none = np.zeros(3)
    gate = Gate(np.array([low, -np.inf]), np.array([np.inf, high]))
    return Term(
        parent, "cup", effects, gate, items, ("a", "b", "c"), None, (), 1, none > 0, none, none, 1.0,
        np.array([2.0, -0.5, 1.0]),
    )  # fmt: skip


def test_an_effect_is_a_constant_and_a_share_of_its_columns() -> None:
    columns = np.array([[1.0, 10.0, 100.0], [2.0, 20.0, 200.0]])
    np.testing.assert_allclose(LINE.predict(columns), [0.5 + 2.0 - 100.0, 0.5 + 4.0 - 200.0])
    np.testing.assert_allclose(DECLARED.predict(columns), [10.0, 20.0])
    np.testing.assert_allclose(CONSTANT.predict(columns), 0.25)


def test_a_curve_is_a_polynomial_in_its_columns_brought_to_their_middle_and_spread() -> None:
    columns = np.random.default_rng(0).normal([1.0, 10.0, 100.0], [0.5, 3.0, 9.0], (40, 3))
    a, c = ((columns[:, k] - columns[:, k].mean()) / columns[:, k].std() for k in (0, 2))
    curve = Curve.over(columns[:, [0, 2]], 2)
    effect = VariableEffect(0, False, (0, 2), np.array([0.5, 1.0, 2.0, 3.0, 4.0, 5.0]), 0.1, curve)
    np.testing.assert_allclose(effect.predict(columns), 0.5 + a + 2 * c + 3 * a * a + 4 * a * c + 5 * c * c)
    assert effect.price() == LINE.price() + 3 * DISCOVERY.constant, "three monomials more than a line"


def test_effects_cost_by_their_columns_unless_roles_declare_them() -> None:
    assert DECLARED.price() == DISCOVERY.declared
    assert CONSTANT.price() == DISCOVERY.constant
    assert LINE.price() == DISCOVERY.constant + 2 * DISCOVERY.slope


def test_a_term_costs_its_faces_its_effects_and_each_object_beside_the_child() -> None:
    effects = LINE.price() + DECLARED.price()
    assert term(LINE, DECLARED).price() == pytest.approx(effects + DISCOVERY.other_object)
    both = term(LINE, DECLARED, low=0.0, high=1.0)
    assert both.objects == {"hand", "lid"}
    assert both.price() == pytest.approx(2 * DISCOVERY.face + effects + 2 * DISCOVERY.other_object)
    alone = term(CONSTANT, parent="cup")
    assert alone.objects == {"cup"}
    assert alone.price() == pytest.approx(DISCOVERY.constant)
    assert alone.gain == 2.5


def test_it_reads_as_a_sentence() -> None:
    names = ("level", "heat")
    assert term(LINE, DECLARED).text(names) == "hand changes cup: level by a+c, heat by b, while always"
    faced = term(CONSTANT, low=0.5, high=2.0).text(names)
    assert faced == "hand changes cup: heat by 0.25, while 0.5 < hand.x < inf and -inf < lid.x < 2"
