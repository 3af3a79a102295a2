"""Demonstrated events of the robot's interactions, each with its surroundings and nothing of another event."""

import numpy as np
import pandas as pd

from ichain_drake.demonstrations import Demonstration
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.data import collect
from ichain_drake.learning.settings import LEARNING
from ichain_drake.learning.status.events import SwitchingWindow, collect_examples, collect_windows
from ichain_drake.state import StateSpace, Variable
from ichain_drake.timing import TICK

HAND = StateSpace("hand", (Variable("x", "m"), Variable("grip", kind="binary", lower=0, upper=1)))
BOX, LID = StateSpace("box", (Variable("x", "m"),)), StateSpace("lid", (Variable("x", "m"),))
GRAPH = InteractionGraph({"hand": HAND, "box": BOX, "lid": LID}, ["hand->box", "box->lid"])
EDGE = Interaction("hand", "box")


def windows(grip: str, flags: str) -> tuple[tuple[SwitchingWindow, ...], tuple[SwitchingWindow, ...]]:
    """On and off, of a hand whose x is the row and a box whose x is a tenth of it."""
    rows = np.arange(len(flags))
    table = {"time": TICK * rows, "hand.x": 1.0 * rows, "hand.grip": [float(c) for c in grip], "box.x": 0.1 * rows}
    table |= {"lid.x": 0.0 * rows, "hand->box": [float(c) for c in flags], "box->lid": 0.0 * rows}
    on, off = collect_windows([Demonstration(pd.DataFrame(table))], GRAPH)
    assert set(on) == set(off) == {EDGE}, "the robot's own alone"
    return on[EDGE], off[EDGE]


def rows_of(window: SwitchingWindow) -> list[int]:
    return [int(x) for x in window.root[:, 0]]


def test_an_event_has_its_surroundings_and_the_child_before_it() -> None:
    before, after = 30, 30
    grip = "0" * before + "1" * after
    (on,), off = windows(grip, grip)
    assert off == ()
    assert on.child[0] == np.float64(0.1 * (before - 1))
    assert rows_of(on) == list(range(before - LEARNING.look, before + LEARNING.ticks + 1))
    assert rows_of(on)[on.event] == before


def test_the_windows_of_two_events_do_not_overlap() -> None:
    flags = "0" * 9 + "1" * 2 + "0" * 9
    (on,), (off,) = windows("0" * 9 + "1" * 2 + "0" * 9, flags)
    assert rows_of(on)[-1] == 10
    assert rows_of(off)[0] == 9
    assert rows_of(off)[off.event] == 11


def test_an_attempt_that_failed_before_is_no_part_of_it() -> None:
    """The hand closes in row 4 and opens in row 6 for nothing; what it does from then on leads to row 9."""
    grip = "0000110001111"
    (on,), _ = windows(grip, "0000000001111")
    assert rows_of(on)[0] == 6
    assert rows_of(on)[on.event] == 9
    assert on.root[:3, 1].tolist() == [0.0, 0.0, 0.0]


def test_examples_are_the_rows_around_each_event_and_samples_of_either_status() -> None:
    parts = []
    for k, flags in enumerate(("0001100", "0110000", "0000000")):
        rows = np.arange(len(flags)) + 10.0 * k
        on = [float(c) for c in flags]
        table = {"time": TICK * np.arange(len(flags)), "hand.x": rows, "hand.grip": on, "box.x": 0.1 * rows}
        table |= {"lid.x": 0.0 * rows, "hand->box": on, "box->lid": on}
        parts.append(Demonstration(pd.DataFrame(table), {}, f"piece_{k}"))
    found = collect_examples(collect(parts, GRAPH), EDGE)
    for part, rows in ((found.activations, [3, 1]), (found.deactivations, [5, 3])):
        assert dict(zip(part.pieces, part.rows, strict=True)) == {"piece_0": rows[0], "piece_1": rows[1]}
        at = np.array([row + 10 * (name == "piece_1") for name, row in zip(part.pieces, part.rows, strict=True)])
        np.testing.assert_array_equal(part.after["hand"][:, 0], at)
        np.testing.assert_array_equal(part.before["hand"][:, 0], at - 1)
        np.testing.assert_allclose(part.before["box"][:, 0], 0.1 * (at - 1))
    assert sorted(found.active["hand"][:, 0]) == [3, 4, 11, 12]
    assert len(found.inactive["hand"]) == 17


def test_an_event_right_after_the_start_has_all_that_was_before_it() -> None:
    (on,), (off,) = windows("0011100000000000", "0011100000000000")
    assert rows_of(on) == [0, 1, 2, 3, 4]
    assert rows_of(off)[0] == 2


def test_of_two_hands_that_close_either_may_have_failed_before() -> None:
    """The second closed in row 4, and opened in row 5, for nothing."""
    hand = StateSpace("hand", (*HAND.variables, Variable("other", kind="binary", lower=0, upper=1)))
    graph = InteractionGraph({"hand": hand, "box": BOX}, ["hand->box"])
    rows = np.arange(12)
    table = {"time": TICK * rows, "hand.x": 1.0 * rows, "hand.grip": 1.0 * (rows >= 7), "hand.other": 1.0 * (rows == 4)}
    table |= {"box.x": 0.0 * rows, "hand->box": 1.0 * (rows >= 7)}
    on, _ = collect_windows([Demonstration(pd.DataFrame(table))], graph)
    assert rows_of(on[EDGE][0])[0] == 5
    table["hand.other"] = 0.0 * rows
    on, _ = collect_windows([Demonstration(pd.DataFrame(table))], graph)
    assert rows_of(on[EDGE][0])[0] == 7 - LEARNING.look
