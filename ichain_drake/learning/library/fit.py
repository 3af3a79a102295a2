"""Whether a saved link is for the objects at hand: the same variables, units, kinds and roles, period and targets."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.learning.library.manifest import TIME_CONVENTION
from ichain_drake.state import StateSpace, Variable
from ichain_drake.timing import TICK

_HINT = "learn this link anew or use another library"
_ANEW = "learn the graph anew or use another library"


def check_fit(
    manifest: Mapping[str, Any],
    saved: tuple[StateSpace, StateSpace],
    here: tuple[StateSpace, StateSpace],
    targets: Sequence[str],
    where: str,
) -> None:
    """Refuse a link that is not for these objects.

    Bounds are not compared: nothing that was learned depends on them. Roles are: features are built from them.

    Args:
        manifest: of the link.
        saved: state spaces of parent and child from it.
        here: those of the graph, observable variables only.
        targets: the child's variables that wanted states will name.
        where: the link's folder, for errors.

    Raises:
        InputError: names the variable or field that differs.
    """
    check_time(manifest, where)
    for end, old, new in zip(("parent", "child"), saved, here, strict=True):
        check_space(old, new, f"{where}: {end}")
    if manifest["targets"] != list(targets):
        raise InputError(
            f"{where}: targets: its inverse models bring about {', '.join(manifest['targets'])} of {here[1].type}, "
            f"here {', '.join(targets)} are wanted; {_HINT}"
        )


def check_graph(manifest: Mapping[str, Any], saved: InteractionGraph, here: InteractionGraph, where: str) -> None:
    """Refuse a saved graph that is not this one: other objects, interactions or variables. Their order is no matter.

    Args:
        manifest: of the graph.
        saved: the graph that it describes.
        here: the graph at hand.
        where: the graph's folder, for errors.

    Raises:
        InputError: names the object, interaction, variable or field that differs.
    """
    check_time(manifest, where)
    for what, old, new in (
        ("object", list(saved.objects), list(here.objects)),
        ("interaction", [e.name for e in saved.interactions], [e.name for e in here.interactions]),
    ):
        for name in (*old, *new):
            if name not in new:
                raise InputError(f"{where}: {what} {name}: this graph doesn't have it; {_ANEW}")
            if name not in old:
                raise InputError(f"{where}: {what} {name}: the library's graph doesn't know it; {_ANEW}")
    for name, space in here.objects.items():
        check_space(saved.objects[name], space.observable, f"{where}: {name}")


def check_time(manifest: Mapping[str, Any], where: str) -> None:
    """Refuse what was learned at another period, or by another convention of time.

    Args:
        manifest: of a link or graph.
        where: begins the error.

    Raises:
        InputError: names the field.
    """
    if abs(manifest["period"] - TICK) > 1e-9 * TICK:
        raise InputError(
            f"{where}: period: it was learned at {manifest['period']:.6g} s, this version runs at {TICK:.6g} s; {_HINT}"
        )
    if manifest["time"] != TIME_CONVENTION:
        raise InputError(f"{where}: time: its convention is {manifest['time']!r:.80}; {_HINT}")


def check_space(saved: StateSpace, here: StateSpace, where: str) -> None:
    """Refuse a saved state space that is not that of the object here; bounds are not compared.

    Args:
        saved: from the library.
        here: the object's, observable variables only.
        where: begins the error.

    Raises:
        InputError: names the variable that differs.
    """
    if saved.type != here.type:
        raise InputError(f"{where}: type: it is {saved.type}, here it is {here.type}; use a link between these types")
    where = f"{where} {here.type}: variable"
    for name in (*saved.names, *here.names):
        if name not in saved.names:
            raise InputError(f"{where} {name}: the library's link doesn't know it; {_HINT}")
        if name not in here.names:
            raise InputError(f"{where} {name}: the graph's object doesn't have it; {_HINT}")
    for old, new in zip(saved.variables, here.variables, strict=True):
        if old.name != new.name:
            raise InputError(f"{where} {old.name}: {new.name} stands in its place; {_HINT}")
        for attribute, was, now in (
            ("unit", old.unit, new.unit),
            ("kind", old.kind, new.kind),
            ("role", _role(old), _role(new)),
        ):
            if was != now:
                raise InputError(f"{where} {old.name}: its {attribute} is {was} in the library, {now} here; {_HINT}")


def _role(variable: Variable) -> str:
    role = variable.role
    if role is None:
        return "none"
    named = (("frame", role.frame), ("axis", role.axis), ("of", role.of))
    return " ".join([role.kind, *(f"{name} {value!r}" for name, value in named if value)])
