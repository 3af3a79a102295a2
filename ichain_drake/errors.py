"""Errors that a user can act on.

Every message says what is wrong, where, and what to do next. The command line prints it as one line and exits with 2.
"""


class IchainError(Exception):
    """Base class of all errors that this library raises on purpose."""


class InputError(IchainError, ValueError):
    """Something that came from outside (a file, an argument, an array) can't be used."""


class UnreachableError(IchainError):
    """A goal, hand state or path that the models or the arm can't bring about; the message names the condition."""


class ActiveCycleError(IchainError):
    """Interactions that are active at one time form a cycle: no order of evaluation exists."""
