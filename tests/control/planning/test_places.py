"""Places that something may be brought to: the same one is not tried twice."""

import numpy as np

from ichain_drake.control.planning.places import _distinct
from ichain_drake.control.settings import PLANNING


def test_places_that_are_as_good_as_the_same_are_one_and_where_it_is_now_is_none() -> None:
    width, here = np.array([2.0, 0.5]), np.array([1.0, 1.0])
    same = PLANNING.same * width
    far = here + [1.0, 0.0]
    found = [here + 0.9 * same, far, far + 0.9 * same, far + [0.0, 1.1 * same[1]], far - [1.1 * same[0], 0.0]]
    kept = _distinct(found, here, width)
    np.testing.assert_allclose(kept, [found[1], found[3], found[4]])
