"""Rules of thumb that are not the paper's: each has a name, a reason and a switch.

A rule is asked for where it acts, `if rules.enabled("push_further")`, and switched off around a run, `with
rules.without(["push_further"])`; `ichain run`, `evaluate` and `scoreboard` have `--without NAME` for it. A rule
that no row of the scoreboard needs is deleted.
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
        where: package that has it.
    """

    name: str
    reason: str
    where: str


_PLANNING, _EXECUTION = "control.planning", "control.execution"
_EVERY = (
    Rule("subsumed", "a carried object may drive more than its chain says: then the longer chain is meant", _PLANNING),
    Rule("unseen", "a pose that was only passed through may be out of reach before it is turned", _PLANNING),
    Rule("turned_where_shown", "where a pose was only seen turned already, something may stand below it", _PLANNING),
    Rule("brought_where_shown", "where a thing never was nobody knows what it may hit", _PLANNING),
    Rule("along_a_line", "what an object has to hold is sought between demonstrated poses too", _PLANNING),
    Rule("can_hold", "an object may stand where the robot can't take it, or may not let go of it", _PLANNING),
    Rule("landmarks", "what only mixes becomes as its givers are: these must be so first", _PLANNING),
    Rule("push_further", "a stiffer button than was shown: press as far as anybody did before giving up", _EXECUTION),
    Rule("over_on_the_way", "a fast flow may be done before the drive's pose is reached", _EXECUTION),
    Rule("stalled", "a drive that has stopped changing is over, whatever it was meant to bring", _EXECUTION),
    Rule("deviation", "a step that ended elsewhere than predicted: plan anew, not on", _EXECUTION),
    Rule("detour", "what stopped the robot, and nobody knew of, is still there when it tries again", _EXECUTION),
    Rule("take_back", "what seems lost may be caught on something: let go of in the air it would fall", _EXECUTION),
    Rule("goes_along", "a grasp that the classifier doubts holds if the object moves with the robot", _EXECUTION),
    Rule("place_first", "what is turned is turned at its place, not on the way: it would spill", _EXECUTION),
)
RULES: dict[str, Rule] = {rule.name: rule for rule in _EVERY}
"""All rules by name, planning first."""

_OFF: ContextVar[frozenset[str]] = ContextVar("rules_switched_off", default=frozenset())
_ASKED: ContextVar[set[str] | None] = ContextVar("rules_asked_for", default=None)


def enabled(name: str) -> bool:
    """Whether a rule is in force; costs one look-up.

    Raises:
        KeyError: if no rule has the name: a mistake in this package, not of its user.
    """
    if (asked := _ASKED.get()) is not None:
        asked.add(name)
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


@contextmanager
def noted() -> Iterator[set[str]]:
    """Names of the rules that are asked for inside a `with`: what is done there is the same without the others."""
    asked: set[str] = set()
    token = _ASKED.set(asked)
    try:
        yield asked
    finally:
        _ASKED.reset(token)
