"""What planning asks of a learned graph."""

import numpy as np
from toy_models import lamp, tap

from ichain_drake.control.planning.model import conserved, is_change, keeps, row, span, stack, take


def test_what_keeps_its_value_is_told_from_what_is_made_anew_in_every_tick() -> None:
    assert [keeps(tap(), n).tolist() for n in ("tap", "tank", "cup")] == [[False], [True, False], [True, True]]
    assert [is_change(tap(), n).tolist() for n in ("tap", "tank", "cup")] == [[False], [False, True], [False, False]]


def test_amounts_of_one_unit_are_conserved_together() -> None:
    assert conserved(tap()) == ((("tank", 0), ("cup", 1)),)
    assert conserved(lamp()) == ()


def test_a_range_is_as_wide_as_was_shown_and_never_empty() -> None:
    model = tap()
    np.testing.assert_allclose(span(model, "tank"), [0.8, 0.04])
    assert span(model, "cup")[1] > 0.0  # all samples hold as much


def test_rows_are_stacked_taken_and_told_apart() -> None:
    batch = stack([{"a": np.array([1.0, 2.0])}, {"a": np.array([3.0, 4.0])}, {"a": np.array([5, 6])}])
    np.testing.assert_array_equal(batch["a"], [[1, 2], [3, 4], [5, 6]])
    np.testing.assert_array_equal(take(batch, [2, 0])["a"], [[5, 6], [1, 2]])
    one = row(batch, 1)
    one["a"][0] = 9.0
    np.testing.assert_array_equal(batch["a"][1], [3.0, 4.0])
