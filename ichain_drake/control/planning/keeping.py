"""What a robot can keep hold of while another one acts: an object that would not stay if it were let go of.

Held where it is wanted, it makes an interaction possible that is not while it is where it goes by itself: a lid that is
kept open, a switch that is kept pressed. How it is held is a demonstrated state of the two.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ichain_drake.control.planning.borders import active_samples
from ichain_drake.control.planning.model import Batch, is_change, span
from ichain_drake.control.planning.plan import Condition
from ichain_drake.control.planning.simulate import settle
from ichain_drake.control.planning.travel import parked_state
from ichain_drake.control.settings import PLANNING
from ichain_drake.graph import Interaction
from ichain_drake.learning.model import InteractionModel
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import BoolArray, FloatArray


@dataclass(frozen=True, eq=False)
class KeepOption:
    """An object that a robot keeps hold of.

    Attributes:
        edge: from the robot to the object.
        enables: the interaction that is possible then, and is not once the object is let go of.
        robot: state of the robot, shape (n_root,).
        child: state of the object there, shape (n_child,).
    """

    edge: Interaction
    enables: Interaction
    robot: FloatArray
    child: FloatArray


def find_keeps(model: InteractionModel) -> tuple[KeepOption, ...]:
    """What the robot can keep hold of for others; nothing where it is the only one.

    Args:
        model: the learned graph, as the robot sees it (`InteractionModel.acting`).
    """
    graph, found = model.graph, list[KeepOption]()
    if len(graph.roots) == 1:
        return ()
    for edge in graph.interactions:
        samples = active_samples(model, edge)
        if edge.parent != graph.root or not len(samples[edge.child]):
            continue
        away = parked_state(model, {n: v[0] for n, v in samples.items()})
        rest = settle(model, samples, away)[0][edge.child]
        if not _moves(model, edge.child, samples[edge.child], rest).mean() > PLANNING.likely:
            continue
        for other in graph.interactions:
            if graph.by_robot(other) or edge.child not in (other.child, *graph.parents(other.child)):
                continue
            shown = active_samples(model, other)
            if not len(shown[edge.child]):
                continue
            sure = np.median(_decide(model, other, edge.child, shown, samples[edge.child]), axis=1)
            free = _decide(model, other, edge.child, shown, rest)
            if sure.max() >= 0.0 and (free >= 0.0).mean() <= 1.0 - PLANNING.likely:
                best = int(np.argmax(sure))
                found.append(KeepOption(edge, other, samples[edge.parent][best], samples[edge.child][best]))
    return tuple(found)


def _moves(model: InteractionModel, obj: str, held: FloatArray, free: FloatArray) -> BoolArray:
    """Whether an object clearly goes somewhere else when it is let go of, shape (n,), from states (n, n_variables)."""
    off = np.abs(model.graph.objects[obj].observable.difference(free, held))
    clear = np.maximum(LEARNING.near * span(model, obj), LEARNING.surely * model.noise[obj])
    return np.asarray((off > clear)[:, ~is_change(model, obj)].any(axis=1))


def _decide(model: InteractionModel, edge: Interaction, obj: str, shown: Batch, places: FloatArray) -> FloatArray:
    """Decision values in demonstrated states with an object in each of several states, shape (n_places, n_shown)."""
    count = len(shown[obj])
    batch = {n: np.tile(v, (len(places), 1)) for n, v in shown.items()}
    batch[obj] = np.repeat(places, count, axis=0)
    return model.decide(edge, batch).reshape(len(places), count)


def missing_hand(model: InteractionModel, condition: Condition) -> str:
    """Why one robot alone can't meet a condition, in words; empty where it might, or there are several.

    What drives the variable was active only while something else was held that goes away by itself: the one that holds
    it can't hold what drives as well.

    Args:
        model: the learned graph.
        condition: of the goal.
    """
    graph = model.graph
    if len(graph.roots) > 1:
        return ""
    index = graph.objects[condition.object].observable.index(condition.variable)
    for edge in graph.incoming(condition.object):
        shown = active_samples(model, edge)
        drives = any(f.variable == index for f in model.edges[edge].effects)
        if graph.by_robot(edge) or not drives or not len(shown[edge.child]):
            continue
        away = settle(model, shown, parked_state(model, {n: v[0] for n, v in shown.items()}))[0]
        for obj in graph.parents(edge.child):
            held = Interaction(graph.root, obj)
            if obj == edge.parent or held not in graph.edges:
                continue
            goes = _moves(model, obj, shown[obj], away[obj]).mean() > PLANNING.likely
            if goes and (model.decide(edge, {**shown, obj: away[obj]}) < 0.0).mean() > PLANNING.likely:
                return (
                    f"{edge.name} was active only while a robot kept {obj} from going back by itself, and "
                    f"{graph.root} can't hold {obj} and {edge.parent} at once"
                )
    return ""
