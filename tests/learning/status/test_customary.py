"""Customary conditions: ranges as they were shown, with room at both ends."""

import numpy as np
import pytest

from ichain_drake.learning.settings import LEARNING
from ichain_drake.learning.status.customary import _shown


def test_a_range_has_room_by_its_width_or_by_noise_whichever_is_more() -> None:
    columns = np.array([[2.0, 7.0, -3.0], [4.0, 7.1, -3.0]])
    low, high = _shown(columns, np.array([0.01, 1.0, 0.0]))
    room = np.array([LEARNING.reach * 2.0, LEARNING.surely * 1.0, 0.0])
    assert low == pytest.approx(np.array([2.0, 7.0, -3.0]) - room, abs=1e-8)
    assert high == pytest.approx(np.array([4.0, 7.1, -3.0]) + room, abs=1e-8)
    assert low[2] < -3.0 < high[2], "what never changed is within it"
