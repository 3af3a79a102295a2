"""Paths that are cut out of demonstrations, to choose a controller by."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ichain_drake.control.settings import TRACKING
from ichain_drake.control.tracking.path import PathLimits
from ichain_drake.control.tracking.validation import make_cases
from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.state import FloatArray, Role, StateSpace, Variable

TICKS, HALF = 20, TRACKING.smoothing // 2
LIMITS = PathLimits(speed=30.0)
CAR = StateSpace("car", (
    Variable("row"),
    Variable("x", "px", role=Role("position", "screen", "x")),
    Variable("y", "px", role=Role("position", "screen", "y")),
    Variable("heading", "rad", kind="angle", role=Role("orientation", "screen", "z")),
))  # fmt: skip


def chain(*pieces: FloatArray) -> Any:
    graph = InteractionGraph({"hand": CAR, "car": CAR}, [("hand", "car")])
    return SimpleNamespace(graph=graph, names=("hand", "car"), targets=(1, 2), validation=pieces)


def drive(rows: int, step: float = 10.0) -> FloatArray:
    """Along y, shaking a little; the first variable counts rows, the heading is nonsense."""
    t = np.arange(float(rows))
    return np.column_stack([t, (-1.0) ** t, step * t, np.full(rows, 3.0)])


def test_a_path_is_the_smoothed_drive_and_begins_in_the_middle_of_what_was_smoothed() -> None:
    cases = make_cases(chain(drive(80)), LIMITS, 5, TICKS, 0)
    assert len(cases) == 5
    rows = sorted(int(c.start[0]) - HALF for c in cases)
    assert len(set(rows)) == 5
    assert set(rows) <= set(range(0, 80 - TICKS - TRACKING.smoothing, TICKS // 4))
    for case in cases:
        assert np.abs(case.start[1]) < 0.1, "smoothed"
        assert case.start[2] == pytest.approx(10.0 * case.start[0])
        assert case.start[3] == pytest.approx(np.pi / 2, abs=0.1), "along the path, whatever was read"
        np.testing.assert_allclose(case.path.points[[0, -1], 1] - case.start[2], [0.0, 10.0 * (TICKS - 1)], atol=1e-9)
    again, other = (make_cases(chain(drive(80)), LIMITS, 5, TICKS, seed) for seed in (0, 1))
    assert [c.start[0] for c in again] == [c.start[0] for c in cases] != [c.start[0] for c in other]


def test_there_are_no_more_paths_than_the_demonstrations_have_room_for() -> None:
    needed = TICKS + TRACKING.smoothing
    assert len(make_cases(chain(drive(needed + 1), drive(needed + 1 + TICKS // 4)), LIMITS, 9, TICKS, 0)) == 3
    with pytest.raises(InputError, match=f"no demonstration of car is longer than {needed} ticks; record a longer"):
        make_cases(chain(drive(needed)), LIMITS, 9, TICKS, 0)


def test_where_it_stood_still_there_is_no_path() -> None:
    """A quarter of nominal speed is the least, 2.5 px a tick."""
    fast, slow = drive(80, step=2.8), drive(80, step=2.2)
    assert len(make_cases(chain(slow, fast), LIMITS, 99, TICKS, 0)) == len(
        make_cases(chain(fast), LIMITS, 99, TICKS, 0)
    )
    with pytest.raises(InputError, match="it hardly moves or turns too sharply for 30 a second"):
        make_cases(chain(slow), LIMITS, 99, TICKS, 0)
