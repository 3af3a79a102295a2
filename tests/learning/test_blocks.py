"""What is left out together: every row once, no block across pieces, groups of like size."""

import numpy as np
import pytest

from ichain_drake.learning.blocks import interleaved_blocks, piece_blocks, runs, windows


def rows_of(sizes: list[int]) -> tuple[np.ndarray, np.ndarray]:
    return np.repeat(np.arange(len(sizes)), sizes), np.concatenate([np.arange(n) for n in sizes])


def test_few_pieces_are_cut_into_blocks_that_are_not_too_short() -> None:
    piece, row = rows_of([40, 9])
    group = piece_blocks(piece, row, 8)
    np.testing.assert_array_equal(group, [*np.repeat([0, 1, 2, 3], 10), *[4] * 9])
    np.testing.assert_array_equal(piece_blocks(*rows_of([11]), 8), [*[0] * 6, *[1] * 5])
    np.testing.assert_array_equal(piece_blocks(*rows_of([4]), 8), [0] * 4)
    assert piece_blocks(*rows_of([100, 100]), 7).max() == 7  # as many blocks of each: rounded up


def test_many_pieces_are_dealt_whole_to_the_group_that_has_least() -> None:
    piece, row = rows_of([5, 2, 7, 3])
    by_piece = [int(piece_blocks(piece, row, 2)[piece == k][0]) for k in range(4)]
    assert by_piece == [1, 0, 0, 1]  # 7 | 5 | 3 to the 5 | 2 to the 7
    group = piece_blocks(*rows_of([6, 6, 6]), 8)
    np.testing.assert_array_equal(group, np.repeat([0, 1, 2], 6))


def test_short_blocks_are_dealt_in_turn_over_pieces() -> None:
    piece, _ = rows_of([5, 3])
    np.testing.assert_array_equal(interleaved_blocks(piece, 3, 2), [0, 0, 1, 1, 2, 0, 0, 1])
    np.testing.assert_array_equal(interleaved_blocks(np.zeros(21, dtype=np.intp), 2), [*[0] * 10, *[1] * 10, 0])


@pytest.mark.parametrize(
    ("mask", "expected"),
    [([], []), ([0, 0], []), ([1, 1], [(0, 2)]), ([1, 0, 1, 1, 0], [(0, 1), (2, 4)]), ([0, 1], [(1, 2)])],
)
def test_runs(mask: list[int], expected: list[tuple[int, int]]) -> None:
    assert runs(np.array(mask, dtype=bool)) == expected


def test_windows_cross_neither_a_gap_nor_a_piece() -> None:
    piece, row = np.array([0] * 7 + [1] * 4), np.array([0, 1, 2, 3, 6, 7, 8, 9, 10, 11, 12])
    assert windows(piece, row, 2) == [(0, 2), (2, 4), (4, 6), (6, 7), (7, 9), (9, 11)]
    assert windows(piece, row, 1) == [(k, k + 1) for k in range(11)]
    assert windows(piece, row, 100) == [(0, 4), (4, 7), (7, 11)]
    assert windows(piece[:0], row[:0], 2) == []
