"""Rules of thumb that are not the paper's: each has a name, a reason and a switch.

A rule is asked for where it acts, `if rules.enabled("brimful")`, and switched off around a run, `with
rules.without(["brimful"])`; `ichain run`, `evaluate` and `scoreboard` have `--without NAME` for it. A rule that no row
of the scoreboard needs is deleted.
"""

from __future__ import annotations

import difflib
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass

from ichain_drake.errors import InputError


@dataclass(frozen=True)
class Rule:
    """A rule of thumb.

    Attributes:
        name: for `--without`.
        reason: why it is there: what would go wrong.
        where: module that has it.
    """

    name: str
    reason: str
    where: str


RULES: dict[str, Rule] = {}
_OFF: ContextVar[frozenset[str]] = ContextVar("rules_switched_off", default=frozenset())


def enabled(name: str) -> bool:
    """Whether a rule is in force; costs one look-up.

    Raises:
        KeyError: if no rule has the name: a mistake in this package, not of its user.
    """
    return RULES[name].name not in _OFF.get()


def switched_off() -> frozenset[str]:
    """Names of the rules that are not in force."""
    return _OFF.get()


def check_names(names: Collection[str]) -> None:
    """Refuse names that no rule has.

    Raises:
        InputError: naming close ones.
    """
    for name in names:
        if name not in RULES:
            close = difflib.get_close_matches(name, RULES, n=1)
            hint = f"did you mean {close[0]}?" if close else f"there are {', '.join(RULES) or 'none'}"
            raise InputError(f"there is no rule {name!r}; {hint}")


@contextmanager
def without(names: Collection[str]) -> Iterator[None]:
    """Switch rules off inside a `with`, beside those that are off already.

    Args:
        names: of `RULES`.

    Raises:
        InputError: on an unknown name, with close ones.
    """
    check_names(names)
    token = _OFF.set(_OFF.get() | frozenset(names))
    try:
        yield
    finally:
        _OFF.reset(token)
