"""Parts of a graph that are copies of each other: calculated as one batch, whatever their objects are called.

A scene of a hundred boxes of one sort has one learned box. Asked box by box, a tick costs as many calls as there are
boxes; asked once, with a row a box, it costs about one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.passive import PassiveDynamics
from ichain_drake.learning.status.status import StatusModel
from ichain_drake.learning.tick import LearnedInteraction
from ichain_drake.state import BoolArray, FloatArray

Flags = Mapping[Interaction, BoolArray]

_COPIES = 16
"""From so many on copies are calculated as one batch; of fewer nothing is gained."""


@dataclass(frozen=True)
class Part:
    """One strongly connected component of a graph, with what acts on it.

    Attributes:
        members: in the graph's order.
        objects: members and their parents, each at the same place in every copy.
        edges: incoming interactions of the members, the same.
    """

    members: tuple[str, ...]
    objects: tuple[str, ...]
    edges: tuple[Interaction, ...]


Group = tuple[Part, ...]
"""Parts that are copies of the first; one alone where it has none."""


def groups_of(
    graph: InteractionGraph,
    incoming: Mapping[str, Sequence[Interaction]],
    learned: Mapping[Interaction, LearnedInteraction],
    passive: Mapping[str, PassiveDynamics],
) -> list[Group]:
    """Parts of a graph in an order in which each comes after all that acts on it, copies of each other together.

    Copies share the very same fitted models (see `renamed`). Fewer than `_COPIES` stay by themselves.

    Args:
        graph: the interaction graph.
        incoming: interactions that act on each object, in the order in which their effects are added.
        learned: what was learned about each interaction.
        passive: passive dynamics of each object but the robots.
    """
    depth, found = dict.fromkeys(graph.roots, 0), dict[Any, list[Part]]()
    for members in graph.components:
        if members[0] in graph.roots:
            continue
        edges = tuple(e for n in members for e in incoming[n])
        part = Part(members, tuple(dict.fromkeys([*members, *(e.parent for e in edges)])), edges)
        level = 1 + max(depth[n] for n in part.objects if n not in members)
        depth |= dict.fromkeys(members, level)
        found.setdefault((level, _kind(part, learned, passive)), []).append(part)
    ordered = sorted(found.items(), key=lambda item: item[0][0])
    return [
        group
        for _, parts in ordered
        for group in ([tuple(parts)] if len(parts) >= _COPIES else [(part,) for part in parts])
    ]


def _kind(
    part: Part, learned: Mapping[Interaction, LearnedInteraction], passive: Mapping[str, PassiveDynamics]
) -> tuple[Any, ...]:
    """What is equal for copies alone: identities of models, and which of the part's objects they look at."""
    place = {name: k for k, name in enumerate(part.objects)}
    return (
        *(id(passive[n]) for n in part.members),
        *(
            (place[e.parent], place[e.child], *map(id, learned[e].effects), _plain(learned[e].status, place))
            for e in part.edges
        ),
    )


def _plain(value: Any, place: Mapping[str, int]) -> Any:
    """A status or an input of it with places in the part in place of names, and numbers for what is compared."""
    if isinstance(value, Interaction):
        return place[value.parent], place[value.child]
    if isinstance(value, str):
        return place.get(value, value)
    if isinstance(value, tuple):
        return tuple(_plain(v, place) for v in value)
    if isinstance(value, StatusModel) or hasattr(value, "label"):
        told = ((f.name, getattr(value, f.name)) for f in fields(value) if f.name != "label")
        return (type(value), *((name, _plain(v, place)) for name, v in told))
    return value if isinstance(value, bool | int | float) else id(value)


def uniform(group: Group, *flags: Flags) -> Iterator[Group]:
    """The group in parts of which flags say something about the same interactions."""
    if len(group) == 1:
        yield group
        return
    found: dict[tuple[bool, ...], list[Part]] = {}
    for part in group:
        found.setdefault(tuple(e in given for given in flags for e in part.edges), []).append(part)
    yield from map(tuple, found.values())


def _stacked_states(group: Group, states: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
    """States of all copies below each other under the first's names, shape (n_copies * n, n_variables)."""
    names = zip(*(part.objects for part in group), strict=True)
    return {own[0]: np.concatenate([states[n] for n in own]) for own in names if own[0] in states}


def _stacked_flags(group: Group, flags: Flags) -> dict[Interaction, BoolArray]:
    """The same for flags of interactions, shape (n_copies * n,)."""
    edges = zip(*(part.edges for part in group), strict=True)
    return {own[0]: np.concatenate([flags[e] for e in own]) for own in edges if own[0] in flags}


def advance_copies(
    advance: Callable[..., None],
    group: Group,
    rows: Mapping[str, FloatArray],
    after: dict[str, FloatArray],
    forced: Flags,
    before: Flags,
    on: dict[Interaction, BoolArray],
) -> None:
    """`InteractionModel.advance_component` of all copies at once.

    Args:
        advance: that method.
        group: the copies; flags say something about the same interactions of each (see `uniform`).
        rows, after, forced, before, on: as there, for the copies' own names.
    """
    first = group[0]
    if len(group) == 1:
        advance(first.members, rows, after, forced, before, on)
        return
    known, flags = _stacked_states(group, after), dict[Interaction, BoolArray]()
    given = _stacked_flags(group, forced), _stacked_flags(group, before)
    advance(first.members, _stacked_states(group, rows), known, *given, flags)
    for k, name in enumerate(first.members):
        after.update(zip((part.members[k] for part in group), _parts(known[name], len(group)), strict=True))
    for k, edge in enumerate(first.edges):
        on.update(zip((part.edges[k] for part in group), _parts(flags[edge], len(group)), strict=True))


def _parts(values: Any, count: int) -> Any:
    """Rows of each copy, shape (count, n, ...)."""
    return values.reshape(count, -1, *values.shape[1:])
