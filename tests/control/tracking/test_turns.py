"""Turns that were shown, paths that ask for more, and what is offered then."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ichain_drake.control.settings import TRACKING
from ichain_drake.control.tracking.path import PathLimits, TimedPath
from ichain_drake.control.tracking.turns import (
    ShownTurns,
    _averaged,
    check_turns,
    sharp_turn,
    shown_turns,
    slower,
    smooth_path,
)
from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import Role, StateSpace, Variable
from ichain_drake.timing import TICK

LIMITS = PathLimits(speed=45.0)
SPACE = StateSpace("car", (
    Variable("x", "px", role=Role("position", "screen", "x")),
    Variable("y", "px", role=Role("position", "screen", "y")),
    Variable("heading", "rad", kind="angle", role=Role("orientation", "screen", "z")),
))  # fmt: skip
SHOWN = ShownTurns(np.linspace(10.0, 50.0, 400), np.full(400, 1 / 40))
CORNER = TimedPath(np.array([[100.0, 100.0], [400.0, 100.0], [400.0, 400.0]]), LIMITS)


def chain() -> Any:
    """A car that was shown driving a circle of 40 px at many speeds."""
    speed = np.linspace(10.0, 50.0, 400)
    heading = np.concatenate([[0.0], np.cumsum(speed * TICK / 40)])
    step = (speed * TICK)[:, None] * np.stack([np.cos(heading[:-1]), np.sin(heading[:-1])], axis=1)
    place = np.concatenate([[[0.0, 0.0]], np.cumsum(step, axis=0)])
    graph = InteractionGraph({"hand": SPACE, "car": SPACE}, [("hand", "car")])
    return SimpleNamespace(
        graph=graph, names=("hand", "car"), targets=(0, 1), validation=[np.column_stack([place, heading])]
    )


def circle(radius: float) -> TimedPath:
    a = np.linspace(0.0, 2 * np.pi, 400)
    return TimedPath(radius * np.stack([np.cos(a), np.sin(a)], axis=1), LIMITS)


def test_what_was_shown_can_be_followed() -> None:
    assert sharp_turn(circle(45.0), SHOWN) is None
    assert sharp_turn(circle(35.0), SHOWN) is not None


def test_a_tiny_circle_is_too_sharp_though_its_speed_was_hardly_shown() -> None:
    """It is so tight that it would be taken far slower than anything in the demonstrations."""
    tiny = circle(5.0)
    assert tiny.speed.max() < 8
    assert sharp_turn(tiny, SHOWN) is not None


def test_a_speed_that_is_advised_works() -> None:
    """Slower was shown turning more sharply: the advice is checked before it is given."""
    speed = np.linspace(5.0, 50.0, 500)
    shown = ShownTurns(speed, 1.1 / speed)
    path = circle(33.0)
    sharp = ShownTurns(speed, np.where(speed > 25, 1 / 60, 1 / 20))
    advised = slower(path, sharp)
    assert advised is not None and advised < 45
    assert sharp_turn(TimedPath(path.points, PathLimits(speed=advised)), sharp) is None
    assert slower(circle(3.0), sharp) is None
    assert sharp_turn(circle(60.0), shown) is None


def test_a_refusal_says_what_would_help() -> None:
    with pytest.raises(InputError, match="path corner: at .* radius of .* widen the turn or give --smooth"):
        check_turns(CORNER, chain(), "path corner", "px")


def test_a_refusal_names_the_radius() -> None:
    with pytest.raises(InputError, match=r"with a radius of 3\.0 px; the tightest turn in the demonstrations"):
        check_turns(circle(3.0), chain(), "path circle", "px")


def test_corners_are_rounded_as_far_as_needed_and_the_ends_stay() -> None:
    path, off = smooth_path(CORNER, chain(), "path corner", "px")
    check_turns(path, chain(), "path corner", "px")
    np.testing.assert_allclose(path.points[[0, -1]], CORNER.points[[0, -1]], atol=1e-9)
    assert 3 < off < 40
    same, none = smooth_path(circle(60.0), chain(), "path round", "px")
    assert none == 0.0 and len(same.points) == len(circle(60.0).points)


def test_what_no_smoothing_helps_is_refused() -> None:
    with pytest.raises(InputError, match="however it is smoothed"):
        smooth_path(circle(8.0), chain(), "path dot", "px")


def test_few_rows_leave_open_how_sharp_the_sharpest_was() -> None:
    """The same turns in 40 rows and in 4000: of few, the sharpest may as well be usual."""
    few, many = (ShownTurns(np.full(n, 45.0), np.linspace(0.0, 1 / 30, n)) for n in (40, 4000))
    assert few.sharpest(45.0) == 1 / 30
    assert 0.98 / 30 < many.sharpest(45.0) < 0.99 / 30


def test_turns_count_at_speeds_like_the_one_asked_for() -> None:
    """Slow ones turned sharply, fast ones did not; in between nothing was shown, and the nearest count."""
    speed = np.concatenate([np.linspace(9.0, 11.0, 200), np.linspace(39.0, 41.0, 200)])
    shown = ShownTurns(speed, np.where(speed < 20, 0.1, 0.02))
    assert [shown.sharpest(v) for v in (10.0, 12.0, 40.0, 35.0, 20.0, 32.0, 90.0, 1.0)] == pytest.approx(
        [0.1, 0.1, 0.02, 0.02, 0.1, 0.02, 0.02, 0.1]
    )
    band = TRACKING.band * 50.0
    edge = ShownTurns(
        np.array([50.0] * 20 + [50.0 - 0.99 * band, 50.0 + 1.01 * band]), np.array([0.1] * 20 + [0.5, 0.9])
    )
    assert edge.sharpest(50.0) == pytest.approx(0.5), "within the band, and no further"


def test_where_hardly_anything_was_shown_the_nearest_are_enough() -> None:
    few = ShownTurns(np.array([1.0, 2.0, 3.0]), np.array([0.1, 0.3, 0.2]))
    assert few.sharpest(100.0) == pytest.approx(0.3), "all there is"
    speed = np.linspace(1.0, 10.0, 1000)
    near = int(LEARNING.near * 1000)
    assert ShownTurns(speed, speed).sharpest(100.0) == pytest.approx(10.0, abs=0.01)
    bent = ShownTurns(speed, np.where(np.arange(1000) < 1000 - near - 1, 9.0, 0.5))
    assert bent.sharpest(100.0) == pytest.approx(0.5), "a twentieth of the rows, not all"


def test_of_many_rows_the_sharpest_few_are_noise() -> None:
    n = 1000
    shown = ShownTurns(np.full(n, 45.0), np.arange(n) / n)
    q = TRACKING.quantile + LEARNING.sure * np.sqrt(TRACKING.quantile * (1.0 - TRACKING.quantile) / n)
    assert shown.sharpest(45.0) == pytest.approx(np.quantile(shown.curvature, q))


def test_turns_are_those_of_the_last_object_by_the_way_that_it_went() -> None:
    made = chain()
    shown = shown_turns(made)
    assert shown is not None
    np.testing.assert_allclose(shown.curvature, 1 / 40)
    np.testing.assert_allclose(shown.speed, np.linspace(10.0, 50.0, 400))
    rest = np.vstack([made.validation[0], made.validation[0][-1:]])
    still = SimpleNamespace(**vars(made) | {"validation": [rest, made.validation[0][:5]]})
    again = shown_turns(still)  # type: ignore[arg-type]
    assert again is not None
    assert len(again.speed) == 404, "where it stands it does not turn"
    pi = SimpleNamespace(**vars(made) | {"validation": [np.array([[0.0, 0.0, 3.1], [3.0, 4.0, -3.1]])]})
    wrapped = shown_turns(pi)  # type: ignore[arg-type]
    assert wrapped is not None
    np.testing.assert_allclose(wrapped.curvature, (2 * np.pi - 6.2) / 5.0)
    standing = SimpleNamespace(**vars(made) | {"validation": [np.zeros((9, 3))]})
    assert shown_turns(standing) is None  # type: ignore[arg-type]
    plain = StateSpace("dot", SPACE.variables[:2])
    dot = SimpleNamespace(**vars(made) | {"graph": InteractionGraph({"hand": SPACE, "car": plain}, [("hand", "car")])})
    assert shown_turns(dot) is None  # type: ignore[arg-type]
    check_turns(CORNER, dot, "path corner", "px")  # type: ignore[arg-type]
    drawn = SimpleNamespace(
        **vars(made) | {"graph": InteractionGraph({"hand": plain, "car": SPACE}, [("hand", "car")])}
    )
    assert shown_turns(drawn) is not None, "whatever the hand is"  # type: ignore[arg-type]
    other = SimpleNamespace(**vars(made) | {"targets": (0, 2)})
    assert shown_turns(other) is None, "what follows the path is no place"  # type: ignore[arg-type]


def test_the_first_turn_that_is_too_sharp_is_told_with_what_was_shown_at_its_speed() -> None:
    found = sharp_turn(CORNER, SHOWN)
    assert found is not None
    i, curvature, sharpest = found
    assert sharpest == pytest.approx(1 / 40)
    every = np.abs(CORNER.mean_curvature(LIMITS.speed * TICK))
    assert curvature == pytest.approx(every[i])
    assert curvature > sharpest
    assert (every[: i - 2] <= sharpest).all(), "looked at every third point"
    never = ShownTurns(SHOWN.speed, np.zeros(400))
    assert sharp_turn(TimedPath(np.array([[0.0, 0.0], [300.0, 0.0]]), LIMITS), never) is None, "straight is no turn"
    with pytest.raises(InputError, match=r"is none: they never turn there"):
        made = chain()
        made.validation[0][:, 2] = 0.0
        check_turns(CORNER, made, "path corner", "px")


def test_points_are_averaged_over_their_neighbours_and_mirrored_about_the_ends() -> None:
    points = np.array([[0.0, 0.0], [1.0, 2.0], [2.0, 0.0], [3.0, 5.0], [4.0, 1.0]])

    def averaged(rows: np.ndarray, half: int) -> np.ndarray:
        n = len(rows)

        def at(k: int) -> np.ndarray:
            if k < 0:
                return 2 * rows[0] - rows[-k]
            return rows[k] if k < n else 2 * rows[-1] - rows[2 * n - 2 - k]

        return np.array([np.mean([at(k + j) for j in range(-half, half + 1)], axis=0) for k in range(n)])

    for half in (1, 2, 4):
        np.testing.assert_allclose(_averaged(points, half), averaged(averaged(points, half), half), atol=1e-12)
    np.testing.assert_allclose(_averaged(points, 50), _averaged(points, 4), err_msg="no further than there are points")


def test_a_speed_is_advised_to_two_digits_and_not_below_what_was_shown() -> None:
    path = circle(33.0)
    speed = np.linspace(20.0, 50.0, 500)
    sharp = ShownTurns(speed, np.where(speed > 25, 1 / 60, 1 / 20))
    advised = slower(path, sharp)
    assert advised is not None
    assert advised == float(f"{advised:.2g}")
    assert advised < 45.0 * 0.9 + 0.5
    never = ShownTurns(speed, np.full(500, 1 / 60))
    assert slower(path, never) is None
    slow = ShownTurns(np.linspace(44.0, 50.0, 500), np.full(500, 1 / 20))
    assert slower(circle(60.0), slow) is None, "nobody ever drove that slowly"


def test_a_corner_is_rounded_by_as_much_on_a_longer_path() -> None:
    off = [
        smooth_path(TimedPath(np.array([[0.0, 50.0], [leg, 50.0], [leg, 50.0 + leg]]), LIMITS), chain(), "path", "px")[
            1
        ]
        for leg in (300.0, 900.0)
    ]
    assert off[1] == pytest.approx(off[0], rel=0.2)
