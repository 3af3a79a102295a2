"""What runs towards a goal know, into an interaction library and out of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from ichain_drake.control.planning.skills import SkillFunction, Skills
from ichain_drake.demonstrations import Demonstration
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.library import KnownGraph, LibraryParts, load_fitting, load_graph, save_graph
from ichain_drake.runs.goals.knowledge import Knowledge, make_planner
from ichain_drake.runs.provenance import data_hash


def save_knowledge(knowledge: Knowledge, pieces: Sequence[Demonstration], library: Path | str, name: str) -> Path:
    """Save models and switching events; a designer's own skills are functions and stay where they are.

    Args:
        knowledge: learned from `pieces`.
        pieces: the demonstrations.
        library: the library's folder; made where it doesn't exist.
        name: of the scenario.

    Returns:
        The folder of the graph.

    Raises:
        InputError: if it can't be saved or written.
    """
    skills = knowledge.skills
    known = KnownGraph(
        knowledge.model, skills.activations, skills.deactivations, knowledge.robot_seconds, data_hash(pieces)
    )
    return save_graph(known, Path(library), name)


def load_knowledge(
    library: Path | str,
    name: str,
    graph: InteractionGraph,
    own_skills: Mapping[tuple[Interaction, bool], SkillFunction] | None = None,
) -> Knowledge | None:
    """What a library knows about a scenario's graph.

    Args:
        library: the library's folder.
        name: of the scenario.
        graph: its interaction graph.
        own_skills: a designer's functions, by interaction and whether they activate.

    Returns:
        None where the library has no such graph.

    Raises:
        InputError: if it is damaged or doesn't fit; see `load_graph`.
    """
    known = load_graph(Path(library), name, graph)
    return None if known is None else _knowledge(known, library, own_skills)


def load_what_fits(library: Path | str, name: str, graph: InteractionGraph) -> Knowledge | LibraryParts:
    """All that a library knows about a scenario's graph: the whole, or each interaction that fits.

    Args:
        library: the library's folder.
        name: of the scenario.
        graph: its interaction graph.

    Returns:
        A graph that was saved by this name, if it fits as a whole; otherwise what fits of all saved graphs, beside
        which the rest is learned (`run_graph` and `learn_graph` take it).

    Raises:
        InputError: if anything in it is damaged, or a graph was saved by this name and nothing of that fits.
    """
    found = load_fitting(Path(library), name, graph)
    return found if isinstance(found, LibraryParts) else _knowledge(found, library)


def _knowledge(
    known: KnownGraph,
    library: Path | str,
    own_skills: Mapping[tuple[Interaction, bool], SkillFunction] | None = None,
) -> Knowledge:
    skills = Skills(known.activations, known.deactivations, dict(own_skills or {}))
    return Knowledge(known.model, skills, make_planner(known.model), str(library), known.robot_seconds)
