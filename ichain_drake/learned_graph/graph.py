"""The learned graph as a Drake Diagram: the same nodes and edges as the world, predicting in place of simulating."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property

import numpy as np
from pydrake.systems.framework import Context, Diagram, DiagramBuilder, LeafSystem

from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learned_graph.adapter import SingleGroupAdapter_
from ichain_drake.learned_graph.component import LearnedComponent_
from ichain_drake.learned_graph.members import LinkedMembers, Members, ModelMembers
from ichain_drake.learned_graph.object import LearnedObject_
from ichain_drake.learned_graph.root import GivenRoot_
from ichain_drake.learned_graph.transition import ObjectTransition, require_same_space
from ichain_drake.learning import InteractionModel
from ichain_drake.learning.chain.models import ForwardModel
from ichain_drake.state import FloatArray


class LearnedGraph(Diagram):
    """Learned objects wired along the interactions, advanced once a tick; converts to AutoDiffXd.

    Systems carry the objects' names; every interaction is a connection to the child's input port of the parent's
    name, as in the world. Objects that form a cycle share a `component:<names>` for the evaluation of their next
    states (see `LearnedComponent`). One call of `EvalUniquePeriodicDiscreteUpdate` is one tick of
    `LearnedGraphReference`, equal to the last bit.

    Which interactions are active is part of the context (`set_active`). What was learned for goals tells from there on
    by itself when they begin and end; those of a chain, or of plain forward models, stay as they are set.

    Ports: input `<root>` for each robot, its state at t + 1. Outputs `<object>.state`, `<object>.next_state` for every
    object and robot, `<object>.active` for every object.

    Args:
        model: what was learned (see `learn`); or a graph, with `models`.
        models: forward model of every interaction of a graph.
        initial: observable states at t = 0, by object, where they are not 0 (clipped to the bounds).

    Raises:
        InputError: if a model is missing or superfluous, or a model or state doesn't fit the graph; names which.
    """

    def __init__(
        self,
        model: InteractionModel | InteractionGraph,
        models: Mapping[Interaction, ForwardModel] | None = None,
        initial: Mapping[str, FloatArray] | None = None,
    ) -> None:
        super().__init__()
        graph = self.graph = model if isinstance(model, InteractionGraph) else model.graph
        _check_initial(graph, initial or {})
        members = _members(model, models or {})
        self._edges = frozenset(graph.interactions)

        builder = DiagramBuilder()
        self._systems: dict[str, LeafSystem] = {}
        starts = _starts(graph, initial or {})
        flags = {} if isinstance(model, InteractionGraph) or model.chain is not None else model.active(starts)
        for name in graph.objects:
            if name in graph.roots:
                system = GivenRoot_[float](name, starts[name])
            else:
                active = np.array([float(flags.get(e, True)) for e in graph.incoming(name)])
                system = LearnedObject_[float](name, members[name], starts[name], active)
            self._systems[name] = builder.AddNamedSystem(name, system)
        for edge in graph.interactions:
            parent, child = self.system(edge.parent), self.system(edge.child)
            builder.Connect(parent.GetOutputPort("next_state"), child.GetInputPort(edge.parent))
            builder.Connect(parent.GetOutputPort("state"), child.GetInputPort(f"{edge.parent}.now"))
        for group in {id(m): m for m in members.values() if len(m.spaces) > 1}.values():
            self._add_component(builder, group)
        for root in graph.roots:
            builder.ExportInput(self.system(root).GetInputPort("next_state"), root)
        for name, system in self._systems.items():
            for port in ("state", "next_state", "active"):
                if system.HasOutputPort(port):
                    builder.ExportOutput(system.GetOutputPort(port), f"{name}.{port}")
        builder.BuildInto(self)
        self.set_name("learned_graph")

    def _add_component(self, builder: DiagramBuilder, members: Members) -> None:
        component = LearnedComponent_[float](members)
        builder.AddNamedSystem(component.get_name(), component)
        for name in members.spaces:
            system = self.system(name)
            builder.Connect(system.GetOutputPort("state"), component.GetInputPort(f"{name}.now"))
            builder.Connect(system.GetOutputPort("active"), component.GetInputPort(f"{name}.active"))
            builder.Connect(component.GetOutputPort(f"{name}.next_state"), system.GetInputPort("component"))
            builder.Connect(component.GetOutputPort(f"{name}.next_active"), system.GetInputPort("component.active"))
        for name in members.outside:
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
            if edge not in self._edges:
                known = ", ".join(e.name for e in self.graph.interactions)
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
            A `SingleGroupAdapter`: inputs `<root>`, output `state`, all objects' states one after the other (`slices`).
        """
        own = self.CreateDefaultContext() if context is None else context
        groups = iter(range(own.num_discrete_state_groups()))
        held = []
        for name in self.graph.objects:
            next(groups)  # the state
            if name not in self.graph.roots:
                held.append(next(groups))
        return SingleGroupAdapter_[float](self, own, tuple(held))


build_learned_graph = LearnedGraph  # as it was called before it took models of every kind


def _members(
    model: InteractionModel | InteractionGraph, models: Mapping[Interaction, ForwardModel]
) -> dict[str, Members]:
    """Of every object but the robot, the component that it is in."""
    graph = model if isinstance(model, InteractionGraph) else model.graph
    learned = None if isinstance(model, InteractionGraph) else model
    if learned is not None and learned.chain is not None:
        models, learned = {link.interaction: link.forward.model for link in learned.chain.links}, None
    if learned is None:
        _check_models(graph, models)
    found: dict[str, Members] = {}
    for names in graph.components:
        if names[0] in graph.roots:
            continue
        if learned is not None:
            members: Members = ModelMembers(learned, names)
        else:
            incoming = {n: {e.parent: models[e] for e in graph.incoming(n)} for n in names}
            spaces = {n: graph.objects[n].observable for n in names}
            members = LinkedMembers([ObjectTransition(n, spaces[n], incoming[n]) for n in names])
        found |= dict.fromkeys(names, members)
    return found


def _starts(graph: InteractionGraph, initial: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
    """States at t = 0; of what was not given 0, within the bounds."""
    found = {}
    for name, declared in graph.objects.items():
        space = declared.observable
        start = initial.get(name, np.clip(np.zeros(len(space)), space.lower, space.upper))
        found[name] = space.check(start, f"learned graph, {name}: initial state")
    return found


def _check_initial(graph: InteractionGraph, initial: Mapping[str, FloatArray]) -> None:
    unknown = [n for n in initial if n not in graph.objects]
    if unknown:
        raise InputError(
            f"learned graph: initial state of {', '.join(unknown)}; objects are {', '.join(graph.objects)}"
        )


def _check_models(graph: InteractionGraph, models: Mapping[Interaction, ForwardModel]) -> None:
    missing = [e.name for e in graph.interactions if e not in models]
    if missing:
        raise InputError(f"learned graph: no model for {', '.join(missing)}; learn or load one")
    extra = [e.name for e in models if e not in graph.edges]
    if extra:
        raise InputError(f"learned graph: model for {', '.join(extra)}, which the graph does not have; leave it out")
    for edge, model in models.items():
        require_same_space(f"model of {edge.name}, parent", model.parent_space, graph.objects[edge.parent].observable)
