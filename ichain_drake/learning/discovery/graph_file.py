"""A discovered graph as YAML: what a person reads, mends, and gives to a run with --graph."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from ichain_drake.errors import InputError
from ichain_drake.files import read_whole, shown, write_whole
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.discovery.edges import DiscoveredGraph
from ichain_drake.learning.discovery.labels import edge_report
from ichain_drake.state import Role, StateSpace, Variable

_MOST_BYTES = 10**6


def write_graph(found: DiscoveredGraph, file: Path, guessed: tuple[str, ...] = ()) -> None:
    """Write a graph with all that is to be known about it.

    Args:
        found: the graph.
        file: to write.
        guessed: what was guessed about variables, a line each.

    Raises:
        InputError: if it can't be written.
    """
    document: dict[str, Any] = {
        "robot": found.root,
        "objects": {n: [_plain(v) for v in s.variables] for n, s in found.spaces.items()},
        "edges": {f.edge.name: edge_report(f, found.rows) for f in found.found},
        "nothing_acts_on": list(found.free),
        "never_changes": list(found.still),
        "notes": list(found.notes),
        "rows": found.rows,
    }
    if guessed:
        document["guessed_so_confirm"] = list(guessed)
    text = yaml.safe_dump(document, sort_keys=False, allow_unicode=True, width=120)
    write_whole(file, text.encode())


def _plain(variable: Variable) -> dict[str, Any]:
    out: dict[str, Any] = {"name": variable.name, "unit": variable.unit, "kind": variable.kind}
    out |= {k: v for k in ("lower", "upper") if math.isfinite(v := float(getattr(variable, k)))}
    role = variable.role
    if role is not None:
        out["role"] = {k: v for k in ("kind", "frame", "axis", "of") if (v := getattr(role, k))}
    return out


def _read(file: Path) -> Mapping[str, Any]:
    try:
        document = yaml.safe_load(read_whole(file, "the graph", _MOST_BYTES).decode())
    except (yaml.YAMLError, UnicodeDecodeError, RecursionError, ValueError) as error:
        raise InputError(f"{shown(file)}: can't be read as YAML: {' '.join(str(error).split())[:200]}") from None
    if not isinstance(document, Mapping) or not isinstance(document.get("edges"), Mapping | list):
        raise InputError(f"{shown(file)}: is no graph: it needs a list `edges`, such as [a->b]")
    return document


def read_edges(file: Path, graph: InteractionGraph) -> InteractionGraph:
    """A system's graph with the edges of a file.

    Args:
        file: written by `ichain discover`, or any YAML with `edges`: names, or names with what is known about them.
        graph: declares the objects.

    Raises:
        InputError: if the file can't be read, or an edge can't be the graph's.
    """
    edges = [Interaction.parse(str(name)) for name in _read(file)["edges"]]
    try:
        kept = InteractionGraph(graph.objects, edges).parents
        origins = {
            n: o for n, o in graph.origins.items() if any(o.offset(graph.objects[p]) is not None for p in kept(n))
        }
        return InteractionGraph(graph.objects, edges, origins)
    except InputError as error:
        raise InputError(f"{shown(file)}: {error}") from None


def read_spaces(file: Path) -> tuple[dict[str, StateSpace], str]:
    """State spaces and robot of a file that `ichain discover` wrote and a person mended.

    Raises:
        InputError: names the object and what is wrong with it.
    """
    document = _read(file)
    spaces = {}
    objects = document.get("objects")
    if not isinstance(objects, Mapping):
        raise InputError(f"{shown(file)}: it needs `objects`, as `ichain discover` writes them")
    for name, variables in objects.items():
        try:
            spaces[str(name)] = StateSpace(str(name), tuple(_variable(v) for v in variables))
        except (TypeError, KeyError, AttributeError, ValueError) as error:
            raise InputError(
                f"{shown(file)}: {name}: {' '.join(str(error).split())[:200]}; see what discover writes"
            ) from None
    return spaces, str(document.get("robot", ""))


def _variable(entry: Mapping[str, Any]) -> Variable:
    role = entry.get("role")
    return Variable(
        name=str(entry["name"]),
        unit=str(entry.get("unit", "1")),
        lower=float(entry.get("lower", -math.inf)),
        upper=float(entry.get("upper", math.inf)),
        kind=entry.get("kind", "real"),
        role=None if role is None else Role(**{str(k): str(v) for k, v in role.items()}),  # type: ignore[arg-type]
    )
