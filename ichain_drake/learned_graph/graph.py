"""The learned graph as a Drake Diagram: the same nodes and edges as the world, predicting in place of simulating."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property

import numpy as np
from pydrake.systems.framework import Context, Diagram, DiagramBuilder, LeafSystem

from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learned_graph.adapter import SingleGroupAdapter
from ichain_drake.learned_graph.component import LearnedComponent
from ichain_drake.learned_graph.object import LearnedObject
from ichain_drake.learned_graph.root import GivenRoot
from ichain_drake.learned_graph.transition import require_same_space
from ichain_drake.learning.chain.models import ForwardModel
from ichain_drake.state import FloatArray


class LearnedGraph(Diagram):
    """Learned objects wired along the interactions, advanced once a tick; converts to AutoDiffXd.

    Systems carry the objects' names; every interaction is a connection to the child's input port of the parent's
    name, as in the world. Objects that form a cycle share a `component:<names>` for the evaluation of their next
    states (see `LearnedComponent`). One call of `EvalUniquePeriodicDiscreteUpdate` is one tick of
    `LearnedGraphReference`, equal to the last bit.

    Which interactions are active is part of the context and decided by whoever predicts (`set_active`); no
    controller or monitor reads it from here.

    Ports: input `<root>`, the robot's state at t + 1. Outputs `<object>.state`, `<object>.next_state` for every object
    and the robot, `<object>.active` for every object.

    Args:
        graph: the interaction graph.
        models: forward model of every interaction.
        initial: observable states at t = 0, by object, where they are not 0 (clipped to the bounds).

    Raises:
        InputError: if a model is missing or superfluous, or a model or state doesn't fit the graph; names which.
    """

    def __init__(
        self,
        graph: InteractionGraph,
        models: Mapping[Interaction, ForwardModel],
        initial: Mapping[str, FloatArray] | None = None,
    ) -> None:
        super().__init__()
        self.graph = graph
        self.models = {e: models[e] for e in graph.interactions if e in models}
        _check_fit(graph, models, initial or {})
        cyclic = {n: component for component in graph.components if len(component) > 1 for n in component}

        builder = DiagramBuilder()
        self._systems: dict[str, LeafSystem] = {}
        for name, declared in graph.objects.items():
            space = declared.observable
            start = (initial or {}).get(name, np.clip(np.zeros(len(space)), space.lower, space.upper))
            if name == graph.root:
                system = GivenRoot(name, space.check(start, f"learned graph, {name}: initial state"))
            else:
                incoming = {e.parent: self.models[e] for e in graph.incoming(name)}
                system = LearnedObject(name, space, incoming, start, name in cyclic)
            self._systems[name] = builder.AddNamedSystem(name, system)
        for edge in graph.interactions:
            parent, child = self.system(edge.parent), self.system(edge.child)
            builder.Connect(parent.GetOutputPort("next_state"), child.GetInputPort(edge.parent))
            builder.Connect(parent.GetOutputPort("state"), child.GetInputPort(f"{edge.parent}.now"))
        for members in dict.fromkeys(cyclic.values()):
            self._add_component(builder, members)
        builder.ExportInput(self.system(graph.root).GetInputPort("next_state"), graph.root)
        for name, system in self._systems.items():
            for port in ("state", "next_state", "active"):
                if system.HasOutputPort(port):
                    builder.ExportOutput(system.GetOutputPort(port), f"{name}.{port}")
        builder.BuildInto(self)
        self.set_name("learned_graph")

    def _add_component(self, builder: DiagramBuilder, members: tuple[str, ...]) -> None:
        component = LearnedComponent([self.system(n).transition for n in members])
        builder.AddNamedSystem(component.get_name(), component)
        parents = dict.fromkeys(p for n in members for p in self.graph.parents(n))
        for name in members:
            system = self.system(name)
            builder.Connect(system.GetOutputPort("state"), component.GetInputPort(f"{name}.now"))
            builder.Connect(system.GetOutputPort("active"), component.GetInputPort(f"{name}.active"))
            builder.Connect(component.GetOutputPort(f"{name}.next_state"), system.GetInputPort("component"))
        for name in parents:
            if name not in members:
                builder.Connect(self.system(name).GetOutputPort("state"), component.GetInputPort(f"{name}.now"))
                builder.Connect(self.system(name).GetOutputPort("next_state"), component.GetInputPort(name))

    def system(self, name: str) -> LeafSystem:
        """The system of an object or of the robot.

        Raises:
            InputError: if there is none of that name.
        """
        if name not in self._systems:
            raise InputError(f"the learned graph has no object {name!r}; it has {', '.join(self._systems)}")
        return self._systems[name]

    def states(self, context: Context) -> dict[str, FloatArray]:
        """States of the robot and of every object, shape (n_variables,) each.

        Args:
            context: of this diagram.
        """
        return {
            n: s.GetOutputPort("state").Eval(self.GetSubsystemContext(s, context)) for n, s in self._systems.items()
        }

    def set_states(self, context: Context, states: Mapping[str, FloatArray]) -> None:
        """Set states, such as measured ones to predict from.

        Args:
            context: of this diagram.
            states: by object, shape (n_variables,) each; those not named stay.

        Raises:
            InputError: on an unknown object, a wrong shape or a value that is not finite; names it.
        """
        for name, value in states.items():
            system = self.system(name)
            checked = self.graph.objects[name].observable.check(value, f"learned graph, state of {name}")
            self.GetMutableSubsystemContext(system, context).SetDiscreteState(0, checked)

    def set_active(self, context: Context, active: Mapping[Interaction, bool]) -> None:
        """Set which interactions are in effect in the coming ticks.

        Args:
            context: of this diagram.
            active: those not named stay as they are.

        Raises:
            InputError: on an unknown interaction.
        """
        for edge, flag in active.items():
            if edge not in self.models:
                known = ", ".join(e.name for e in self.models)
                raise InputError(f"the learned graph has no interaction {edge.name}; it has {known}")
            mine = self.GetMutableSubsystemContext(self.system(edge.child), context)
            values = mine.get_discrete_state(1).CopyToVector()
            values[self.graph.parents(edge.child).index(edge.parent)] = float(flag)
            mine.SetDiscreteState(1, values)

    @cached_property
    def slices(self) -> dict[str, slice]:
        """Where each object's state lies in the state vector of `single_group`, by object, the robot's too."""
        ends = np.cumsum([0, *(len(s.observable) for s in self.graph.objects.values())])
        return {n: slice(int(a), int(b)) for n, a, b in zip(self.graph.objects, ends[:-1], ends[1:], strict=True)}

    def single_group(self, context: Context | None = None) -> LeafSystem:
        """The same graph as one system with one state vector, for Drake's linearization and trajectory optimization.

        Args:
            context: its states become the default; what is active in it stays so. Default: all interactions active.

        Returns:
            A `SingleGroupAdapter`: input `<root>`, output `state`, all objects' states one after the other (`slices`).
        """
        own = self.CreateDefaultContext() if context is None else context
        groups = iter(range(own.num_discrete_state_groups()))
        held = []
        for name in self.graph.objects:
            next(groups)  # the state
            if name != self.graph.root:
                held.append(next(groups))
        return SingleGroupAdapter(self, own, tuple(held))


def build_learned_graph(
    graph: InteractionGraph,
    models: Mapping[Interaction, ForwardModel],
    initial: Mapping[str, FloatArray] | None = None,
) -> LearnedGraph:
    """The learned graph of an interaction graph; arguments and errors as those of `LearnedGraph`."""
    return LearnedGraph(graph, models, initial)


def _check_fit(
    graph: InteractionGraph, models: Mapping[Interaction, ForwardModel], initial: Mapping[str, FloatArray]
) -> None:
    missing = [e.name for e in graph.interactions if e not in models]
    if missing:
        raise InputError(f"learned graph: no model for {', '.join(missing)}; learn or load one")
    extra = [e.name for e in models if e not in graph.interactions]
    if extra:
        raise InputError(f"learned graph: model for {', '.join(extra)}, which the graph does not have; leave it out")
    unknown = [n for n in initial if n not in graph.objects]
    if unknown:
        raise InputError(
            f"learned graph: initial state of {', '.join(unknown)}; objects are {', '.join(graph.objects)}"
        )
    for edge, model in models.items():
        require_same_space(f"model of {edge.name}, parent", model.parent_space, graph.objects[edge.parent].observable)
