"""Samples of a drive that hold beside something, brought to where that is now."""

from types import SimpleNamespace

import numpy as np
import pytest

from ichain_drake.control.planning.drive_option import DriveOption
from ichain_drake.graph import Interaction
from ichain_drake.state import FloatArray

CHAIN = (Interaction("hand", "jug"), Interaction("jug", "stove"))
NOW = {"stove": np.array([1.0]), "jug": np.array([0.0]), "hand": np.array([0.0])}


def frames(reach: float, shown: float = np.inf) -> SimpleNamespace:
    """Frames of which nothing is turned; a jug is within reach, and was seen, up to some place."""

    def along(obj: str, states: FloatArray, onto: str, then: FloatArray, now: FloatArray) -> FloatArray:
        return states + (now - then)

    return SimpleNamespace(
        along=along,
        in_reach=lambda obj, states, nearly=False: states[:, 0] <= reach,
        is_shown=lambda obj, states: states[:, 0] <= shown,
    )


def option(anchor: str | None = "stove") -> DriveOption:
    """Learned with the stove at 0: best .3 beside it, before that .4, else .2 or .1."""

    def at(*places: float) -> dict[str, FloatArray]:
        one = np.array(places)[:, None] if len(places) > 1 else np.array(places)
        return {"stove": np.zeros_like(one), "jug": one, "hand": one}

    carry = SimpleNamespace(edge=CHAIN[0])
    return DriveOption(CHAIN, 0, 1, 0.1, carry, at(0.3), at(0.4), None, anchor, at(0.2, 0.1))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("reach", "shown", "hold", "before"),
    [
        (2.0, np.inf, 1.3, 1.4),
        (1.25, np.inf, 1.2, 1.2),
        (1.15, np.inf, 1.1, 1.1),
        (2.0, 1.15, 1.1, 1.1),
        (2.0, 0.0, 1.3, 1.4),
    ],
)
def test_it_is_the_surest_that_is_within_reach_and_was_shown_if_any_was(
    reach: float, shown: float, hold: float, before: float
) -> None:
    found = option().placed(frames(reach, shown), NOW)  # type: ignore[arg-type]
    assert found is not None
    assert (found.hold["jug"], found.before["jug"]) == (pytest.approx([hold]), pytest.approx([before]))
    assert (found.hold["hand"], found.hold["stove"]) == (pytest.approx([hold]), pytest.approx([1.0]))


@pytest.mark.parametrize(("bound", "hold"), [(1.25, 1.2), (1.05, 1.1), (0.95, None)])
def test_the_robot_itself_has_to_be_within_reach_as_it_holds_the_thing_or_nearly(
    bound: float, hold: float | None
) -> None:
    """A thing's places within reach are a box along its own frame's axes, which holds more than the robot's does."""

    def in_reach(obj: str, states: FloatArray, nearly: bool = False) -> FloatArray:
        return states[:, 0] <= (2.0 if obj == "jug" else bound + 0.1 * nearly)

    found = option().placed(SimpleNamespace(**vars(frames(2.0)) | {"in_reach": in_reach}), NOW)  # type: ignore[arg-type]
    assert (None if found is None else found.hold["hand"]) == (None if hold is None else pytest.approx([hold]))


def test_out_of_reach_there_is_none_and_without_an_anchor_it_stays_as_it_is() -> None:
    assert option().placed(frames(1.0), NOW) is None  # type: ignore[arg-type]
    free = option(None)
    assert free.placed(frames(0.0), NOW) is free  # type: ignore[arg-type]
