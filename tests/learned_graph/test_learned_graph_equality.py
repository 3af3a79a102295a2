"""The learned graph in Drake against its numpy reference: equal to the last bit."""

from collections.abc import Mapping

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, DiagramBuilder, LeafSystem
from pydrake.systems.primitives import LogVectorOutput
from small_models import HAND, LEVEL, chain, cycle, hand_path, learn, pull_step

from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learned_graph import (
    ActiveCycleError,
    LearnedGraph,
    LearnedGraphReference,
    build_learned_graph,
    combine,
    sweep_order,
)
from ichain_drake.learning.chain.models import ForwardModel
from ichain_drake.state import FloatArray
from ichain_drake.timing import TICK

TICKS = 120
POOL = {
    (parent.type, action): learn(LEVEL, parent, pull_step, action=action, seed=i)
    for i, (parent, action) in enumerate((p, a) for p in (HAND, LEVEL) for a in ("next", "current", "both"))
}


def tick(graph: LearnedGraph, context: Context, hand: FloatArray) -> dict[str, FloatArray]:
    graph.get_input_port().FixValue(context, hand)
    context.SetDiscreteState(graph.EvalUniquePeriodicDiscreteUpdate(context))
    return graph.states(context)


def tick_row(
    reference: LearnedGraphReference,
    states: Mapping[str, FloatArray],
    root_next: FloatArray,
    active: Mapping[Interaction, bool] | None = None,
) -> dict[str, FloatArray]:
    """One tick of a single row, with the one-row evaluation that learned objects call."""
    graph = reference.graph
    on = [e for e in graph.interactions if active is None or active[e]]
    after = {graph.root: np.asarray(root_next)}
    for name in sweep_order([n for n in graph.objects if n != graph.root], on):
        mine = [e for e in on if e.child == name]
        effects = [reference.models[e].predict_row(states[name], states[e.parent], after[e.parent]) for e in mine]
        after[name] = combine(graph.objects[name].observable, states[name], effects)
    return after


def assert_same(left: Mapping[str, FloatArray], right: Mapping[str, FloatArray]) -> None:
    assert left.keys() == right.keys()
    for name in left:
        assert np.array_equal(left[name], right[name]), name


def start(graph: InteractionGraph) -> dict[str, FloatArray]:
    rng = np.random.default_rng(1)
    return {n: rng.uniform(0.0, 0.5, len(s.observable)) for n, s in graph.objects.items()}


def test_chain_equals_the_reference_to_the_last_bit() -> None:
    graph, models = chain()
    learned = build_learned_graph(graph, models, start(graph))
    reference, context, states = LearnedGraphReference(graph, models), learned.CreateDefaultContext(), start(graph)
    moved = dict.fromkeys(states, 0.0)
    for hand in hand_path(TICKS):
        after = tick_row(reference, states, hand)
        assert_same(tick(learned, context, hand), after)
        for name in states:
            moved[name] = moved[name] + np.abs(after[name] - states[name]).sum()
        states = after
    assert min(moved.values()) > 1.0
    assert np.abs(states["cart"][2]) <= np.pi


def test_chain_equals_the_batch_reference() -> None:
    graph, models = chain()
    learned = build_learned_graph(graph, models, start(graph))
    context, path = learned.CreateDefaultContext(), hand_path(TICKS)
    states = [start(graph), *(tick(learned, context, hand) for hand in path)]
    before = {n: np.stack([s[n] for s in states[:-1]]) for n in graph.objects}
    after = LearnedGraphReference(graph, models).tick(before, path)
    for name in graph.objects:
        np.testing.assert_allclose(np.stack([s[name] for s in states[1:]]), after[name], rtol=0, atol=1e-12)


def test_gates_of_a_cycle_switch_the_order_of_evaluation() -> None:
    graph, models = cycle()
    learned = build_learned_graph(graph, models, start(graph))
    reference, context, states = LearnedGraphReference(graph, models), learned.CreateDefaultContext(), start(graph)
    inside = (Interaction("a", "b"), Interaction("b", "a"))
    rng, seen = np.random.default_rng(5), set()
    for hand in hand_path(TICKS):
        active = {e: bool(rng.integers(2)) for e in graph.interactions}
        if all(active[e] for e in inside):
            active[inside[rng.integers(2)]] = False
        seen.add(tuple(active.values()))
        learned.set_active(context, active)
        states = tick_row(reference, states, hand, active)
        assert_same(tick(learned, context, hand), states)
    assert len(seen) == 24  # every combination of five flags without the cycle


def test_nothing_active_keeps_every_state() -> None:
    graph, models = cycle()
    learned = build_learned_graph(graph, models, start(graph))
    context = learned.CreateDefaultContext()
    learned.set_active(context, dict.fromkeys(graph.interactions, False))
    assert_same(tick(learned, context, np.array([0.3, -0.2])), start(graph) | {"hand": np.array([0.3, -0.2])})


def test_changes_of_two_active_parents_add_up() -> None:
    graph, models = cycle()
    learned = build_learned_graph(graph, models, start(graph))
    after = {}
    for on in (("hand->b",), ("a->b",), ("hand->b", "a->b")):
        context = learned.CreateDefaultContext()
        learned.set_active(context, {e: e.name in on for e in graph.interactions})
        after[on] = tick(learned, context, np.array([0.5, 0.1]))["b"]
    first, second, both = after.values()
    was = start(graph)["b"]
    assert np.abs(first - was).max() > 1e-3 and np.abs(second - was).max() > 1e-3
    np.testing.assert_allclose(both - was, (first - was) + (second - was), rtol=1e-12, atol=1e-15)


class Playback(LeafSystem):
    """Hand states at t + 1 from a table."""

    def __init__(self, path: FloatArray) -> None:
        super().__init__()
        self.DeclareVectorOutputPort(
            "hand", path.shape[1], lambda c, out: out.SetFromVector(path[round(c.get_time() / TICK)])
        )


def test_simulator_advances_one_tick_at_a_time() -> None:
    graph, models = chain()
    path = hand_path(TICKS + 1)
    builder = DiagramBuilder()
    learned = builder.AddSystem(build_learned_graph(graph, models, start(graph)))
    builder.Connect(builder.AddSystem(Playback(path)).get_output_port(), learned.GetInputPort("hand"))
    logs = {n: LogVectorOutput(learned.GetOutputPort(f"{n}.next_state"), builder, TICK) for n in graph.objects}
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo((TICKS - 0.5) * TICK)
    reference, states = LearnedGraphReference(graph, models), start(graph)
    for k in range(TICKS):
        states = tick_row(reference, states, path[k])
        for name, log in logs.items():
            assert np.array_equal(log.FindLog(simulator.get_context()).data()[:, k], states[name]), (name, k)
    own = learned.GetMyContextFromRoot(simulator.get_context())
    assert_same(learned.states(own), states)


@st.composite
def graphs(draw: st.DrawFn) -> tuple[InteractionGraph, dict[Interaction, ForwardModel], dict[Interaction, bool]]:
    count = draw(st.integers(1, 4))
    names = draw(st.permutations(["hand", *(f"o{i}" for i in range(count))]))
    objects = {n: HAND if n == "hand" else LEVEL for n in names}
    order = ["hand", *(f"o{i}" for i in range(count))]
    first = [(order[draw(st.integers(0, i))], order[i + 1]) for i in range(count)]
    others = [(p, c) for p in order for c in order[1:] if p != c and (p, c) not in first]
    more = draw(st.lists(st.sampled_from(others), unique=True, max_size=5)) if others else []
    graph = InteractionGraph(objects, draw(st.permutations(first + more)))
    models = {
        e: POOL[objects[e.parent].type, draw(st.sampled_from(["next", "current", "both"]))] for e in graph.interactions
    }
    return graph, models, {e: draw(st.booleans()) for e in graph.interactions}


@settings(max_examples=60, deadline=None, derandomize=True, database=None)
@given(graphs(), st.lists(st.floats(-1.0, 1.0), min_size=2, max_size=2))
def test_any_graph_equals_the_reference(
    drawn: tuple[InteractionGraph, dict[Interaction, ForwardModel], dict[Interaction, bool]], hand: list[float]
) -> None:
    graph, models, active = drawn
    learned = build_learned_graph(graph, models, start(graph))
    context, reference, states = learned.CreateDefaultContext(), LearnedGraphReference(graph, models), start(graph)
    learned.set_active(context, active)
    try:
        for _ in range(3):
            states = tick_row(reference, states, np.array(hand), active)
    except ActiveCycleError:
        with pytest.raises(ActiveCycleError):
            tick(learned, context, np.array(hand))
        return
    for _ in range(3):
        result = tick(learned, context, np.array(hand))
    assert_same(result, states)
