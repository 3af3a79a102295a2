"""What a set of demonstrations shows, piece by piece, and what is odd about it: as text, JSON and a page."""

from __future__ import annotations

import html
from collections.abc import Sequence
from typing import Any

import numpy as np

from ichain_drake.demonstrations.column_noise import column_noise
from ichain_drake.demonstrations.columns import COMMAND, TIME, as_numbers
from ichain_drake.demonstrations.quality import QualitySettings, findings, idle_rows, rest_limits
from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.state import StateSpace, Variable
from ichain_drake.timing import TICK

_UNSEEN = "no piece shows it beginning or ending"


def overview(pieces: Sequence[Demonstration], graph: InteractionGraph, refused: Sequence[str] = ()) -> dict[str, Any]:
    """What `ichain check` reports, as plain values for JSON.

    Args:
        pieces: checked demonstrations.
        graph: the interaction graph.
        refused: why other pieces of the set can't be used, a line each.

    Returns:
        `pieces`: per piece its name, rows, seconds, objects, idle share [1], and per interaction `active` (the share of
        its rows) and `begins`, `ends` (how often). `interactions`: per interaction the pieces that show it switching.
        `findings`: piece, rows, what, remedy. `refused`.
    """
    settings = QualitySettings()
    limits = rest_limits(pieces, graph, column_noise(pieces, graph), settings)
    rows: list[dict[str, Any]] = []
    for piece in pieces:
        rows.append(
            {
                "name": piece.name,
                "rows": len(piece),
                "seconds": round((len(piece) - 1) * TICK, 6),
                "objects": [o for o, space in graph.objects.items() if piece.has(o, space)],
                "idle": round(float(idle_rows(piece, limits, settings).mean()), 4),
                "interactions": {e.name: _activity(piece, e.name) for e in graph.interactions if e.name in piece.table},
            }
        )
    shown = {
        e.name: [r["name"] for r in rows if (a := r["interactions"].get(e.name)) and a["begins"] + a["ends"]]
        for e in graph.interactions
    }
    found = [
        {"piece": f.piece, "rows": None if f.rows is None else list(f.rows), "what": f.what, "remedy": f.remedy}
        for f in findings(pieces, graph, settings)
    ]
    return {"pieces": rows, "interactions": shown, "findings": found, "refused": list(refused)}


def _activity(piece: Demonstration, edge: str) -> dict[str, float]:
    on = as_numbers(piece.table[edge]) > 0.5  # noqa: PLR2004 - a flag
    steps = np.diff(on.astype(int))
    return {"active": round(float(on.mean()), 4), "begins": int((steps > 0).sum()), "ends": int((steps < 0).sum())}


def inferred_graph(pieces: Sequence[Demonstration]) -> InteractionGraph:
    """The graph that tables speak of themselves: objects by columns `object.variable`, interactions by flags.

    Kinds are guessed: what is in radians or degrees wraps, what is 0 or 1 throughout is binary. Without flags, each
    object is taken to act on the next.

    Raises:
        InputError: if there is no such column, or the flags make no graph whose robots are those that the
            command columns name, or the one that nothing acts on.
    """
    variables: dict[str, dict[str, Variable]] = {}
    flags: dict[str, None] = {}
    robots: dict[str, None] = {}
    for piece in pieces:
        for name in (str(c) for c in piece.table.columns):
            if "->" in name:
                flags[name] = None
            obj, _, variable = name.partition(".")
            if obj == COMMAND and ":" in variable:  # of several robots, each by its name
                robots[variable.partition(":")[0]] = None
            if "->" in name or not variable or "." in variable or obj in ("", COMMAND):
                continue
            unit = piece.units.get(name, "1")
            values = np.concatenate(
                [as_numbers(p.table[name]) for p in pieces if list(p.table.columns).count(name) == 1]
            )
            turns = unit in ("rad", "deg", "°")
            kind = "angle" if turns else "binary" if np.isin(values[np.isfinite(values)], (0.0, 1.0)).all() else "real"
            declared = Variable(variable, "rad" if turns else unit, kind=kind)  # type: ignore[arg-type]
            variables.setdefault(obj, {}).setdefault(variable, declared)
    if not variables:
        where = pieces[0].name if pieces else "no piece"
        raise InputError(
            f"{where}: no column is named object.variable; a table has {TIME} and such columns, as car.x [px]"
        )
    spaces = {o: StateSpace(o, tuple(v.values())) for o, v in variables.items()}
    names = list(spaces)
    edges = list(flags) or [f"{a}->{b}" for a, b in zip(names[:-1], names[1:], strict=True)]
    try:
        return InteractionGraph(spaces, edges, robots=tuple(robots))
    except InputError as error:
        raise InputError(f"the tables alone make no graph ({error}); name the system with --system") from None


def overview_text(report: dict[str, Any]) -> str:
    """The report as lines for a terminal."""
    lines = []
    for piece in report["pieces"]:
        flags = "; ".join(
            f"{edge} {100 * a['active']:.0f} % (+{a['begins']} -{a['ends']})"
            for edge, a in piece["interactions"].items()
            if a["active"] > 0
        )
        lines.append(
            f"{piece['name']}: {piece['rows']} rows, {piece['seconds']:.1f} s, idle {100 * piece['idle']:.0f} %"
            + (f"; {flags}" if flags else "")
        )
    for edge, names in report["interactions"].items():
        few = ", ".join(names[:6]) + (f" and {len(names) - 6} more" if len(names) > 6 else "")
        lines.append(f"{edge}: {'switches in ' + few if names else _UNSEEN}")
    lines += [f"refused: {line}" for line in report["refused"]]
    for found in report["findings"]:
        rows = "" if found["rows"] is None else f" rows {found['rows'][0]} to {found['rows'][1]}"
        lines.append(f"odd: {found['piece'] or 'all pieces'}{rows}: {found['what']}; {found['remedy']}")
    if not report["findings"] and not report["refused"]:
        lines.append("nothing odd was found")
    return "\n".join(lines)


_STYLE = (
    "body{font:15px/1.45 sans-serif;margin:2em auto;max-width:70em;padding:0 1em}table{border-collapse:collapse}"
    "td,th{border-bottom:1px solid #ccc;padding:.25em .7em;text-align:left;vertical-align:top}"
    "td.on{background:linear-gradient(90deg,#9bc4e2 var(--p),transparent var(--p))}.odd{color:#a33}"
)


def overview_page(report: dict[str, Any], title: str) -> bytes:
    """The report as one HTML page without scripts, that needs nothing beside it; UTF-8."""
    edges = list(report["interactions"])
    head = "".join(f"<th>{html.escape(e)}</th>" for e in ("piece", "rows", "s", "idle", *edges))
    body = ""
    for piece in report["pieces"]:
        cells = [piece["name"], piece["rows"], f"{piece['seconds']:.1f}", f"{100 * piece['idle']:.0f} %"]
        body += "<tr>" + "".join(f"<td>{html.escape(str(c))}</td>" for c in cells)
        for edge in edges:
            a = piece["interactions"].get(edge)
            text = "" if a is None else f"{100 * a['active']:.0f} % +{a['begins']} -{a['ends']}"
            share = 0 if a is None else 100 * a["active"]
            body += f'<td class="on" style="--p:{share:.0f}%">{text}</td>'
        body += "</tr>\n"
    unseen = [f"{e}: {_UNSEEN}" for e, names in report["interactions"].items() if not names]
    odd = [f"refused: {line}" for line in report["refused"]] + [
        f"{f['piece'] or 'all pieces'}{'' if f['rows'] is None else ' rows {} to {}'.format(*f['rows'])}: "
        f"{f['what']}; {f['remedy']}"
        for f in report["findings"]
    ]
    listed = "".join(f'<li class="odd">{html.escape(line)}</li>' for line in odd) or "<li>nothing odd was found</li>"
    listed += "".join(f"<li>{html.escape(line)}</li>" for line in unseen)
    page = (
        f'<!doctype html><html lang="en"><meta charset="utf-8"><title>{html.escape(title)}</title>'
        f"<style>{_STYLE}</style><h1>{html.escape(title)}</h1><ul>{listed}</ul>"
        "<p>Of each interaction: the share of rows in which it is active, how often it begins (+) and ends (-).</p>"
        f"<table><tr>{head}</tr>\n{body}</table></html>\n"
    )
    return page.encode(errors="backslashreplace")
