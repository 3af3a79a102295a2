"""What was learned, into an interaction library and out of it: links of chains and whole graphs alike."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ichain_drake.learning import InteractionModel, KnownParts
from ichain_drake.learning.library import load_command, load_fitting, load_links, save_chain, save_graph
from ichain_drake.scenarios.base import PathScenario


def save(model: InteractionModel, library: str | Path, name: str) -> list[Path]:
    """Save what was learned; a designer's own skills are functions and stay where they are.

    A chain is saved link by link, for all chains with such a link; a graph as a whole, of which other graphs take what
    fits them.

    Args:
        model: learned from demonstrations; of a chain, links that came from a library are copied from there.
        library: the library's folder; made where it doesn't exist.
        name: of the scenario.

    Returns:
        The folders that hold it.

    Raises:
        InputError: if it can't be saved or written.
    """
    if model.chain is None:
        return [save_graph(model, Path(library), name)]
    return save_chain(model.chain, library, name, model.demonstrations_sha256)


def load(library: str | Path, scenario: Any, *, lift: bool = False) -> InteractionModel | KnownParts:
    """All that a library knows about a scenario's graph.

    Args:
        library: the library's folder.
        scenario: whose graph it is, and whose name.
        lift: graphs: whether what was learned on one object holds for all of its type (one button, ten buttons).

    Returns:
        A graph that was saved by the scenario's name, if it fits as a whole. Otherwise the interactions that fit, of
        all saved graphs, or a chain's links; `learn` takes them and learns the rest.

    Raises:
        InputError: if there is no such library, anything in it is damaged, or a graph was saved by this name and
            nothing of that fits.
    """
    if not isinstance(scenario, PathScenario):
        return load_fitting(Path(library), scenario.name, scenario.graph, lift=lift)
    names = scenario.graph.chain(scenario.target)
    links = load_links(library, scenario.graph, names, scenario.target_variables)
    return KnownParts(links=links, command=load_command(library, scenario.graph, names))
