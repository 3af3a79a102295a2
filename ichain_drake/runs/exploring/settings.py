"""Constants of exploring: how far a hand goes, and when it knows enough."""

from __future__ import annotations

from dataclasses import dataclass, replace

from ichain_drake.errors import InputError
from ichain_drake.settings import check_settings, setting
from ichain_drake.timing import TICK


@dataclass(frozen=True)
class ExploringSettings:
    """How a robot tries things out.

    Attributes:
        confidence: of every interaction, from which on a graph is known.
        budget: that the robot may spend.
        piece: length of one.
        margin: that the hand goes beyond places that were shown.
        beside: farthest from an object that it closes.
        near: of that, at every second time.
        turn: that it turns what it holds, and itself, to either side.
        along: of the hand's way, from which on an object is taken to go along.
        drags: ways of what goes along, until it is let go.
        left: of so many touches of one object, that which leaves it where it was moved to; after the others it is put
            back, so that things mostly are as the robot found them, and it sees what goes on by itself.
        rest: longest wait at a place.
        pieces: in which a graph must have been the same, and nothing left to try; so many between attempts at the goal.
        tries: of each experiment that could answer a question, after which it stays open.
    """

    confidence: float = setting(0.95, "probability", above=0.5, below=1)
    budget: float = setting(600.0, "s", above=0)
    piece: int = setting(90, "ticks", lower=20)
    margin: float = setting(0.05, "m", lower=0)
    beside: float = setting(0.05, "m", above=0)
    near: float = setting(0.2, "share", lower=0, upper=1)
    turn: float = setting(0.5, "rad", lower=0)
    along: float = setting(0.3, "share", above=0, below=1)
    drags: int = setting(3, "ways", lower=1)
    left: int = setting(4, "touches", lower=1)
    rest: int = setting(12, "ticks", lower=1)
    pieces: int = setting(3, "pieces", lower=1)
    tries: int = setting(3, "pieces", lower=1)


EXPLORING = ExploringSettings()
"""The ones in force."""


def settings_for(budget: float | None = None, confidence: float | None = None) -> ExploringSettings:
    """The ones in force, with what is asked for otherwise.

    Args:
        budget: [s]; None for the default.
        confidence: None for the default.

    Raises:
        InputError: on a value that can't be, or a budget that is too small for one piece.
    """
    out = replace(
        EXPLORING,
        budget=EXPLORING.budget if budget is None else budget,
        confidence=EXPLORING.confidence if confidence is None else confidence,
    )
    check_settings(out)
    if out.budget < out.piece * TICK:
        raise InputError(f"--budget {out.budget:g}: a piece alone takes {out.piece * TICK:g} s")
    return out
