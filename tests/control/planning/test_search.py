"""What a search takes for a step."""

from types import SimpleNamespace

import numpy as np
import pytest

from ichain_drake.control.planning.search import Search


@pytest.mark.parametrize(
    ("direction", "end", "shows"),
    [(1, 0.35, True), (1, 0.31, False), (1, 0.2, False), (-1, 0.35, False), (-1, 0.2, True)],
)
def test_a_variable_that_is_not_seen_to_go_the_way_it_is_driven_is_not_driven(
    direction: int, end: float, *, shows: bool
) -> None:
    """Three noises make a difference, of 0.3 at first."""
    search = SimpleNamespace(model=SimpleNamespace(noise={"tank": np.array([0.01])}))
    node = SimpleNamespace(states={"tank": np.array([0.3])})
    drive = SimpleNamespace(chain=[SimpleNamespace(child="tank")], variable=0, direction=direction)
    assert Search._shows(search, node, drive, end) is shows  # type: ignore[arg-type]
