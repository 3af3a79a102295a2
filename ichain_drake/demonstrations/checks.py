"""What a table must be before anything is learned from it: columns, units, values, times."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ichain_drake.demonstrations.columns import COMMAND, TIME, Piece, as_numbers, column
from ichain_drake.demonstrations.plausible import check_plausible
from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.timing import TICK

TIME_TOLERANCE = 0.05
"""How far from the library's period the time between two rows may be [periods]."""

_TIME_WORDS = {
    "t", "time", "timestamp", "timestamps", "seconds", "sec", "secs", "stamp", "datetime", "time_s", "time_ms",
    "global_time",
    "timestamp_s", "timestamp_ms", "timestamp_us", "timestamp_ns", "time_stamp", "t_sec", "elapsed", "elapsed_time",
}  # fmt: skip
_FRAME_WORDS = {"frame", "frame_id", "frame_index", "frame_number", "frame_no", "step", "timestep", "time_step"}
_TRACK_WORDS = {
    "id", "vehicle_id", "track_id", "trackid", "agent_id", "episode_index", "episode_id", "episode", "trajectory_id",
    "traj_id", "demo", "trial",
}  # fmt: skip
_LEROBOT = {"episode_index", "frame_index", "timestamp"}


def known_units(graph: InteractionGraph) -> dict[str, str]:
    """Unit of every column that a table may have beside flags, by its name."""
    known = {TIME: "s"}
    known |= {column(o, v.name): v.unit for o, s in graph.objects.items() for v in s.observable.variables}
    return known | {column(COMMAND, v.name): v.unit for v in graph.command.variables}


def check_columns(demo: Piece, graph: InteractionGraph, objects: Sequence[str] | None) -> None:
    """Check which columns there are, and their units; see `Demonstration.check`.

    Raises:
        InputError: names the table and the column.
    """
    unknown = [o for o in objects or () if o not in graph.objects]
    if unknown:
        raise InputError(f"{demo.name}: there is no object {unknown[0]!r}; objects are {', '.join(graph.objects)}")
    if COMMAND in graph.objects:
        raise InputError(f"{demo.name}: {COMMAND!r} stands for the hand's commands; give that object another name")
    if TIME not in demo.table:
        raise InputError(f"{demo.name}: {_without_time(demo)}")
    doubled = demo.table.columns[demo.table.columns.duplicated()]
    if len(doubled):
        raise InputError(f"{demo.name}: column {doubled[0]} appears twice; remove one")
    known = known_units(graph)
    flags = {e.name for e in graph.interactions}
    for name in demo.table.columns:
        if name in flags:
            continue
        if "->" in name:
            raise InputError(f"{demo.name}: {name} is no interaction of the graph; it has {', '.join(sorted(flags))}")
        if name not in known:
            raise InputError(f"{demo.name}: column {name} is no measured variable; known are {', '.join(known)}")
        unit = demo.units.get(name, known[name])
        if unit != known[name]:
            raise InputError(f"{demo.name}: column {name} is in {unit}, but {known[name]} is needed; convert it")
    for obj in (*graph.objects, COMMAND):
        wanted = (graph.command if obj == COMMAND else graph.objects[obj].observable).names
        present = [v for v in wanted if column(obj, v) in demo.table]
        if (present or obj in (objects or ())) and len(present) != len(wanted):
            lost = next(v for v in wanted if v not in present)
            raise InputError(f"{demo.name}: column {column(obj, lost)} is missing")
    if not any(demo.has(o, s) for o, s in graph.objects.items()):
        raise InputError(f"{demo.name}: holds no object of the graph; its objects are {', '.join(graph.objects)}")


def _without_time(demo: Piece) -> str:
    """What to do about a table without times."""
    names = [str(c) for c in demo.table.columns]
    if set(names) >= _LEROBOT:
        return (
            f"column {TIME} is missing: this is a table of LeRobot; read its data set by `ichain import lerobot DIR "
            "--map MAP.yaml -o DEMOS --resample`"
        )
    likely = next((n for n in names if n.lower() in _TIME_WORDS), None)
    frames = next((n for n in names if n.lower() in _FRAME_WORDS), None)
    if likely is None and frames is not None:
        what = f"make it of {frames}, divided by the rate of the recording: "
    else:
        what = f"rename {likely}, if that is " if likely else "give "
    several = next((n for n in names if n.lower() in _TRACK_WORDS and demo.table[n].nunique() > 1), None)
    apart = "" if several is None else f"; rows of each {several} need a file of their own"
    return (
        f"column {TIME} is missing; {what}the time of each row in seconds, or name its unit ({TIME} [ms]){apart} "
        f"(its columns are {_few(names)})"
    )


def _few(names: Sequence[str]) -> str:
    return ", ".join(names[:4]) + (", ..." if len(names) > 4 else "")


def check_values(demo: Piece, graph: InteractionGraph) -> None:
    """Check the numbers in a table; see `Demonstration.check`.

    Raises:
        InputError: names the table, the line and the column.
    """
    if len(demo.table) < 2:
        raise InputError(f"{demo.name}: {len(demo.table)} rows; a piece needs at least 2")
    for name in demo.table.columns:
        values = as_numbers(demo.table[name])
        bad = ~np.isfinite(values)
        if bad.any():
            row = int(np.argmax(bad))
            several = demo.table[name].isna().mean() > 0.5  # noqa: PLR2004 - most rows
            raise InputError(
                f"{demo.name}: line {demo.first_line + row}, column {name}: not a finite number; remove the row or "
                "mend it" + (", or take rows of several rates together with --resample" if several else "")
            )
        odd = ~np.isin(values, (0.0, 1.0))
        if "->" in name and odd.any():
            row = int(np.argmax(odd))
            raise InputError(
                f"{demo.name}: line {demo.first_line + row}, column {name}: {values[row]:g} given; an active flag is "
                "0 or 1"
            )
    check_times(demo)
    check_plausible(demo, graph)


def check_times(demo: Piece) -> None:
    """Check that times ascend by the library's period.

    Raises:
        InputError: with the line, the period that was measured, and the way on.
    """
    steps = np.diff(as_numbers(demo.table[TIME]))
    way = "--resample (in Python `resample`) takes it to 3 Hz and splits it at gaps"
    if (steps <= 0).any():
        row = int(np.argmax(steps <= 0)) + 1
        what = "a doubled time" if steps[row - 1] == 0 else "a time before the previous one"
        raise InputError(
            f"{demo.name}: line {demo.first_line + row}, column {TIME}: {what}; sort by time and remove doubles, or "
            f"{way}"
        )
    off = np.abs(steps - TICK) > TIME_TOLERANCE * TICK
    if off.any():
        row = int(np.argmax(off)) + 1
        usual = float(np.median(steps))
        raise InputError(
            f"{demo.name}: line {demo.first_line + row}, column {TIME}: {steps[row - 1]:.4g} s since the previous row, "
            f"{TICK:.4g} s needed (the median is {usual:.4g} s, {1 / usual:.3g} Hz): {way}"
        )
