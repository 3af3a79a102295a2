"""Scores of status and switching."""

import numpy as np

from ichain_drake.learning.status.scores import event_f1, f1, match_events, switches


def status(text: str) -> np.ndarray:
    return np.array([c == "1" for c in text])


def test_f1() -> None:
    assert f1(status("0011"), status("0011")) == 1.0
    assert f1(status("0011"), status("0110")) == 0.5
    assert f1(status("00"), status("00")) == 1.0
    assert f1(status("01"), status("00")) == 0.0
    assert f1(status("10"), status("11")) == 2 / 3


def test_switches() -> None:
    on, off = switches(status("0110010"))
    assert on.tolist() == [1, 5]
    assert off.tolist() == [3, 6]


def test_events_match_within_one_row_and_once() -> None:
    assert match_events(status("00111000"), status("01110000")) == (2, 2, 2)
    assert match_events(status("00111000"), status("00000110")) == (0, 2, 2)
    assert match_events(status("0011111"), status("0101111")) == (1, 1, 3)  # flicker is two false events


def test_event_f1() -> None:
    truth = [status("0011100"), status("0000000")]
    assert event_f1(truth, truth) == 1.0
    assert event_f1(truth, [status("0011100"), status("0001000")]) == 4 / 6
    assert event_f1([status("000")], [status("000")]) == 1.0


def test_an_event_is_matched_by_the_nearest_within_the_tolerance() -> None:
    truth, said = status("0000100001"), status("0010010010")
    assert [match_events(truth, said, tolerance=k)[0] for k in (0, 1, 2)] == [0, 3, 3]
    assert event_f1([truth], [said], tolerance=0) == 0.0
    near = status("001010000"), status("000111010")
    assert match_events(*near) == (2, 4, 4), "each once"
