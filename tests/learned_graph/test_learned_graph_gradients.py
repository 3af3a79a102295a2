"""Derivatives through the learned graph, and Drake's own tools on top of them."""

from collections.abc import Callable

import numpy as np
import pytest
from pydrake.autodiffutils import AutoDiffXd, ExtractGradient, ExtractValue, InitializeAutoDiff
from pydrake.common.value import Value
from pydrake.planning import DirectTranscription
from pydrake.solvers import Solve
from pydrake.systems.framework import DiagramBuilder, LeafSystem
from pydrake.systems.primitives import FirstOrderTaylorApproximation, Integrator, Linearize, ZeroOrderHold
from small_models import CART, chain, cycle

from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction
from ichain_drake.learned_graph import LearnedGraph, LearnedObject_, SingleGroupAdapter_, build_learned_graph
from ichain_drake.learned_graph.members import LinkedMembers
from ichain_drake.learned_graph.transition import ObjectTransition
from ichain_drake.state import FloatArray

HAND = np.array([0.4, -0.3])
RNG = np.random.default_rng(11)


def make_learned(make: Callable) -> LearnedGraph:
    graph, models = make()
    rng = np.random.default_rng(2)
    return build_learned_graph(
        graph, models, {n: rng.uniform(0.1, 0.5, len(s.observable)) for n, s in graph.objects.items()}
    )


def without_cycle(learned: LearnedGraph):
    context = learned.CreateDefaultContext()
    edge = Interaction("a", "b")
    if edge in learned.graph.interactions:
        learned.set_active(context, {edge: False})
    learned.get_input_port().FixValue(context, HAND)
    return context


def tick(learned: LearnedGraph, context, vector: FloatArray) -> FloatArray:
    """States (all objects) at t + 1 from (states at t, hand at t + 1), through the float diagram."""
    context = context.Clone()
    n = len(vector) - len(HAND)
    learned.set_states(context, {name: vector[:n][part] for name, part in learned.slices.items()})
    learned.get_input_port().FixValue(context, vector[n:])
    context.SetDiscreteState(learned.EvalUniquePeriodicDiscreteUpdate(context))
    return np.concatenate(list(learned.states(context).values()))


def test_object_gradient_is_that_of_the_forward_model() -> None:
    graph, models = chain()
    edge = graph.interactions[1]
    system = LearnedObject_[AutoDiffXd](
        "cart", LinkedMembers([ObjectTransition("cart", CART.observable, {"stick": models[edge]})])
    )
    state, now, after = RNG.uniform(0.1, 0.6, 4), RNG.uniform(-0.5, 0.5, 2), RNG.uniform(-0.5, 0.5, 2)
    x = InitializeAutoDiff(np.concatenate([state, now, after])).ravel()
    context = system.CreateDefaultContext()
    context.SetDiscreteState(0, x[:4])
    system.GetInputPort("stick.now").FixValue(context, x[4:6])
    system.GetInputPort("stick").FixValue(context, x[6:])
    result = system.GetOutputPort("next_state").Eval(context)
    _, by_child, by_parent, by_next = models[edge].linearize(state[None], now[None], after[None])
    expected = np.concatenate([by_child[0], by_parent[0], by_next[0]], axis=1)
    np.testing.assert_allclose(ExtractGradient(result), expected, rtol=1e-13, atol=1e-15)
    assert np.array_equal(ExtractValue(result).ravel(), models[edge].predict_row(state, now, after))


@pytest.mark.parametrize("make", [chain, cycle])
def test_graph_gradient_equals_finite_differences(make) -> None:
    learned = make_learned(make)
    context = without_cycle(learned)
    vector = np.concatenate([*learned.states(context).values(), HAND])
    adapter = learned.single_group(context)
    flat = adapter.CreateDefaultContext()
    flat.SetDiscreteState(0, vector[: -len(HAND)])
    adapter.get_input_port().FixValue(flat, HAND)
    linear = FirstOrderTaylorApproximation(adapter, flat)
    gradient = np.concatenate([linear.A(), linear.B()], axis=1)
    step = 1e-6
    for i in range(len(vector)):
        offset = step * np.eye(len(vector))[i]
        slope = (tick(learned, context, vector + offset) - tick(learned, context, vector - offset)) / (2 * step)
        np.testing.assert_allclose(gradient[:, i], slope, rtol=1e-6, atol=1e-8)
    hand = learned.slices["hand"]
    assert np.abs(np.delete(linear.B(), np.arange(hand.start, hand.stop), axis=0)).max() > 0.1


@pytest.mark.parametrize("make", [chain, cycle])
def test_autodiff_diagram_has_the_same_values(make) -> None:
    learned = make_learned(make)
    context = without_cycle(learned)
    expected = tick(learned, context, np.concatenate([*learned.states(context).values(), HAND]))
    converted = learned.ToAutoDiffXd()
    own = converted.CreateDefaultContext()
    own.SetTimeStateAndParametersFrom(context)
    converted.GetInputPort("hand").FixValue(own, InitializeAutoDiff(HAND).ravel())
    parts = [converted.GetOutputPort(f"{n}.next_state").Eval(own) for n in learned.graph.objects]
    values = np.concatenate([ExtractValue(p).ravel() for p in parts])
    assert np.array_equal(values, expected)
    assert converted.GetUniquePeriodicDiscreteUpdateAttribute() is not None


def test_single_group_moves_like_the_graph() -> None:
    learned = make_learned(cycle)
    context = without_cycle(learned)
    adapter = learned.single_group(context)
    flat = adapter.CreateDefaultContext()
    adapter.get_input_port().FixValue(flat, HAND)
    vector = np.concatenate(list(learned.states(context).values()))
    assert np.array_equal(adapter.get_output_port().Eval(flat), vector)
    for _ in range(5):
        vector = tick(learned, context, np.concatenate([vector, HAND]))
        flat.SetDiscreteState(adapter.EvalUniquePeriodicDiscreteUpdate(flat))
        assert np.array_equal(adapter.get_output_port().Eval(flat), vector)


def test_linearize_accepts_the_single_group_at_a_fixed_point() -> None:
    learned = make_learned(cycle)
    context = learned.CreateDefaultContext()
    learned.set_active(context, dict.fromkeys(learned.graph.interactions, False))
    learned.set_states(context, {"hand": HAND})
    adapter = learned.single_group(context)
    flat = adapter.CreateDefaultContext()
    adapter.get_input_port().FixValue(flat, HAND)
    linear = Linearize(adapter, flat)
    hand = learned.slices["hand"]
    expected = np.eye(len(linear.A()))
    expected[hand, hand] = 0.0
    assert np.array_equal(linear.A(), expected)  # nothing is active: all but the hand stays
    assert np.array_equal(linear.B()[hand], np.eye(2))


def test_direct_transcription_reaches_a_goal() -> None:
    graph, models = chain()
    learned = build_learned_graph(graph, models, {"cart": np.array([0.0, 0.0, 0.0, 0.5])})
    adapter = learned.single_group()
    ticks = 8
    goal = np.array([0.6, 0.3])
    transcription = DirectTranscription(adapter, adapter.CreateDefaultContext(), ticks)
    program = transcription.prog()
    begin = adapter.CreateDefaultContext().get_discrete_state(0).CopyToVector()
    program.AddBoundingBoxConstraint(begin, begin, transcription.initial_state())
    cart = learned.slices["cart"]
    program.AddBoundingBoxConstraint(goal, goal, transcription.final_state()[cart][:2])
    transcription.AddConstraintToAllKnotPoints(transcription.input()[0] <= 0.9)
    transcription.AddConstraintToAllKnotPoints(transcription.input()[0] >= -0.9)
    hand = transcription.input()
    transcription.AddRunningCost(hand[0] ** 2 + hand[1] ** 2)
    result = Solve(program)
    assert result.is_success()
    states = begin  # the plan, run through the learned graph
    context = learned.CreateDefaultContext()
    commands = transcription.GetInputSamples(result).T
    for command in commands[: ticks - 1]:
        states = tick(learned, context, np.concatenate([states, command]))
    np.testing.assert_allclose(states[cart][:2], goal, atol=1e-4)
    assert np.abs(commands).max() <= 0.9 + 1e-6


def test_single_group_refuses_what_it_can_not_flatten() -> None:
    with pytest.raises(InputError, match="continuous or abstract state"):
        SingleGroupAdapter_[float](Integrator(1))
    builder = DiagramBuilder()
    for period in (0.1, 0.2):
        hold = builder.AddSystem(ZeroOrderHold(period, 1))
        builder.ExportInput(hold.get_input_port())
    with pytest.raises(InputError, match="several clocks or none"):
        SingleGroupAdapter_[float](builder.Build())

    class Abstract(LeafSystem):
        def __init__(self) -> None:
            super().__init__()
            self.DeclareDiscreteState(1)
            self.DeclareAbstractInputPort("pose", Value("text"))
            self.DeclarePeriodicDiscreteUpdateEvent(0.1, 0.0, lambda context, discrete: None)

    with pytest.raises(InputError, match="input pose is no vector"):
        SingleGroupAdapter_[float](Abstract())


def test_single_group_takes_other_systems_too() -> None:
    builder = DiagramBuilder()
    first, second = builder.AddSystem(ZeroOrderHold(0.1, 1)), builder.AddSystem(ZeroOrderHold(0.1, 1))
    builder.Connect(first.get_output_port(), second.get_input_port())
    builder.ExportInput(first.get_input_port(), "u")
    adapter = SingleGroupAdapter_[float](builder.Build())
    context = adapter.CreateDefaultContext()
    adapter.GetInputPort("u").FixValue(context, [3.0])
    for expected in ([3.0, 0.0], [3.0, 3.0]):
        context.SetDiscreteState(adapter.EvalUniquePeriodicDiscreteUpdate(context))
        assert adapter.GetOutputPort("state").Eval(context).tolist() == expected
