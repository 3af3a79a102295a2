"""Loading learned links from an interaction library, for the graph at hand."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from pathlib import Path

from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.chain.chain import LearnedLink
from ichain_drake.learning.chain.command import LearnedCommand
from ichain_drake.learning.library.files import link_folders, link_name
from ichain_drake.learning.library.saved import SavedLink
from ichain_drake.state import StateSpace


def _spaces(graph: InteractionGraph, edge: Interaction) -> tuple[StateSpace, StateSpace]:
    for end in (edge.parent, edge.child):
        if end not in graph.objects:
            raise InputError(f"{edge.name}: there is no object {end!r}; objects are {', '.join(graph.objects)}")
    return graph.objects[edge.parent].observable, graph.objects[edge.child].observable


def load_link(
    folder: Path, graph: InteractionGraph, edge: Interaction, targets: Sequence[int]
) -> tuple[LearnedLink, LearnedCommand | None]:
    """Load one link for an interaction of a graph. Versions of Python, Drake and scikit-learn don't matter.

    Args:
        folder: the link's folder.
        graph: the interaction graph.
        edge: the interaction.
        targets: indices of the child's observable variables that wanted states will name.

    Returns:
        The link with the library as its `source`, and what was learned about commanding the hand, if it holds that.

    Raises:
        InputError: if the link is damaged, edited, of a newer format, or not for this interaction: names the file, the
            field or the variable that differs.
    """
    parent, child = _spaces(graph, edge)
    saved = SavedLink.read(folder)
    saved.check_fit(parent, child, [child.names[i] for i in targets])
    origin = graph.origin_for(edge)
    saved.check_origin(edge, origin)
    return saved.link(edge, parent, child, origin), saved.command(parent, origin)


def load_links(
    library: str | Path, graph: InteractionGraph, names: Sequence[str], targets: Sequence[str]
) -> dict[str, LearnedLink]:
    """Load every link of a chain that a library has; those that it lacks are left out.

    Args:
        library: the library's folder.
        graph: the interaction graph.
        names: objects along the chain, robot first.
        targets: the last object's variables that goals name.

    Returns:
        Links by interaction name (`learn_chain` takes them as `known`).

    Raises:
        InputError: if there is no such library, it holds what is no part of one, or a link between the same types
            can't be used; see `load_link`.
    """
    library = Path(library)
    present = {folder.name for folder in link_folders(library)}
    links = {}
    for parent, child in itertools.pairwise(names):
        edge = Interaction(parent, child)
        parent_space, space = _spaces(graph, edge)
        name = link_name(parent_space.type, space.type)
        if name in present:
            wanted = space.indices(targets) if child == names[-1] else range(len(space))
            links[edge.name] = load_link(library / name, graph, edge, [int(i) for i in wanted])[0]
    return links


def load_command(library: str | Path, graph: InteractionGraph, names: Sequence[str]) -> LearnedCommand | None:
    """What a library's first link of a chain knows about commanding the hand.

    Args:
        library: the library's folder.
        graph: the interaction graph.
        names: objects along the chain, robot first.

    Returns:
        None where the library has no such link, or it holds nothing of it.

    Raises:
        InputError: if that link is damaged, or for another robot; see `load_link`.
    """
    library = Path(library)
    edge = Interaction(names[0], names[1])
    parent, child = _spaces(graph, edge)
    name = link_name(parent.type, child.type)
    if name not in {folder.name for folder in link_folders(library)}:
        return None
    saved = SavedLink.read(library / name)
    saved.check_fit(parent, child, saved.manifest["targets"])
    origin = graph.origin_for(edge)
    saved.check_origin(edge, origin)
    return saved.command(parent, origin)
