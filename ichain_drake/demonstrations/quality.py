"""What teaches wrongly, found before anything is learned from it: oddities of pieces, each with a remedy."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ichain_drake.demonstrations.column_noise import column_noise
from ichain_drake.demonstrations.columns import TIME, as_numbers, column
from ichain_drake.demonstrations.repeats import repeats
from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.graph import InteractionGraph
from ichain_drake.state import FloatArray, StateSpace, Variable, wrap_angle
from ichain_drake.timing import TICK


@dataclass(frozen=True)
class QualitySettings:
    """When something counts as odd.

    Attributes:
        frozen: rows in which nothing of an object without noise changes before it leaps, at least [rows].
        idle_window: what rests for so long is idle [s]: longer than a hand that waits for its next command.
        idle_share: largest share of a piece that may be idle [1]: beyond it most rows show rest.
        rest: readings that differ by less are the same [standard deviations of the noise].
        flickers: least number of single rows in which a flag flips and nothing moves that count: one is what
            a hand at a border makes.
        disagree: least number of rows with opposite flags in equal states that contradict [rows].
        grid: readings within this part of the variable's range of each other are the same [1].
        most_rows: rows of all pieces that are compared with each other; of more every n-th is taken.
    """

    frozen: int = 4
    idle_window: float = 2.0
    idle_share: float = 0.5
    rest: float = 4.0
    flickers: int = 2
    disagree: int = 5
    grid: float = 0.005
    most_rows: int = 4000


@dataclass(frozen=True)
class Finding:
    """Something odd.

    Attributes:
        piece: its name; several joined by commas; empty where it is about all of them.
        rows: first and last row of the table, from 0; None where it is about the whole piece.
        what: was found.
        remedy: what to do.
    """

    piece: str
    rows: tuple[int, int] | None
    what: str
    remedy: str

    def __str__(self) -> str:
        """In one line."""
        where = self.piece or "all pieces"
        rows = "" if self.rows is None else f" rows {self.rows[0]} to {self.rows[1]}"
        return f"{where}{rows}: {self.what}; {self.remedy}"


def findings(
    pieces: Sequence[Demonstration], graph: InteractionGraph, settings: QualitySettings | None = None
) -> list[Finding]:
    """What is odd about a set of demonstrations.

    Args:
        pieces: checked demonstrations.
        graph: the interaction graph.
        settings: when something counts as odd.

    Returns:
        Equal pieces, stretches that a piece has twice, frozen feeds, constant columns, idle pieces, flags that flicker,
        contradictions; in this order.
    """
    chosen = settings or QualitySettings()
    noise = column_noise(pieces, graph)
    limits = rest_limits(pieces, graph, noise, chosen)
    return [
        *_equal_pieces(pieces),
        *_repeats(pieces, noise),
        *_frozen(pieces, graph, noise, chosen),
        *_constant(pieces, graph),
        *_idle(pieces, limits, chosen),
        *_flicker(pieces, graph, limits, chosen),
        *_contradictions(pieces, graph, noise, chosen),
    ]


def tell_findings(pieces: Sequence[Demonstration], graph: InteractionGraph, say: Callable[[str], None]) -> None:
    """Say what is odd about demonstrations, a line each."""
    for finding in findings(pieces, graph):
        say(f"odd: {finding}")


def _measured(piece: Demonstration, graph: InteractionGraph) -> list[str]:
    names = (column(o, v) for o, space in graph.objects.items() for v in space.observable.names)
    return [n for n in names if n in piece.table]


def _equal_pieces(pieces: Sequence[Demonstration]) -> Iterator[Finding]:
    """Pieces with the same readings: one recording counted twice, and no evidence of its own."""
    kept = [(p, p.table.drop(columns=TIME).sort_index(axis=1)) for p in pieces if TIME in p.table]
    for (a, first), (b, second) in itertools.combinations(kept, 2):
        rows = min(len(first), len(second))
        if list(first.columns) != list(second.columns):
            continue
        if np.array_equal(first.to_numpy()[:rows], second.to_numpy()[:rows]):
            what = "are the same" if len(first) == len(second) else f"have the same first {rows} rows"
            yield Finding(f"{a.name}, {b.name}", None, what, "remove one: what is counted twice seems twice as certain")


def _repeats(pieces: Sequence[Demonstration], noise: dict[str, float]) -> Iterator[Finding]:
    for piece in pieces:
        for first, last, earlier in repeats(piece, [n for n, std in noise.items() if std > 0]):
            yield Finding(
                piece.name, (first, last), f"they repeat those from row {earlier} on to the last digit",
                "remove them (a piece before, a piece behind; `ichain cut` does it): nothing was measured there",
            )  # fmt: skip


def runs_of(true: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First and last index of each stretch of true values, from shape (n,)."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], true.astype(int), [0]])))
    return [(int(a), int(b) - 1) for a, b in edges.reshape(-1, 2)]


def _frozen(
    pieces: Sequence[Demonstration], graph: InteractionGraph, noise: dict[str, float], chosen: QualitySettings
) -> Iterator[Finding]:
    """Stretches in which readings that have noise don't change at all, though none is at a bound.

    What has no noise may rest; but no body makes up for its rest with one leap as far as it would have come meanwhile.
    """
    for obj, space in graph.objects.items():
        noisy = any(noise.get(column(obj, v), 0.0) > 0 for v in space.observable.names)
        seen = [_steps(p, obj, space.observable, noise if noisy else None) for p in pieces]
        total, repeated = sum(len(s.still) for s in seen), sum(int(s.still.sum()) for s in seen)
        for piece, s in zip(pieces, seen, strict=True):
            for first, last in runs_of(s.still):
                rows = last + 1 - first
                leaps = not noisy and rows + 1 >= chosen.frozen and _leaps(s.places, first, last)
                if leaps or (noisy and beyond_chance(rows, repeated, total)):
                    yield Finding(
                        piece.name, (first, last + 1),
                        f"no reading of {obj} changes for {rows * TICK:.3g} s"
                        + (", not even by noise: a frozen feed" if noisy else ", then it leaps: a frozen feed"),
                        "cut these rows out (a piece before, a piece behind), or record it again",
                    )  # fmt: skip


def beyond_chance(rows: int, repeated: int, total: int) -> bool:
    """Whether so many rows that repeat the one before, in a row, are less probable than once in the square of all.

    Readings of a coarse sensor repeat themselves more often than those of a fine one.

    Args:
        rows: in a row.
        repeated: rows that repeat the one before, anywhere; these among them.
        total: of all rows.
    """
    rate = (1.0 + repeated - rows) / (2.0 + total - rows)
    return bool(rows * np.log(rate) < -2.0 * np.log(max(total, 1)))


@dataclass(frozen=True, eq=False)
class _Steps:
    """Of an object in a piece, from row to row.

    Attributes:
        still: whether nothing changes that is not at a bound, shape (n_rows - 1,).
        places: changes of its positions, shape (n_positions, n_rows - 1).
    """

    still: NDArray[np.bool_]
    places: FloatArray


def _steps(piece: Demonstration, obj: str, space: StateSpace, noise: dict[str, float] | None) -> _Steps:
    """Of the readings that have noise, or of all where `noise` is None."""
    watched = [v for v in space.variables if column(obj, v.name) in piece.table]
    if noise is not None:
        watched = [v for v in watched if noise.get(column(obj, v.name), 0.0) > 0]
    if not watched:
        return _Steps(np.zeros(0, dtype=bool), np.zeros((0, 0)))
    values = [as_numbers(piece.table[column(obj, v.name)]) for v in watched]
    steps = np.array([np.abs(space_step(v, x)) for v, x in zip(watched, values, strict=True)])
    bound = [((x == v.lower) | (x == v.upper))[1:] & (noise is not None) for v, x in zip(watched, values, strict=True)]
    places = [v.role is not None and v.role.kind == "position" for v in watched]
    return _Steps((steps == 0).all(axis=0) & ~np.any(bound, axis=0), steps[places])


def space_step(variable: Variable, values: FloatArray) -> FloatArray:
    """Changes from row to row, shape (n_rows - 1,), angles the short way round."""
    steps = np.diff(values)
    return wrap_angle(steps) if variable.kind == "angle" else steps


def _leaps(steps: FloatArray, first: int, last: int) -> bool:
    """Whether a body moves up to a rest, and then in one row half as far as it usually does in so many, or further.

    As far as it went in no three rows elsewhere is far enough: who drives to and fro comes less far in a long rest.

    Args:
        steps: of its positions, shape (n_positions, n_rows - 1).
        first, last: of the steps that are 0.
    """
    if first == 0 or last + 1 == steps.shape[1]:
        return False
    usual = np.array([np.median(s[s > 0]) if (s > 0).any() else np.inf for s in steps])
    elsewhere = np.delete(steps, last + 1, axis=1).max(axis=1)
    leap = np.minimum(0.5 * (last + 2 - first) * usual, 3 * elsewhere)
    return bool(((steps[:, first - 1] > 0.5 * usual) & (steps[:, last + 1] > leap)).any())


def _constant(pieces: Sequence[Demonstration], graph: InteractionGraph) -> Iterator[Finding]:
    """Readings that are the same in every row of every piece."""
    for obj, space in graph.objects.items():
        for name in (column(obj, v) for v in space.observable.names):
            shown = [as_numbers(p.table[name]) for p in pieces if name in p.table]
            if shown and np.ptp(np.concatenate(shown)) == 0:
                yield Finding(
                    "", None, f"{name} is {shown[0][0]:.6g} in every row",
                    "record pieces in which it changes, or see that it is measured at all",
                )  # fmt: skip


def rest_limits(
    pieces: Sequence[Demonstration], graph: InteractionGraph, noise: dict[str, float], settings: QualitySettings
) -> dict[str, float]:
    """How much each column may change while it rests: by its noise, and a small part of its range."""
    limits = {}
    for name in dict.fromkeys(n for p in pieces for n in p.table.columns if n != TIME):
        values = np.concatenate([as_numbers(p.table[name]) for p in pieces if name in p.table])
        limits[name] = settings.rest * np.sqrt(2.0) * noise.get(name, 0.0) + settings.grid * float(np.ptp(values))
    return limits


def idle_rows(piece: Demonstration, limits: dict[str, float], settings: QualitySettings) -> NDArray[np.bool_]:
    """Rows within a stretch in which nothing moves beyond its limit and no flag changes, shape (n_rows,)."""
    ticks = max(1, round(settings.idle_window / TICK))
    idle = np.zeros(len(piece), dtype=bool)
    if len(piece) <= ticks:
        return idle
    rest = np.ones(len(piece) - ticks, dtype=bool)
    for name, limit in limits.items():
        if name in piece.table:
            window = np.lib.stride_tricks.sliding_window_view(as_numbers(piece.table[name]), ticks + 1)
            rest &= np.ptp(window, axis=1) <= limit
    for start in np.flatnonzero(rest):
        idle[start : start + ticks + 1] = True
    return idle


def _idle(pieces: Sequence[Demonstration], limits: dict[str, float], chosen: QualitySettings) -> Iterator[Finding]:
    for piece in pieces:
        share = float(idle_rows(piece, limits, chosen).mean())
        if share > chosen.idle_share:
            yield Finding(
                piece.name, None, f"nothing moves in {100 * share:.0f} % of its rows",
                "cut the rest off: rows that show nothing outweigh those that do",
            )  # fmt: skip


def _flicker(
    pieces: Sequence[Demonstration], graph: InteractionGraph, limits: dict[str, float], chosen: QualitySettings
) -> Iterator[Finding]:
    """Flags that flip for a single row though neither end of the interaction moves before or after it."""
    for piece, edge in itertools.product(pieces, graph.interactions):
        if edge.name not in piece.table:
            continue
        on = as_numbers(piece.table[edge.name]) > 0.5  # noqa: PLR2004 - a flag
        still = np.ones(len(on), dtype=bool)
        for name in (column(o, v) for o in (edge.parent, edge.child) for v in graph.objects[o].observable.names):
            if name in piece.table:
                steps = np.abs(np.diff(as_numbers(piece.table[name]), prepend=np.nan, append=np.nan))
                still &= (steps[:-1] <= limits[name]) & (steps[1:] <= limits[name])
        single = [a for state in (on, ~on) for a, b in runs_of(state) if a == b and still[a]]
        if len(single) >= chosen.flickers:
            yield Finding(
                piece.name, (min(single), max(single)),
                f"the flag {edge.name} flips for single rows in which nothing moves, {len(single)} times",
                "mark it by what acts, not by a reading near its threshold",
            )  # fmt: skip


def _contradictions(
    pieces: Sequence[Demonstration], graph: InteractionGraph, noise: dict[str, float], chosen: QualitySettings
) -> Iterator[Finding]:
    """Pairs of pieces that mostly disagree about a flag where all objects are in the same state."""
    names = [column(o, v) for o, space in graph.objects.items() for v in space.observable.names]
    whole = [p for p in pieces if all(n in p.table for n in names)]
    total = sum(len(p) for p in whole)
    every = -(-total // chosen.most_rows) if total else 1
    states = [np.stack([as_numbers(p.table[n]) for n in names], axis=1)[::every] for p in whole]
    if not states:
        return
    spread = np.ptp(np.concatenate(states), axis=0)
    width = np.array([chosen.rest * noise.get(n, 0.0) for n in names]) + chosen.grid * spread + 1e-12
    for (i, a), (j, b) in itertools.combinations(enumerate(whole), 2):
        near = _near(states[i] / width, states[j] / width)
        for edge in graph.interactions if len(near) else ():
            if edge.name not in a.table or edge.name not in b.table:
                continue
            first, second = (as_numbers(p.table[edge.name])[::every] > 0.5 for p in (a, b))  # noqa: PLR2004
            against = first[near[:, 0]] != second[near[:, 1]]
            rows = np.unique(near[against, 0])
            if len(rows) >= chosen.disagree and against.mean() > 0.5:  # noqa: PLR2004 - most of them
                yield Finding(
                    f"{a.name}, {b.name}", None,
                    f"they contradict each other about {edge.name} in {len(rows) * every} rows of the same states",
                    "look at its flag in both, and correct or remove one",
                )  # fmt: skip


def _near(first: FloatArray, second: FloatArray) -> NDArray[np.intp]:
    """Pairs of rows that differ by less than 1 in every column, shape (n_pairs, 2)."""
    order = np.argsort(second[:, 0])
    low = np.searchsorted(second[order, 0], first[:, 0] - 1.0)
    high = np.searchsorted(second[order, 0], first[:, 0] + 1.0)
    pairs = []
    for row, (a, b) in enumerate(zip(low, high, strict=True)):
        close = order[a:b][(np.abs(second[order[a:b]] - first[row]) < 1.0).all(axis=1)]
        pairs.append(np.stack([np.full(len(close), row), close], axis=1))
    return np.concatenate(pairs) if pairs else np.zeros((0, 2), dtype=np.intp)
