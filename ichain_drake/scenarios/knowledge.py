"""What is learned from the demonstrations of an interaction graph, for all runs that share them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from threadpoolctl import threadpool_limits

from ichain_drake.control.graph.planner import GraphPlanner
from ichain_drake.control.graph.skills import SkillFunction, Skills, learn_skills
from ichain_drake.demonstrations import Demonstration
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.interaction import InteractionModel, InteractionSpec, learn_interactions
from ichain_drake.timing import TICK


@dataclass(frozen=True)
class Knowledge:
    """What runs with the same demonstrations share.

    Attributes:
        model: learned from them.
        skills: their switching events.
        planner: with this model.
        source: `demonstrations`, or the folder of the library that it was loaded from.
        robot_seconds: simulated time that recording the demonstrations took of the robot [s].
    """

    model: InteractionModel
    skills: Skills
    planner: GraphPlanner
    source: str = "demonstrations"
    robot_seconds: float = 0.0


def learn_graph(
    pieces: Sequence[Demonstration],
    graph: InteractionGraph,
    spec: InteractionSpec | None = None,
    own_skills: Mapping[tuple[Interaction, bool], SkillFunction] | None = None,
) -> Knowledge:
    """Learn models and skills from demonstrations.

    Args:
        pieces: unordered, with flags.
        graph: the interaction graph.
        spec: candidate estimators.
        own_skills: a designer's functions, by interaction and whether they activate.

    Raises:
        InputError: on demonstrations that can't be learned from; names piece, edge and remedy.
    """
    with threadpool_limits(limits=1):
        model = learn_interactions(pieces, graph, spec)
        seconds = sum((len(p) - 1) * TICK for p in pieces)
        skills = learn_skills(model, pieces, own_skills)
        return Knowledge(model, skills, GraphPlanner(model), robot_seconds=seconds)
