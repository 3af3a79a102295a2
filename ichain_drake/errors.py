"""Errors that a user can act on.

Every message says what is wrong, where, and what to do next. The command line prints it as one line and exits with 2.
"""

from __future__ import annotations

from typing import Any


class IchainError(Exception):
    """Base class of all errors that this library raises on purpose."""

    def __str__(self) -> str:
        """One line: what was quoted from outside may hold line ends."""
        return " ".join(super().__str__().splitlines())


class InputError(IchainError, ValueError):
    """Something that came from outside (a file, an argument, an array) can't be used."""


class UnreachableError(IchainError):
    """A goal, hand state or path that the models or the arm can't bring about; the message names the condition."""


class ActiveCycleError(IchainError):
    """Interactions that are active at one time form a cycle: no order of evaluation exists."""


class WorkerLostError(IchainError):
    """A process that worked for an evaluation was killed; the message says in which trial and what is kept.

    Attributes:
        found: what was finished, as the evaluation returns it; empty until the evaluation fills it.
    """

    def __init__(self, message: str) -> None:
        super().__init__(message)
        self.found: dict[str, Any] = {}
