"""What is learned from the demonstrations of an interaction graph, for all runs that share them."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from threadpoolctl import threadpool_limits

from ichain_drake.control.planning.planner import GraphPlanner
from ichain_drake.control.planning.skills import SkillFunction, Skills, learn_skills
from ichain_drake.demonstrations import Demonstration
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning import InteractionModel, InteractionSpec, contradicted, learn_interactions
from ichain_drake.learning.estimators.warned import collected_warnings
from ichain_drake.learning.library import LibraryParts
from ichain_drake.scenarios.base import Progress
from ichain_drake.timing import TICK

DEMONSTRATIONS = "demonstrations"


@dataclass(frozen=True)
class Knowledge:
    """What runs with the same demonstrations share.

    Attributes:
        model: learned from them.
        skills: their switching events.
        planner: with this model.
        source: `demonstrations`, or the folder of the library that all of it was loaded from.
        robot_seconds: simulated time that recording the demonstrations took of the robot [s].
        parts: what came from a library where that knew some of the graph only.
    """

    model: InteractionModel
    skills: Skills
    planner: GraphPlanner
    source: str = DEMONSTRATIONS
    robot_seconds: float = 0.0
    parts: LibraryParts = field(default_factory=LibraryParts)

    def source_of(self, edge: Interaction) -> str:
        """Where an interaction's models come from: `demonstrations`, or a folder."""
        return self.parts.sources.get(edge, self.source)

    def robot_seconds_of(self, edge: Interaction) -> float:
        """Simulated time of the robot that recording an interaction's demonstrations took, with others' [s]."""
        return self.parts.robot_seconds.get(edge, self.robot_seconds)


def make_planner(model: InteractionModel) -> GraphPlanner:
    """The planner of every run towards a goal, for what was learned or loaded: the one place to put in another."""
    return GraphPlanner(model)


def learn_graph(
    pieces: Iterable[Demonstration],
    graph: InteractionGraph,
    spec: InteractionSpec | None = None,
    own_skills: Mapping[tuple[Interaction, bool], SkillFunction] | None = None,
    parts: LibraryParts | None = None,
) -> Knowledge:
    """Learn models and skills from demonstrations.

    Args:
        pieces: unordered, with flags.
        graph: the interaction graph.
        spec: candidate estimators.
        own_skills: a designer's functions, by interaction and whether they activate.
        parts: what a library knows of the graph; the pieces need not show it (see `load_parts`).

    Raises:
        InputError: on demonstrations that can't be learned from; names piece, edge and remedy.
    """
    parts, pieces = parts or LibraryParts(), list(pieces)
    with threadpool_limits(limits=1):
        model = learn_interactions(pieces, graph, spec, parts.known)
        seconds = sum((len(p) - 1) * TICK for p in pieces)
        before = Skills(parts.activations, parts.deactivations)
        skills = learn_skills(model, pieces, own_skills, before)
        return Knowledge(model, skills, make_planner(model), robot_seconds=seconds, parts=parts)


def learn_rest(
    show: Callable[[Collection[Interaction]], Sequence[Demonstration]],
    graph: InteractionGraph,
    parts: LibraryParts,
    spec: InteractionSpec | None = None,
    own_skills: Mapping[tuple[Interaction, bool], SkillFunction] | None = None,
    say: Progress | None = None,
) -> Knowledge:
    """Learn what a library doesn't know of a graph.

    Known interactions that the demonstrations contradict are learned anew; their pieces are asked for, too.

    Args:
        show: gives the pieces that show all but some known interactions; is called anew with fewer of those where the
            pieces contradict one.
        graph: the interaction graph.
        parts: what the library knows.
        spec: candidate estimators.
        own_skills: as for `learn_graph`.
        say: called with a line at each step.

    Raises:
        InputError: as `learn_graph`.
    """
    say = say or (lambda line: None)
    if not parts.known.is_whole(graph):
        for edge, why in parts.reasons.items():
            say(f"{edge.name} is learned: {why}")
    while True:
        pieces = [] if parts.known.is_whole(graph) else show(list(parts.known.edges))
        against = contradicted(pieces, graph, parts.known)
        if not against:
            break
        for edge, why in against.items():
            say(f"{edge.name} is learned anew: {why}")
        parts = parts.without(against)
    say(f"learning from {len(pieces)} pieces" if pieces else "everything is known; nothing is learned")
    with collected_warnings(say):
        knowledge = learn_graph(pieces, graph, spec, own_skills, parts)
    for finding in knowledge.model.findings:
        say(finding)
    return knowledge
