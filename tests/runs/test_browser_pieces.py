"""What an open piece knows: its rows, frame by frame, and what a person marked in it."""

import pytest

from ichain_drake.runs.browser_pieces import OpenPiece
from ichain_drake.timing import FRAMES_PER_TICK


@pytest.mark.parametrize(
    ("frame", "rows"), [(0, 0), (19, 0), (20, 1), (29, 1), (30, 2), (20 + 5 * FRAMES_PER_TICK - 1, 5)]
)
def test_a_piece_has_a_row_a_tick_from_its_first_on(frame: int, rows: int) -> None:
    assert OpenPiece("p", 20).rows(frame) == rows


@pytest.mark.parametrize(
    ("before", "marks", "flag"), [(False, 1, True), (False, 2, False), (True, 1, False), (True, 2, True)]
)
def test_each_mark_flips_what_was_before(before: bool, marks: int, flag: bool) -> None:
    piece = OpenPiece("p", 0, {"a->b": [3] * marks}, {"a->b": before})
    assert piece.marked("a->b") is flag
    assert piece.marked("a->c") is None, "what was never marked is the simulation's"
