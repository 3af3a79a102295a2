"""What was learned for goals, or about a chain, as a Drake Diagram: the model's own steps to the last bit; slopes."""

from dataclasses import replace

import numpy as np
import pytest
from linked_library import CHAIN
from pydrake.autodiffutils import ExtractGradient, ExtractValue, InitializeAutoDiff
from pydrake.systems.framework import Context
from small_job import GRAPH, QUICK
from small_world import pieces, states_of

from ichain_drake.errors import ActiveCycleError
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learned_graph import LearnedGraph
from ichain_drake.learning import InteractionModel, KnownParts, learn_interactions
from ichain_drake.state import FloatArray

LIGHT, BACK = Interaction("valve", "lamp"), Interaction("lamp", "valve")


@pytest.fixture(scope="module")
def model() -> InteractionModel:
    return learn_interactions(pieces(), GRAPH, QUICK)


@pytest.fixture(scope="module")
def ring(model: InteractionModel) -> InteractionModel:
    """With a way back from the lamp to the valve, which is active as seldom as the way there."""
    back = replace(model.edges[LIGHT], effects=())
    graph = InteractionGraph(GRAPH.objects, [*GRAPH.interactions, BACK])
    return replace(model, graph=graph, edges=model.edges | {BACK: back}, order=(*model.order, BACK))


def at(learned: LearnedGraph, states: dict[str, FloatArray]) -> Context:
    context = learned.CreateDefaultContext()
    learned.set_states(context, states)
    return context


def active(learned: LearnedGraph, context: Context) -> dict[Interaction, bool]:
    ports = {n: learned.GetOutputPort(f"{n}.active").Eval(context) for n in learned.graph.objects if n != "hand"}
    return {e: bool(ports[e.child][learned.graph.parents(e.child).index(e.parent)]) for e in learned.graph.interactions}


@pytest.mark.parametrize("piece", [0, 3, 5])
@pytest.mark.parametrize("cyclic", [False, True])
def test_every_tick_is_the_models_to_the_last_bit(
    model: InteractionModel, ring: InteractionModel, piece: int, cyclic: bool
) -> None:
    learned_from = ring if cyclic else model
    shown = states_of(pieces()[piece])
    states = {n: s[0] for n, s in shown.items()}
    learned = LearnedGraph(learned_from, initial=states)
    context, status = at(learned, states), None
    told = learned_from.active(states)
    assert active(learned, context) == {e: bool(v) for e, v in told.items()}
    seen = set()
    for hand in shown["hand"][1:]:
        learned.GetInputPort("hand").FixValue(context, hand)
        try:
            states, status = learned_from.step(states, hand, previous=status or told)
        except ActiveCycleError:
            with pytest.raises(ActiveCycleError, match=r"lamp->valve|valve->lamp"):
                learned.EvalUniquePeriodicDiscreteUpdate(context)
            assert cyclic
            return
        context.SetDiscreteState(learned.EvalUniquePeriodicDiscreteUpdate(context))
        for name, value in learned.states(context).items():
            np.testing.assert_array_equal(value, states[name])
        assert active(learned, context) == {e: bool(v) for e, v in status.items()}
        seen |= {e for e, v in status.items() if v}
    assert seen, "nothing was active in this piece"


def test_slopes_are_those_of_the_model(model: InteractionModel) -> None:
    shown = states_of(pieces()[0])
    flags = pieces()[0].table["hand->box"].to_numpy() > 0.5
    row = int(np.flatnonzero(flags[1:] & flags[:-1])[2])
    states, hand = {n: s[row] for n, s in shown.items()}, shown["hand"][row + 1]
    learned = LearnedGraph(model, initial=states).ToAutoDiffXd()
    context = learned.CreateDefaultContext()
    learned.GetInputPort("hand").FixValue(context, InitializeAutoDiff(hand))
    after = learned.GetOutputPort("box.next_state").Eval(context)
    wanted, status = model.step(states, hand)
    assert status[Interaction("hand", "box")]
    np.testing.assert_array_equal(ExtractValue(after).ravel(), wanted["box"])
    for k in range(3):
        moved = np.stack([hand, hand])
        moved[:, k] += [1e-4, -1e-4]
        both = {n: np.stack([s, s]) for n, s in states.items()}
        ahead, _ = model.step(both, moved, status)
        slope = (ahead["box"][0] - ahead["box"][1]) / 2e-4
        np.testing.assert_allclose(ExtractGradient(after)[:, k], slope, atol=1e-6)


def test_a_chain_is_a_model_whose_interactions_are_always_active() -> None:
    model = InteractionModel.of_chain(CHAIN, [], KnownParts())
    learned = LearnedGraph(model)
    context, links = learned.CreateDefaultContext(), CHAIN.links
    states = learned.states(context)
    root = links[0].interaction.parent
    learned.GetInputPort(root).FixValue(context, states[root] + 0.01)
    ahead, status = model.step(states, states[root] + 0.01)
    assert all(status.values())
    for name, value in ahead.items():
        np.testing.assert_allclose(learned.GetOutputPort(f"{name}.next_state").Eval(context), value, atol=1e-12)
    assert set(status) == {link.interaction for link in links} == set(model.active(states))
