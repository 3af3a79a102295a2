"""The learned graph: learned objects wired like the world, for prediction, planning and gradients."""

from ichain_drake.learned_graph.adapter import SingleGroupAdapter_
from ichain_drake.learned_graph.autodiff import evaluate
from ichain_drake.learned_graph.component import LearnedComponent_
from ichain_drake.learned_graph.graph import LearnedGraph, build_learned_graph
from ichain_drake.learned_graph.object import LearnedObject_
from ichain_drake.learned_graph.reference import ActiveCycleError, LearnedGraphReference, combine, sweep_order
from ichain_drake.learned_graph.root import GivenRoot_

__all__ = [
    "ActiveCycleError",
    "GivenRoot_",
    "LearnedComponent_",
    "LearnedGraph",
    "LearnedObject_",
    "LearnedGraphReference",
    "SingleGroupAdapter_",
    "build_learned_graph",
    "combine",
    "evaluate",
    "sweep_order",
]
