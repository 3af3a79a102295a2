"""Whether something goes along with what moves it, by the readings alone."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from moved_thing import EDGE, NOISE, model

from ichain_drake.control.execution.carried import Carried
from ichain_drake.control.execution.following import goes_along, strays
from ichain_drake.state import FloatArray


def readings(robot: Sequence[float], thing: Sequence[float], noise: float = NOISE) -> list[dict[str, FloatArray]]:
    rng = np.random.default_rng(3)
    return [
        {"robot": np.array([a, 1.0]) + noise * rng.normal(size=2), "thing": np.array([b, 0.5]) + noise * rng.normal()}
        for a, b in zip(robot, thing, strict=True)
    ]


WAY = [0.0, 0.0, 0.03, 0.06, 0.09]


def test_what_moves_as_its_parent_goes_along() -> None:
    assert goes_along(model(), EDGE, readings(WAY, WAY)) is True
    assert not strays(model(), EDGE, readings(WAY, WAY))


def test_held_off_its_place_it_still_goes_along() -> None:
    assert goes_along(model(), EDGE, readings(WAY, [x - 0.4 for x in WAY])) is True


def test_what_stays_does_not() -> None:
    assert goes_along(model(), EDGE, readings(WAY, [0.3] * 5)) is False
    assert not strays(model(), EDGE, readings(WAY, [0.3] * 5)), "its parent left it"


def test_the_newest_clear_motion_decides() -> None:
    slipped = [0.0, 0.03, 0.06, 0.06, 0.06]
    assert goes_along(model(), EDGE, readings([0.0, 0.03, 0.06, 0.09, 0.12], slipped)) is False


@pytest.mark.parametrize("seed", range(5))
def test_noise_tells_nothing(seed: int) -> None:
    rng = np.random.default_rng(seed)
    still = [{"robot": NOISE * rng.normal(size=2), "thing": NOISE * rng.normal(size=2)} for _ in range(12)]
    assert goes_along(model(), EDGE, still) is None
    assert not strays(model(), EDGE, still)


def test_half_of_the_way_tells_nothing() -> None:
    assert goes_along(model(), EDGE, readings(WAY, [0.4 * x for x in WAY])) is None


def test_so_many_ticks_are_looked_at() -> None:
    seen = readings(WAY, WAY)
    assert goes_along(model(), EDGE, seen, 1) is None
    assert goes_along(model(), EDGE, seen, 2) is True
    assert goes_along(model(), EDGE, seen[:1]) is None


def test_without_an_effect_on_a_pose_there_is_no_second_witness() -> None:
    assert goes_along(model(role=None), EDGE, readings(WAY, WAY)) is None
    assert not strays(model(role=None), EDGE, readings([0.0] * 5, WAY))


def test_what_moves_while_its_parent_rests_strays() -> None:
    fallen = readings([0.0] * 4, [0.0, 0.0, 0.2, 0.2])
    assert goes_along(model(), EDGE, fallen) is None
    assert strays(model(), EDGE, fallen)


def test_what_was_seen_last_holds_until_something_else_is_seen() -> None:
    held = Carried().taken("thing", np.array([0.0, 0.5]))
    assert held.following == ""
    held = held.watched(True).watched(None)
    assert (held.following, held.ticks) == ("thing", 2)
    assert held.taken("thing", np.array([0.7, 0.5])) is held
    assert held.watched(False).following == ""
    assert held.let_go(np.array([0.0, 1.0])).following == held.slipped().following == ""


def test_a_parent_that_goes_to_and_fro_tells_by_the_last_way_that_is_clear() -> None:
    """Over two ticks it has not moved at all; over three it has."""
    to_and_fro = [0.0, 0.0, 0.03, 0.0, 0.03]
    assert goes_along(model(), EDGE, readings(to_and_fro, to_and_fro)) is True
    assert goes_along(model(), EDGE, readings(to_and_fro, [0.0] * 5)) is False


def test_what_moved_a_while_ago_strays_too_but_a_single_tick_tells_nothing() -> None:
    fallen = readings([0.0] * 6, [0.0, 0.2, 0.2, 0.2, 0.2, 0.2])
    assert strays(model(), EDGE, fallen)
    assert not strays(model(), EDGE, fallen, 3), "that is longer ago than it was asked for"
    last = readings([0.0] * 6, [0.0, 0.0, 0.0, 0.0, 0.0, 0.2])
    assert strays(model(), EDGE, last, 2)
    assert not strays(model(), EDGE, last, 1)
