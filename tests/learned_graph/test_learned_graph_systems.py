"""Structure of the learned graph: ports, wiring, clock, cycles, and what is refused."""

import importlib.util
import inspect
import sys
from dataclasses import replace

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, InputPortIndex, OutputPortIndex
from pydrake.systems.primitives import ConstantVectorSource
from small_models import CART, HAND, STICK, chain, cycle, learn, stick_step

from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learned_graph import ActiveCycleError, LearnedGraph, build_learned_graph, sweep_order
from ichain_drake.learned_graph.members import LinkedMembers
from ichain_drake.learned_graph.transition import ObjectTransition
from ichain_drake.state import StateSpace
from ichain_drake.timing import TICK


def port_names(learned: LearnedGraph) -> tuple[list[str], list[str]]:
    return (
        [learned.get_input_port(i).get_name() for i in range(learned.num_input_ports())],
        [learned.get_output_port(i).get_name() for i in range(learned.num_output_ports())],
    )


def connections(learned: LearnedGraph) -> set[tuple[str, str, str, str]]:
    return {
        (
            a.get_name(),
            a.get_output_port(OutputPortIndex(o)).get_name(),
            b.get_name(),
            b.get_input_port(InputPortIndex(i)).get_name(),
        )
        for (b, i), (a, o) in learned.connection_map().items()
    }


def test_ports_and_wiring_mirror_the_graph() -> None:
    learned = build_learned_graph(*chain())
    inputs, outputs = port_names(learned)
    assert inputs == ["hand"]
    assert outputs == [
        "hand.state", "hand.next_state",
        "stick.state", "stick.next_state", "stick.active",
        "cart.state", "cart.next_state", "cart.active",
    ]  # fmt: skip
    assert connections(learned) == {
        ("hand", "next_state", "stick", "hand"),
        ("hand", "state", "stick", "hand.now"),
        ("stick", "next_state", "cart", "stick"),
        ("stick", "state", "cart", "stick.now"),
    }
    assert learned.GetOutputPort("cart.state").size() == len(CART.observable) == len(CART) - 1


def test_only_a_component_reads_active() -> None:
    graph, models = cycle()
    learned = build_learned_graph(graph, models)
    wires = connections(learned)
    for edge in graph.interactions:  # the same wires as without a cycle
        assert (edge.parent, "next_state", edge.child, edge.parent) in wires
    assert {w for w in wires if w[1] == "active"} == {
        ("a", "active", "component:a,b", "a.active"),
        ("b", "active", "component:a,b", "b.active"),
    }


def test_state_has_no_feedthrough_and_next_state_has() -> None:
    learned = build_learned_graph(*chain())
    through = {n for i, n in enumerate(port_names(learned)[1]) if learned.HasDirectFeedthrough(i)}
    assert through == {"hand.next_state", "stick.next_state", "cart.next_state"}


@pytest.mark.parametrize("make", [chain, cycle])
def test_there_is_one_clock(make) -> None:
    timing = build_learned_graph(*make()).GetUniquePeriodicDiscreteUpdateAttribute()
    assert (timing.period_sec(), timing.offset_sec()) == (TICK, 0.0)


def test_default_states_are_clipped_and_all_is_active() -> None:
    space = StateSpace("cup", (replace(STICK.variables[0], lower=0.25), STICK.variables[1]))
    graph = InteractionGraph({"hand": HAND, "cup": space}, ["hand->cup"])
    learned = build_learned_graph(graph, {graph.interactions[0]: learn(space, HAND, stick_step)})
    context = learned.CreateDefaultContext()
    assert learned.states(context)["cup"].tolist() == [0.25, 0.0]
    assert learned.GetOutputPort("cup.active").Eval(context).tolist() == [1.0]


def test_set_active_touches_only_what_is_named() -> None:
    graph, models = cycle()
    learned = build_learned_graph(graph, models)
    context = learned.CreateDefaultContext()
    learned.set_active(context, {Interaction("hand", "a"): False})
    assert learned.GetOutputPort("a.active").Eval(context).tolist() == [1.0, 0.0]  # declared: b->a, hand->a
    assert learned.GetOutputPort("b.active").Eval(context).tolist() == [1.0, 1.0]
    learned.set_active(context, {Interaction("hand", "a"): True})
    assert learned.GetOutputPort("a.active").Eval(context).tolist() == [1.0, 1.0]


def test_active_cycle_names_edges_and_time() -> None:
    graph, models = cycle()
    learned = build_learned_graph(graph, models)
    simulator = Simulator(learned)
    context = simulator.get_mutable_context()
    learned.get_input_port().FixValue(context, np.zeros(2))
    learned.set_active(context, {Interaction("a", "b"): False})
    simulator.AdvanceTo(1.5 * TICK)
    learned.set_active(context, {Interaction("a", "b"): True})
    with pytest.raises(
        ActiveCycleError, match=r"form a cycle at t = 0\.667 s: (a->b, b->a|b->a, a->b); deactivate"
    ) as caught:
        simulator.AdvanceTo(2.5 * TICK)
    assert "b->c" not in str(caught.value)  # behind the cycle, not in it


def test_sweep_order_follows_the_active_interactions_only() -> None:
    edges = [Interaction("a", "b"), Interaction("outside", "a")]
    assert sweep_order(["b", "a"], edges) == ["a", "b"]
    assert sweep_order(["b", "a"], []) == ["b", "a"]
    with pytest.raises(ActiveCycleError, match="form a cycle: "):
        sweep_order(["b", "a"], [*edges, Interaction("b", "a")])


def test_models_must_be_those_of_the_graph() -> None:
    graph, models = chain()
    first, second = graph.interactions
    with pytest.raises(InputError, match="no model for stick->cart"):
        build_learned_graph(graph, {first: models[first]})
    with pytest.raises(InputError, match="model for hand->cart, which"):
        build_learned_graph(graph, models | {Interaction("hand", "cart"): models[second]})
    with pytest.raises(
        InputError, match="model of stick->cart, parent: learned for the variables x, y, the graph has a, b"
    ):
        build_learned_graph(graph, models | {second: replace(models[second], parent_space=HAND)})
    with pytest.raises(InputError, match="model of hand->stick, child: type rod is not stick"):
        build_learned_graph(
            graph, models | {first: replace(models[first], child_space=StateSpace("rod", STICK.variables))}
        )
    moved = StateSpace("stick", (STICK.variables[0], replace(STICK.variables[1], unit="deg")))
    with pytest.raises(InputError, match="model of hand->stick, child: variable b is declared otherwise"):
        build_learned_graph(graph, models | {first: replace(models[first], child_space=moved)})


def test_a_learned_object_needs_a_model() -> None:
    with pytest.raises(InputError, match="learned object stick: it has no incoming interaction"):
        LinkedMembers([ObjectTransition("stick", STICK, {})])


def test_bad_states_and_names_are_refused() -> None:
    graph, models = chain()
    with pytest.raises(InputError, match="initial state of ball; objects are"):
        build_learned_graph(graph, models, {"ball": np.zeros(2)})
    with pytest.raises(InputError, match="learned graph, stick: initial state: b is not a finite"):
        build_learned_graph(graph, models, {"stick": np.array([0.0, np.nan])})
    with pytest.raises(InputError, match=r"learned graph, hand: initial state: shape \(3,\)"):
        build_learned_graph(graph, models, {"hand": np.zeros(3)})
    learned = build_learned_graph(graph, models)
    context = learned.CreateDefaultContext()
    with pytest.raises(InputError, match="state of cart: shape"):
        learned.set_states(context, {"cart": np.zeros(5)})  # the hidden variable is no part of it
    with pytest.raises(InputError, match="no object 'ball'"):
        learned.set_states(context, {"ball": np.zeros(2)})
    with pytest.raises(InputError, match="no interaction hand->cart; it has hand->stick, stick->cart"):
        learned.set_active(context, {Interaction("hand", "cart"): True})


def test_states_can_be_read_and_set_inside_another_diagram() -> None:
    graph, models = chain()
    builder = DiagramBuilder()
    learned = builder.AddSystem(build_learned_graph(graph, models))
    builder.Connect(builder.AddSystem(ConstantVectorSource([0.1, 0.2])).get_output_port(), learned.get_input_port())
    root = builder.Build()
    own = learned.GetMyMutableContextFromRoot(root.CreateDefaultContext())
    learned.set_states(own, {"cart": np.array([1.0, 2.0, 0.5, 0.1])})
    assert learned.states(own)["cart"].tolist() == [1.0, 2.0, 0.5, 0.1]
    assert learned.GetOutputPort("hand.next_state").Eval(own).tolist() == [0.1, 0.2]


@pytest.mark.parametrize("make", [chain, cycle])
def test_next_state_follows_every_change_of_the_context(make) -> None:
    graph, models = make()
    learned = build_learned_graph(graph, models)
    context = learned.CreateDefaultContext()
    first = next(e for e in graph.interactions if e.parent == "hand")
    learned.set_active(context, {Interaction("b", "a"): False} if make is cycle else {})
    port = learned.GetOutputPort(f"{first.child}.next_state")
    seen = []

    def look() -> None:
        seen.append(tuple(port.Eval(context)))

    learned.get_input_port().FixValue(context, [0.1, 0.2])
    look()
    learned.get_input_port().FixValue(context, [0.5, 0.6])
    look()
    learned.set_states(context, {"hand": np.array([0.7, 0.8]), first.child: np.array([0.3, 0.4])})
    look()
    learned.set_active(context, {first: False})
    look()
    assert len(set(seen)) == 4
    assert seen[-1] == (0.3, 0.4)  # kept


@pytest.mark.parametrize("name", ["adapter", "component", "object", "root"])
def test_importing_a_template_searches_no_call_stack(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """For a template without a scope, or made at import, pydrake looks for each frame's file in every module."""
    file = importlib.import_module(f"ichain_drake.learned_graph.{name}").__file__
    spec = importlib.util.spec_from_file_location("copy_of_a_template", file)
    copy = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, spec.name, copy)
    monkeypatch.setattr(inspect, "stack", lambda *_: pytest.fail("the call stack is searched"))
    spec.loader.exec_module(copy)
