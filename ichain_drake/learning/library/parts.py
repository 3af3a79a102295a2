"""Every interaction of saved graphs that fits a graph at hand, one by one: the rest is left to be learned."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.blas import one_blas_thread
from ichain_drake.learning.known import KnownObject, KnownParts, typical_row
from ichain_drake.learning.library.files import graph_name, is_graph_name, item_folders
from ichain_drake.learning.library.fit import check_space, check_time
from ichain_drake.learning.library.saved_graph import SavedGraph
from ichain_drake.learning.model import InteractionModel
from ichain_drake.learning.passive import PassiveDynamics
from ichain_drake.learning.renaming import renamed, seen_by
from ichain_drake.learning.status.events import Windows


def load_parts(library: Path, name: str, graph: InteractionGraph, *, lift: bool = False) -> KnownParts:
    """Every interaction of a graph that a library's saved graphs know.

    The graph that was saved by the same name is looked at first, the others in the order of their names. An interaction
    fits if both of its ends have the same type and variables as here, with units, kinds and roles, and if whatever else
    its status looks at is here too. One between objects of the same names is preferred; otherwise it is taken where
    the types leave no choice: where two objects are of one type, it doesn't say which is which.

    Args:
        library: the library's folder.
        name: of the scenario at hand.
        graph: its interaction graph.
        lift: whether what was learned on one object holds for all of its type: then no choice is left.

    Raises:
        InputError: if there is no such library, it holds what is no part of one, or a graph in it is damaged, edited or
            of a newer format; names the file and field.
    """
    found = KnownParts(reasons=dict.fromkeys(graph.interactions, "the library knows no such interaction"))
    own = graph_name(name)
    folders = [folder for folder in item_folders(library) if is_graph_name(folder.name)]
    with one_blas_thread():  # the trial evaluations, as everywhere
        for folder in sorted(folders, key=lambda f: (f.name != own, f.name)):
            found = _with_graph(found, SavedGraph.read(folder), graph, elsewhere=folder.name != own, lift=lift)
    return found


def _with_graph(
    found: KnownParts, saved: SavedGraph, graph: InteractionGraph, *, elsewhere: bool, lift: bool
) -> KnownParts:
    theirs, folder = saved.graph(), saved.folder
    try:
        check_time(saved.manifest, str(folder))
    except InputError as error:
        return replace(found, reasons={e: str(error) for e in found.reasons})
    known = saved.known(theirs)
    reasons = dict(found.reasons)
    for edge in [e for e in graph.interactions if e not in found.edges]:
        try:
            match = _counterpart(edge, graph, theirs, folder, lift=lift)
            if match is None:
                continue
            names = _names(edge, match, known, graph, folder)
        except InputError as error:
            reasons[edge] = str(error)
            continue
        reasons.pop(edge, None)
        found = _with_edge(found, edge, match, names, known, graph, folder, elsewhere=elsewhere)
    return replace(found, reasons=reasons)


def _counterpart(
    edge: Interaction, graph: InteractionGraph, theirs: InteractionGraph, folder: Path, *, lift: bool
) -> Interaction | None:
    """The saved interaction that an interaction here is; None where there is none between such types.

    Where all of a type are alike (`lift`), it is the first of those between such types.

    Raises:
        InputError: if the one of the same name doesn't fit, or the types leave a choice; says what.
    """
    if edge in theirs.interactions:
        for end in (edge.parent, edge.child):
            check_space(theirs.objects[end], graph.objects[end].observable, f"{folder}: {end}")
        return edge
    alike = [e for e in theirs.interactions if _fits(e, edge, theirs, graph)]
    if lift or not alike:
        return next(iter(alike), None)
    rivals = [e for e in graph.interactions if any(_fits(a, e, theirs, graph) for a in alike)]
    if len(alike) > 1 or len(rivals) > 1:
        raise InputError(
            f"{folder}: {', '.join(e.name for e in alike)} may be any of {', '.join(e.name for e in rivals)}, "
            "which have the same types; give objects here the names that they have in the library, or lift what was "
            "learned on one to all of its type"
        )
    return alike[0]


def _fits(saved: Interaction, here: Interaction, theirs: InteractionGraph, graph: InteractionGraph) -> bool:
    pairs = ((saved.parent, here.parent), (saved.child, here.child))
    return all(_same_space(theirs, old, graph, new) for old, new in pairs)


def _same_space(theirs: InteractionGraph, old: str, graph: InteractionGraph, new: str) -> bool:
    try:
        check_space(theirs.objects[old], graph.objects[new].observable, "")
    except InputError:
        return False
    return True


def _names(
    edge: Interaction, match: Interaction, model: InteractionModel, graph: InteractionGraph, folder: Path
) -> dict[str, str]:
    """Counterparts here of the objects of a saved graph, by their names there, as far as there are any.

    Raises:
        InputError: if the interaction's status looks at an object that has none.
    """
    theirs = model.graph
    names = {match.parent: edge.parent, match.child: edge.child}
    for old in theirs.objects:
        if old in names:
            continue
        alike = [n for n in graph.objects if n not in names.values() and _same_space(theirs, old, graph, n)]
        if old in alike:
            names[old] = old
        elif len(alike) == 1 and old not in graph.objects:
            names[old] = alike[0]
    lacking = sorted(seen_by(model.edges[match]) - set(names))
    # Only the states of the child and its parents are there when a status is decided.
    lacking += sorted(n for n in seen_by(model.edges[match]) & set(names) if not _is_near(names[n], edge, graph))
    if lacking:
        raise InputError(
            f"{folder}: {match.name}: its status also looks at {lacking[0]}, which doesn't act on {edge.child} here"
        )
    return names


def _is_near(obj: str, edge: Interaction, graph: InteractionGraph) -> bool:
    return obj in (edge.child, *graph.parents(edge.child))


def _with_edge(
    found: KnownParts,
    edge: Interaction,
    match: Interaction,
    names: Mapping[str, str],
    model: InteractionModel,
    graph: InteractionGraph,
    folder: Path,
    *,
    elsewhere: bool,
) -> KnownParts:
    near = {old: new for old, new in names.items() if old in (match.parent, match.child) or _is_near(new, edge, graph)}
    learned = renamed(model.edges[match], near, graph)
    learned = replace(learned, examples=renamed(model.edges[match], names, graph).examples)
    ends = {edge.parent: match.parent, edge.child: match.child}
    objects = {new: _about(model, old, graph, new) for new, old in ends.items() if new not in found.objects}
    return replace(
        found,
        edges={**found.edges, edge: learned},
        objects={**found.objects, **objects},
        elsewhere=(*found.elsewhere, *([edge] if elsewhere else [])),
        activations={**found.activations, **_windows(model.activations, match, edge)},
        deactivations={**found.deactivations, **_windows(model.deactivations, match, edge)},
        sources={**found.sources, edge: str(folder) + ("" if match == edge else f": {match.name}")},
        robot_seconds={**found.robot_seconds, edge: model.robot_seconds},
    )


def _windows(saved: Windows, match: Interaction, edge: Interaction) -> Windows:
    return {edge: saved[match]} if match in saved else {}


def _about(model: InteractionModel, old: str, graph: InteractionGraph, new: str) -> KnownObject:
    rows = np.vstack([states[old] for states in _demonstrated(model)])
    passive = model.passive.get(old)
    return KnownObject(
        None if passive is None else PassiveDynamics(graph.objects[new].observable, passive.variables),
        model.low[old],
        model.high[old],
        model.step_limit[old],
        model.noise[old],
        typical_row(rows),
    )


def _demonstrated(model: InteractionModel) -> Iterator[Mapping[str, np.ndarray]]:
    for learned in model.edges.values():
        yield learned.examples.active
        yield learned.examples.inactive
