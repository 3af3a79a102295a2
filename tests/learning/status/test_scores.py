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
