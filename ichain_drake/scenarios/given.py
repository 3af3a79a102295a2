"""What a graph declares about its variables, as plain values for a report: nobody has to guess what was not learned."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

from ichain_drake.graph import InteractionGraph
from ichain_drake.objects.region import GATE
from ichain_drake.state import Role, Variable


def declared(graph: InteractionGraph) -> dict[str, Any]:
    """Interactions, and of each object's observable variables unit, kind, bounds and role.

    Returns:
        `interactions`, `origins` of the objects that have one, and `objects` per object and variable; an open bound is
        None, a missing role an empty text.
    """
    return {
        "interactions": [e.name for e in graph.interactions],
        "origins": {n: {"frame": o.frame, "position": list(o.position)} for n, o in graph.origins.items()},
        "objects": {
            name: {v.name: _variable(v) for v in space.observable.variables} for name, space in graph.objects.items()
        },
    }


def _variable(variable: Variable) -> dict[str, Any]:
    bounds = [b if math.isfinite(b) else None for b in (variable.lower, variable.upper)]
    return {"unit": variable.unit, "kind": variable.kind, "bounds": bounds, "role": _words(variable.role)}


def _words(role: Role | None) -> str:
    if role is None:
        return ""
    parts = [role.kind, role.axis, f"in {role.frame}" if role.frame else "", f"of {role.of}" if role.of else ""]
    return " ".join(p for p in parts if p)


def geometry(layout: Any) -> Any:
    """What a layout declares, as plain values: where things are and how large, without what decides interactions.

    Args:
        layout: a dataclass, of dataclasses too. Fields marked with the metadata `GATE`, the half-widths in which an
            interaction begins, are the simulator's alone: they are left out.
    """
    if not dataclasses.is_dataclass(layout):
        return layout
    shown = [f.name for f in dataclasses.fields(layout) if not f.metadata.get(GATE)]
    return {name: geometry(getattr(layout, name)) for name in shown}
