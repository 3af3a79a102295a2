"""What a person asks of an exploration."""

import pytest

from ichain_drake.errors import InputError
from ichain_drake.runs.exploring.settings import EXPLORING, settings_for


def test_what_is_not_asked_for_stays_as_it_is() -> None:
    assert settings_for() == EXPLORING
    asked = settings_for(90.0, 0.8)
    assert (asked.budget, asked.confidence, asked.piece) == (90.0, 0.8, EXPLORING.piece)


@pytest.mark.parametrize(
    ("budget", "confidence", "message"),
    [(-1.0, None, "budget"), (20.0, None, "a piece alone takes 30 s"), (None, 0.4, "confidence")],
)
def test_what_can_not_be_is_refused(budget: float | None, confidence: float | None, message: str) -> None:
    with pytest.raises(InputError, match=message):
        settings_for(budget, confidence)
