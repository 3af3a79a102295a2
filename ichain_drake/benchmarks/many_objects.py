"""How cost grows with the number of objects: a learned graph of copies of one machine, advanced by a tick."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ichain_drake.benchmarks.chain_length import synthetic_chain
from ichain_drake.benchmarks.measure import line_fit, seconds_a_call
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learned_graph import LearnedGraph, LearnedGraphReference
from ichain_drake.learning import InteractionModel
from ichain_drake.learning.chain.chain import LearnedLink
from ichain_drake.learning.renaming import renamed
from ichain_drake.state import FloatArray

BATCH = 64
"""Rows of the batch: as many as a search tries out at a time."""

_CALLS = 2


def copies(model: InteractionModel, count: int) -> InteractionModel:
    """One learned graph of many copies of a machine that share the robot, and the frozen models.

    Args:
        model: of the machine, learned for goals.
        count: how many copies.
    """
    root, members = model.graph.root, [n for n in model.graph.objects if n != model.graph.root]
    names = [{root: root, **{n: f"{n}.{k}" for n in members}} for k in range(count)]
    of = {new: old for own in names for old, new in own.items()}
    wired = [(e, Interaction(own[e.parent], own[e.child]), own) for own in names for e in model.graph.interactions]
    graph = InteractionGraph({new: model.graph.objects[old] for new, old in of.items()}, [new for _, new, _ in wired])
    place = {e: k for k, e in enumerate(model.order)}
    return replace(
        model,
        graph=graph,
        edges={new: renamed(model.edges[old], own, graph) for old, new, own in wired},
        passive={new: model.passive[old] for new, old in of.items() if old != root},
        low={new: model.low[old] for new, old in of.items()},
        high={new: model.high[old] for new, old in of.items()},
        step_limit={new: model.step_limit[old] for new, old in of.items()},
        noise={new: model.noise[old] for new, old in of.items()},
        order=tuple(new for _, new, _ in sorted(wired, key=lambda w: place[w[0]])),
        activations={},
        deactivations={},
    )


def start_of(model: InteractionModel, rows: int) -> dict[str, FloatArray]:
    """States in the middle of what was shown, each object's own way, shape (rows, n_variables)."""
    return {n: np.repeat((0.5 * (model.low[n] + model.high[n]))[None], rows, axis=0) for n in model.graph.objects}


def benchmark_objects(
    machine: InteractionModel, link: LearnedLink, objects: Sequence[int], repeats: int
) -> dict[str, Any]:
    """Time of one tick of a learned graph against its number of objects.

    Args:
        machine: a small learned graph; copies of it make up the large ones.
        link: of which chains of that length are made, for the reference of what follows paths.
        objects: numbers of objects, the robot not counted: multiples of the machine's, or the nearest below.
        repeats: rounds.

    Returns:
        `objects` there were, `ms` of processor time by what was measured, and `fit`: a line, in ms an object.
    """
    size = len(machine.graph.objects) - 1
    rows: dict[str, list[float]] = {key: [] for key in ("step", "step_batch", "diagram", "chain")}
    counts = [max(1, n // size) for n in objects]
    for count in counts:
        model = copies(machine, count)
        for key, batch in (("step", 1), ("step_batch", BATCH)):
            now = start_of(model, batch)
            step = functools.partial(
                model.step, now, now[model.graph.root], previous=model.active(now), strict=False
            )  # fmt: skip
            rows[key].append(1000.0 * seconds_a_call(step, repeats, _CALLS))
        rows["diagram"].append(_diagram_ms(model, repeats))
        rows["chain"].append(_chain_ms(link, count * size, repeats))
    made = [count * size for count in counts]
    return {"objects": made, "batch": BATCH, "ms": rows, "fit": {k: line_fit(made, v) for k, v in rows.items()}}


def _diagram_ms(model: InteractionModel, repeats: int) -> float:
    graph, now = LearnedGraph(model), start_of(model, 1)
    context = graph.CreateDefaultContext()
    graph.set_states(context, {n: s[0] for n, s in now.items()})
    graph.GetInputPort(model.graph.root).FixValue(context, now[model.graph.root][0])

    def tick() -> None:
        after = graph.EvalUniquePeriodicDiscreteUpdate(context)
        context.get_mutable_discrete_state().SetFrom(after)

    return 1000.0 * seconds_a_call(tick, repeats, _CALLS)


def _chain_ms(link: LearnedLink, objects: int, repeats: int) -> float:
    chain = synthetic_chain(link, objects + 1)
    graph = LearnedGraphReference(chain.graph, {known.interaction: known.forward.model for known in chain.links})
    now = {n: np.array([[0.1, -0.2]]) for n in chain.names}
    return 1000.0 * seconds_a_call(lambda: graph.tick(now, now[chain.graph.root]), repeats, _CALLS)
