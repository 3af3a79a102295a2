"""The lines of a goal evaluation's table: faults, monitors, roles, number of pieces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np

from ichain_drake.demonstrations import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.scenarios.base import Scenario
from ichain_drake.scenarios.goal_scenario import GoalScenario

CASES: dict[str, tuple[str, ...]] = {
    "none": (),
    "slip": ("fault.kind=slip",),
    "knock": ("fault.kind=knock",),
    "stiff": ("fault.kind=stiff",),
    "dropout": ("fault.kind=dropout",),
    "moved": ("fault.kind=moved",),
}
"""Settings of each fault. `noise` is the last case: `NOISE` times the configured noise of the world."""

NOISE = 3.0
PIECES = (6, 8, 10, 12, 14, 16)
"""Numbers of pieces to learn from, the first of one order; see `piece_order`."""

MONITORS, NO_MONITORS, NO_ROLES, NUMBER, CLASSIFIERS = "monitors", "no_monitors", "no_roles", "pieces", "classifiers"
METHODS: tuple[str, ...] = (MONITORS, NO_MONITORS, NO_ROLES, NUMBER, CLASSIFIERS)

ALL_PIECES = "all"
_ORDER = 4  # purpose of random numbers


@dataclass(frozen=True)
class GoalVariant:
    """What the trials of a table's line share.

    Attributes:
        method, case: names in the report.
        settings: of the world, beside the user's.
        monitors: whether the controller watches.
        learning: key of what was learned: `all`, `no_roles`, or a number of pieces.
        without: rule that is switched off in the run; empty for none.
    """

    method: str
    case: str
    settings: tuple[str, ...] = ()
    monitors: bool = True
    learning: str | int = ALL_PIECES
    without: str = ""


def choose_variants(methods: Sequence[str], scenario: GoalScenario, pieces: int) -> list[GoalVariant]:
    """The lines of the table.

    Args:
        methods: as on the command line: `method` or `method/case`; empty for all.
        scenario: its faults are the cases; those that it lacks are left out.
        pieces: number that it has.

    Raises:
        InputError: on an unknown method or case.
    """
    noise = f"noise.scale={NOISE * scenario.config.noise.scale:g}"
    faults = getattr(scenario, "faults", ("none",))
    cases = {c: s for c, s in CASES.items() if c in faults} | {"noise": (noise,)}
    known = [GoalVariant(m, c, s, m == MONITORS) for m in (MONITORS, NO_MONITORS) for c, s in cases.items()]
    known.append(GoalVariant(NO_ROLES, "none", learning=NO_ROLES))
    numbers = [n for n in PIECES if n < pieces] + [pieces]
    known += [GoalVariant(NUMBER, f"{n} pieces", learning=ALL_PIECES if n == pieces else n) for n in numbers]
    chosen: list[GoalVariant] = []
    for text in methods or METHODS:
        method, slash, case = text.partition("/")
        if method not in METHODS:
            raise InputError(f"there is no method {method!r}; there are {', '.join(METHODS)}")
        found = [v for v in known if v.method == method and case in ("", v.case)]
        if slash and not found:
            has = ", ".join(v.case for v in known if v.method == method) or "none"
            raise InputError(f"method {method} has no case {case!r}; it has {has}")
        chosen += [v for v in found if v not in chosen]
    return chosen


def possible_variants(
    variants: Sequence[GoalVariant], scenario: GoalScenario, overrides: tuple[str, ...], skipped: dict[str, str]
) -> list[GoalVariant]:
    """Without the cases that the scenario refuses in this physics.

    Args:
        variants: all lines.
        scenario: with the physics.
        overrides: its settings.
        skipped: is given the refused cases with their reasons.
    """
    kind, out = cast("type[Scenario]", type(scenario)), []
    for variant in variants:
        try:
            kind((*overrides, *variant.settings), scenario.physics, scenario.seed)
        except InputError as error:
            skipped[variant.case] = str(error)
        else:
            out.append(variant)
    return out


def piece_order(pieces: Sequence[Demonstration], seed: int) -> list[Demonstration]:
    """The pieces shuffled, but first those that show an interaction which no piece before them shows.

    So the first few are what a person would show who has time for no more, and the rest adds experience.
    """
    shuffled = [pieces[i] for i in np.random.default_rng([seed, _ORDER]).permutation(len(pieces))]
    first, seen = [], set[str]()
    for piece in shuffled:
        shown = {c for c in piece.table.columns if "->" in c and (piece.table[c] > 0.5).any()}  # noqa: PLR2004 - a flag
        if shown - seen:
            first.append(piece)
            seen |= shown
    return [*first, *(p for p in shuffled if not any(p is q for q in first))]
