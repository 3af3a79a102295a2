"""Regions: what is in, and what goes out only beyond a margin."""

import math

import numpy as np
import pytest

from ichain_drake.objects.placement import Placement
from ichain_drake.objects.region import Region

BOX = Region((1.0, 0.0, 0.0), (0.1, 0.2, 0.3), margin=0.01)
ROUND = Region((1.0, 0.0, 0.0), (0.1, 0.2, 0.3), margin=0.01, round=True)


@pytest.mark.parametrize("region", [BOX, ROUND])
def test_its_middle_and_its_axes_are_in_up_to_the_faces(region: Region) -> None:
    for point in ((1.0, 0.0, 0.0), (1.099, 0.0, 0.0), (1.0, -0.199, 0.0), (1.0, 0.0, 0.299)):
        assert region.holds(point)
    for point in ((1.101, 0.0, 0.0), (1.0, 0.201, 0.0), (1.0, 0.0, -0.301)):
        assert not region.holds(point)
        assert region.holds(point, inside=True)
    assert not region.holds((1.111, 0.0, 0.0), inside=True)


def test_a_round_one_has_no_corners() -> None:
    corner = (1.09, 0.18, 0.29)
    assert BOX.holds(corner)
    assert not ROUND.holds(corner)
    assert ROUND.holds((1.06, 0.12, 0.29))


def test_a_region_is_moved_and_turned_with_its_machine() -> None:
    placement = Placement(about=(0.5, 0.0), shift=(0.0, 1.0), turn=math.pi / 2)
    moved = Region(BOX.center, BOX.half, moved=placement)
    assert placement.forth(1.0, 0.0) == pytest.approx((0.5, 1.5))
    assert placement.back(*placement.forth(0.3, 0.7)) == pytest.approx((0.3, 0.7))
    assert moved.holds((0.5, 1.5, 0.0))
    assert moved.holds((0.69, 1.5, 0.0))  # its long side lies across now
    assert not moved.holds((0.5, 1.69, 0.0))
    assert not moved.holds((1.0, 0.0, 0.0))


@pytest.mark.parametrize("placement", [None, Placement(about=(0.5, 0.0), shift=(0.1, 0.2), turn=0.4)])
@pytest.mark.parametrize("round_", [False, True])
def test_many_points_are_held_as_each_is(placement: Placement | None, round_: bool) -> None:
    region = Region(BOX.center, BOX.half, margin=0.03, round=round_, moved=placement)
    rng = np.random.default_rng(0)
    points, inside = rng.uniform([0.5, -0.4, -0.4], [1.5, 0.8, 0.4], (3000, 3)), rng.random(3000) < 0.5
    each = [region.holds(p.tolist(), bool(was)) for p, was in zip(points, inside, strict=True)]
    assert 100 < sum(each) < 2900
    np.testing.assert_array_equal(region.holds_rows(points.T, inside), each)
