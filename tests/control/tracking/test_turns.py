"""Turns that were shown, paths that ask for more, and what is offered then."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ichain_drake.control.tracking.path import PathLimits, TimedPath
from ichain_drake.control.tracking.turns import ShownTurns, check_turns, sharp_turn, slower, smooth_path
from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
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
