"""The best box is found, at the price that its faces and the objects that it looks at have."""

import numpy as np
import pytest

from ichain_drake.learning.discovery.gate import Gate, GateSearch
from ichain_drake.learning.discovery.inputs import GateInput, GateInputs


def inputs(values: np.ndarray, owners: str, prices: tuple[float, ...]) -> GateInputs:
    items = [
        GateInput(o, str(k), False, False, (0,), False, p) for k, (o, p) in enumerate(zip(owners, prices, strict=True))
    ]
    return GateInputs(tuple(items), values)


def searched(values: np.ndarray, owners: str, prices: tuple[float, ...], evidence: np.ndarray) -> tuple[Gate, float]:
    return GateSearch(inputs(values, owners, prices), "a", 3.0)(evidence, np.ones(len(owners), dtype=bool))


@pytest.mark.parametrize(
    ("owners", "price"),
    [("ab", 1 + 1 + 2 + 3), ("aa", 1 + 1 + 2), ("bb", 1 + 1 + 2 + 3), ("bc", 1 + 1 + 2 + 6)],
)
def test_faces_cost_their_price_and_each_object_that_is_not_free_once(owners: str, price: float) -> None:
    grid = np.random.default_rng(0).permutation(np.argwhere(np.ones((6, 6))).astype(float))
    inside = (grid[:, 0] >= 2) & (grid[:, 0] <= 3) & (grid[:, 1] >= 2)
    gate, value = searched(grid, owners, (1.0, 2.0), np.where(inside, 5.0, -5.0))
    assert value == pytest.approx(5.0 * inside.sum() - price)
    np.testing.assert_array_equal(gate.holds(grid), inside)
    np.testing.assert_allclose([gate.low, gate.high], [[1.7, 1.5], [3.3, np.inf]])  # not far into a narrow one's gap
    assert (gate.faces, gate.used.tolist()) == (3, [True, True])


@pytest.mark.parametrize("seed", range(6))
def test_on_one_input_it_is_the_best_of_all_intervals(seed: int) -> None:
    rng = np.random.default_rng(seed)
    x, evidence = rng.integers(0, 12, 40).astype(float), 4.0 * rng.standard_normal(40)
    every = [
        evidence[(x >= a) & (x <= b)].sum() - 1.5 * np.isfinite([a, b]).sum()
        for a in (-np.inf, *range(12))
        for b in (np.inf, *range(12))
    ]
    gate, value = searched(x[:, None], "a", (1.5,), evidence)
    assert value == pytest.approx(max(every))
    assert evidence[gate.holds(x[:, None])].sum() - 1.5 * gate.faces == pytest.approx(value)


def test_without_evidence_for_it_it_stays_open_and_what_must_not_be_used_gets_no_face() -> None:
    x = np.array([[0.0, 3.0], [1.0, 0.0], [2.0, 1.0], [3.0, 2.0]])
    gate, value = searched(x, "aa", (1.0, 1.0), np.array([-1.0, 0.0, 0.0, -2.0]))
    assert (gate.faces, value) == (0, -3.0)
    search = GateSearch(inputs(x, "aa", (1.0, 1.0)), "a", 3.0)
    gate, value = search(np.array([9.0, -9, -9, -9]), np.array([False, True]))
    assert (gate.used.tolist(), value) == ([False, True], 8.0)


def test_where_no_input_may_be_used_it_stays_open_whatever_speaks_for_it() -> None:
    gate, value = GateSearch(inputs(np.arange(4.0)[:, None], "a", (1.0,)), "a", 3.0)(
        np.ones(4), np.zeros(1, dtype=bool)
    )
    assert (gate.faces, value) == (0, 4.0)


def faces_of(evidence: list[float], values: list[float]) -> tuple[float, float]:
    gate, _ = searched(np.array(values)[:, None], "a", (1.0,), np.array(evidence))
    return float(gate.low[0]), float(gate.high[0])


def test_a_face_lies_between_the_rows_that_speak_nearest_on_either_side() -> None:
    """Rows that say little may lie on either side; those further away don't count."""
    values = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 30.0]
    low, high = faces_of([-9, -9, -9, 0.1, 5, 5, 5, 5, 0.1, -9, -9, -9], values)
    assert (low, high) == (3.1, 7.9), "of a narrow region not further than a share of its width"
    low, high = faces_of([-9, -9, -9, 5, 5, 5, 5, 5, 5, -9, -9, -9], values)
    assert (low, high) == (2.5, 8.5)
    assert faces_of([-9, -9, -9, 5, 5, 5, 5, 5, 5, 5, 5, 5], values) == (2.5, np.inf)
    assert faces_of([5, 5, 5, 5, 5, 5, 5, 5, 5, -9, -9, -9], values) == (-np.inf, 8.5)


def test_a_lone_row_that_speaks_gets_the_middle_of_its_gaps() -> None:
    assert faces_of([-9, -9, 9, -9, -9], [0.0, 1.0, 3.0, 7.0, 20.0]) == (2.0, 5.0)


def test_a_row_on_a_face_is_inside() -> None:
    gate = Gate(np.array([0.0, -np.inf]), np.array([1.0, np.inf]))
    rows = np.array([[0.0, 5.0], [1.0, -5.0], [-0.1, 0.0], [1.1, 0.0]])
    assert gate.holds(rows).tolist() == [True, True, False, False]
    assert (gate.used.tolist(), gate.faces) == ([True, False], 2)
