"""A path that turns more tightly than anything that was shown at its speed is refused, and no other."""

from types import SimpleNamespace

import numpy as np
import pytest

from ichain_drake.control.tracking.path import PathLimits, TimedPath
from ichain_drake.control.tracking.turns import check_turns
from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.state import Role, StateSpace, Variable
from ichain_drake.timing import TICK

SPEED = 45.0
LIMITS = PathLimits(speed=SPEED, turn_rate=9.0, spacing=1.0, smoothing=1.0, tolerance=3.0)
ROLES = (Role("position", "plane", "x"), Role("position", "plane", "y"), Role("orientation", "plane", "z"))
BOAT = StateSpace(
    "boat",
    (
        Variable("x", "px", role=ROLES[0]),
        Variable("y", "px", role=ROLES[1]),
        Variable("h", "rad", kind="angle", role=ROLES[2]),
    ),
)


def chain(radius: float, speed: float = SPEED, space: StateSpace = BOAT, rows: int = 60) -> SimpleNamespace:
    """What was shown: a circle of a radius at a speed, once left and once right around."""
    turn = speed * TICK / radius * np.arange(rows)
    left = np.stack([radius * np.sin(turn), -radius * np.cos(turn), (turn + np.pi) % (2 * np.pi) - np.pi], axis=1)
    graph = InteractionGraph({"wheel": StateSpace("wheel", (Variable("a"),)), "boat": space}, ["wheel->boat"])
    return SimpleNamespace(graph=graph, names=("wheel", "boat"), targets=(0, 1), validation=[left, left * [1, -1, -1]])


def arc(radius: float, way: float = 1.0) -> TimedPath:
    angle = np.linspace(0, 2.5, 400)
    return TimedPath(np.stack([radius * np.cos(angle), way * radius * np.sin(angle)], axis=1) + 400.0, LIMITS)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_turn_is_compared_with_the_tightest_that_was_shown(way: float) -> None:
    check_turns(arc(110.0, way), chain(100.0), "path", "px")
    with pytest.raises(InputError) as refused:
        check_turns(arc(80.0, way), chain(100.0), "path arc", "px")
    text = str(refused.value)
    assert text.startswith("path arc: at (")
    assert "turns with a radius of 80." in text
    assert "the tightest turn in the demonstrations at 45 px/s is 99.9 px" in text
    assert text.endswith("widen the turn, or lower path.speed")


def test_the_place_of_the_turn_is_named() -> None:
    straight = np.stack([np.linspace(0, 300, 200), np.zeros(200)], axis=1)
    bend = np.linspace(-np.pi / 2, 0, 60)
    bent = np.stack([300 + 50 * np.cos(bend), 50 + 50 * np.sin(bend)], axis=1)
    after = np.stack([np.full(200, 350.0), np.linspace(50, 350, 200)], axis=1)
    with pytest.raises(InputError, match=r"at \((29\d|30\d|31\d), \d\)") as refused:
        check_turns(TimedPath(np.concatenate([straight, bent[1:], after[1:]]), LIMITS), chain(100.0), "path", "px")
    assert "(0, 0)" not in str(refused.value)


def test_speeds_that_were_hardly_shown_and_objects_without_heading_refuse_nothing() -> None:
    tight = arc(40.0)
    with pytest.raises(InputError):
        check_turns(tight, chain(100.0, speed=1.25 * SPEED), "path", "px")
    check_turns(tight, chain(100.0, speed=1.4 * SPEED), "path", "px")
    check_turns(tight, chain(100.0, speed=0.6 * SPEED), "path", "px")
    check_turns(tight, chain(100.0, rows=4), "path", "px")
    plain = StateSpace("boat", tuple(Variable(v.name, v.unit, kind=v.kind) for v in BOAT.variables))
    check_turns(tight, chain(100.0, space=plain), "path", "px")


def test_a_heading_that_wraps_is_no_turn() -> None:
    shown = chain(100.0)
    assert max(np.abs(np.diff(piece[:, 2])).max() for piece in shown.validation) > 6.0
    with pytest.raises(InputError, match="demonstrations at 45 px/s is 99.9 px"):
        check_turns(arc(70.0), shown, "path", "px")
