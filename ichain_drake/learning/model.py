"""A learned interaction graph: status, effects and passive dynamics of every object, as one batched numpy model."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from ichain_drake.demonstrations import Demonstration, data_hash
from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.alike import Group, advance_copies, groups_of, uniform
from ichain_drake.learning.batch import flatten, forced_status, shaped
from ichain_drake.learning.chain.chain import DEMONSTRATIONS, LearnedChain
from ichain_drake.learning.cycles import Ring, refuse_active, rings_of, sweeps_of
from ichain_drake.learning.known import KnownParts
from ichain_drake.learning.passive import PassiveDynamics
from ichain_drake.learning.report import report
from ichain_drake.learning.spreads import spread_of
from ichain_drake.learning.status.events import Windows
from ichain_drake.learning.status.inputs import objects_of
from ichain_drake.learning.tick import LearnedInteraction, advance, effects_of
from ichain_drake.state import BoolArray, FloatArray
from ichain_drake.timing import TICK

States = Mapping[str, FloatArray]
Status = Mapping[Interaction, ArrayLike]


@dataclass(frozen=True)
class InteractionModel:
    """Forward models and status classifiers of a graph, learned from unordered demonstrations (paper sec. V).

    States are mappings of every object to arrays of shape (..., n_observable_variables); leading dimensions are a
    batch. An interaction acts in the tick from t to t + 1 if it is active at the tick's end, as the flags of the
    demonstrations say it.

    Attributes:
        graph: the interaction graph.
        edges: what was learned about each interaction.
        passive: passive dynamics of each object but the robots.
        low, high: range of each object's states in the demonstrations, shape (n_variables,).
        step_limit: largest change in a tick that the demonstrations show, shape (n_variables,).
        order: interactions in canonical order, in which effects are added up.
        noise: standard deviation of a reading, per object, shape (n_variables,).
        pieces: names of the pieces that it was learned from.
        findings: what is odd about them, in one line each.
        wall_seconds: time that learning took [s].
        activations, deactivations: demonstrated events of each interaction of the robot.
        robot_seconds: simulated time that recording the demonstrations took of the robot [s].
        demonstrations_sha256: hash of them, 64 hexadecimal digits.
        source: `demonstrations`, or the folder of the library that all of it was loaded from.
        known: what was known before, and so not learned.
        chain: links and commands for following paths, where that is what was learned: then `edges` and all that goes
            with them are empty, and all interactions of the chain are always active.
    """

    graph: InteractionGraph
    edges: dict[Interaction, LearnedInteraction]
    passive: dict[str, PassiveDynamics]
    low: dict[str, FloatArray]
    high: dict[str, FloatArray]
    step_limit: dict[str, FloatArray]
    order: tuple[Interaction, ...]
    noise: dict[str, FloatArray]
    pieces: tuple[str, ...]
    findings: tuple[str, ...] = field(default=(), compare=False)
    wall_seconds: float = field(default=0.0, compare=False)
    activations: Windows = field(default_factory=dict, compare=False)
    deactivations: Windows = field(default_factory=dict, compare=False)
    robot_seconds: float = 0.0
    demonstrations_sha256: str = ""
    source: str = DEMONSTRATIONS
    known: KnownParts = field(default_factory=KnownParts, compare=False)
    chain: LearnedChain | None = None

    @classmethod
    def of_chain(cls, chain: LearnedChain, pieces: Sequence[Demonstration], known: KnownParts) -> InteractionModel:
        """What was learned about a chain that follows paths.

        Args:
            chain: its links.
            pieces: the demonstrations.
            known: what was known before.
        """
        edges = tuple(link.interaction for link in chain.links)
        names = tuple(p.name for p in pieces)
        return cls(
            chain.graph, {}, {}, {}, {}, {}, edges, {}, names,
            demonstrations_sha256=data_hash(pieces), known=known, chain=chain,
        )  # fmt: skip

    def for_paths(self) -> LearnedChain:
        """Its chain.

        Raises:
            InputError: if it was learned for goals.
        """
        if self.chain is None:
            raise InputError("the model was learned for goals; for a path, give `learn` a target, or a PathScenario")
        return self.chain

    def for_goals(self) -> InteractionModel:
        """Itself.

        Raises:
            InputError: if it was learned about a chain that follows paths.
        """
        if self.chain is not None:
            raise InputError("the model was learned for following paths; for a goal, give `learn` no target")
        return self

    def source_of(self, edge: Interaction) -> str:
        """Where an interaction's models come from: `demonstrations`, or a folder."""
        return self.known.sources.get(edge, self.source)

    def robot_seconds_of(self, edge: Interaction) -> float:
        """Simulated time of the robot that recording an interaction's demonstrations took, with others' [s]."""
        return self.known.robot_seconds.get(edge, self.robot_seconds)

    def acting(self, robot: str) -> InteractionModel:
        """The same model as one of several robots sees it; see `InteractionGraph.acting`.

        Raises:
            InputError: if the graph has no such robot.
        """
        graph = self.graph.acting(robot)
        return self if graph is self.graph else replace(self, graph=graph)

    def decide(self, edge: Interaction, states: States) -> FloatArray:
        """Decision value of an interaction's status, shape (...): >= 0 means active.

        Args:
            edge: the interaction.
            states: of at least the child and its parents, shape (..., n_variables) each.

        Raises:
            InputError: if the graph has no such interaction, or a state is missing.
        """
        learned = self._edge(edge)
        rows, shape = flatten(states, self._around(edge.child), self.graph)
        return learned.status.decide(rows).reshape(shape)

    def probability(self, edge: Interaction, states: States) -> FloatArray:
        """Calibrated probability that an interaction is active, shape (...); arguments as of `decide`."""
        rows, shape = flatten(states, self._around(edge.child), self.graph)
        return self._edge(edge).status.probability(rows).reshape(shape)

    def active(self, states: States, previous: Status | None = None) -> dict[Interaction, BoolArray]:
        """Which interactions are active, shape (...) each.

        Args:
            states: of every object.
            previous: the status one tick before, for hysteresis.
        """
        rows, shape = flatten(states, tuple(self.graph.objects), self.graph)
        if self.chain is not None:
            return {e: np.ones(shape, dtype=bool) for e in self.order}
        n = len(next(iter(rows.values())))
        before = forced_status(previous, self.graph, shape, n)
        return {e: self.edges[e].status.active(rows, before.get(e)).reshape(shape) for e in self.graph.interactions}

    def effect(self, edge: Interaction, states: States, parent_next: ArrayLike) -> FloatArray:
        """What an interaction adds to the child's passive change in a tick, shape (..., n_child), were it active.

        Args:
            edge: the interaction.
            states: of parent and child at t, shape (..., n_variables) each.
            parent_next: the parent's state at t + 1, shape (..., n_parent).
        """
        learned = self._edge(edge)
        both = {**{n: states[n] for n in (edge.parent, edge.child) if n in states}, "": np.asarray(parent_next, float)}
        rows, shape = flatten(both, (edge.parent, edge.child, ""), self.graph, {"": edge.parent})
        return effects_of(learned, rows[edge.parent], rows[""], rows[edge.child]).reshape(*shape, -1)

    def step(
        self,
        states: States,
        root_next: ArrayLike | Mapping[str, ArrayLike],
        active: Status | None = None,
        previous: Status | None = None,
        time: float | None = None,
        *,
        strict: bool = True,
    ) -> tuple[dict[str, FloatArray], dict[Interaction, BoolArray]]:
        """One tick.

        Where an interaction is neither forced nor known from before, it was active if its classifier says so at t. It
        goes on if it is still active in the state that it leads to, and begins if the parent at t + 1 and the child at
        t make it active.

        Args:
            states: of every object at t, shape (..., n_variables).
            root_next: state of the root at t + 1, shape (..., n_root); or of several robots, by name. Others stay.
            active: status to take as given, for some interactions.
            previous: status at t, for some interactions.
            time: at the tick's end, named in the error [s].
            strict: whether to refuse a cycle of active interactions; else each sees what the others were before.

        Returns:
            The states at t + 1, and the status of every interaction at t + 1, shape (...).

        Raises:
            InputError: if a state is missing or has a wrong length.
            ActiveCycleError: if interactions that are active at t + 1 form a cycle.
        """
        every = tuple(self.graph.objects)
        ahead = root_next if isinstance(root_next, Mapping) else {self.graph.root: root_next}
        owners = {f"->{name}": name for name in ahead}  # no object is called so
        joined = {**states, **{key: np.asarray(ahead[name], dtype=float) for key, name in owners.items()}}
        rows, shape = flatten(joined, (*every, *owners), self.graph, owners)
        after = {name: rows.pop(key) for key, name in owners.items()}
        after |= {name: rows[name] for name in self.graph.roots if name not in after}
        n = len(after[self.graph.root])
        on: dict[Interaction, BoolArray] = {}
        if self.chain is not None:
            self.chain.advance(rows, after)
            on = {e: np.ones(n, dtype=bool) for e in self.order}
            return shaped(after, on, shape)
        forced = forced_status(active, self.graph, shape, n)
        before = forced_status(previous, self.graph, shape, n)
        for group in self._groups:
            for alike in uniform(group, forced, before):
                advance_copies(self.advance_component, alike, rows, after, forced, before, on)
        if strict:
            self.refuse_cycles(on, time)
        return shaped({n: after[n] for n in every}, {e: on[e] for e in self.graph.interactions}, shape)

    def advance_component(
        self,
        members: tuple[str, ...],
        rows: Mapping[str, FloatArray],
        after: dict[str, FloatArray],
        forced: Mapping[Interaction, BoolArray],
        before: Mapping[Interaction, BoolArray],
        on: dict[Interaction, BoolArray],
    ) -> None:
        """One tick of the objects of one strongly connected component: of one object, where it is in no cycle.

        Args:
            members: their names, in the graph's order.
            rows: states of them and their parents at t, shape (n, n_variables).
            after: states at t + 1 of parents outside; is given those of the members.
            forced, before: status to take as given, and status at t, shape (n,) each.
            on: is given the status at t + 1 of their incoming interactions.
        """
        # In a cycle the first sweep sees some parents at t; each further sweep brings news one object on. Whom no news
        # reached stays as calculated.
        stale = set(members)
        for _ in range(len(members)):
            for child in self._sweep(members):
                if child not in stale:
                    continue
                stale.discard(child)
                seen = after.get(child, rows[child])
                after[child] = advance(
                    self.edges, self._incoming[child], self.passive[child], rows, after, forced, before, on
                )
                if len(members) > 1 and not np.array_equal(after[child], seen):
                    stale.update(n for n in self.graph.digraph.successors(child) if n in members)
            if not stale:
                break

    def rollout(
        self, states: States, root_path: ArrayLike, active: Status | None = None, previous: Status | None = None
    ) -> tuple[dict[str, FloatArray], dict[Interaction, BoolArray]]:
        """Many ticks, each from what the one before predicted; arguments as in `step`.

        Args:
            states: of every object at the start, shape (..., n_variables).
            root_path: states of the root from the first tick's end on, shape (n_ticks, ..., n_root).
            active: status to take as given, for some interactions, in all ticks.
            previous: status at the start.

        Returns:
            States, shape (n_ticks + 1, ..., n_variables) each with the start, and status, shape (n_ticks, ...).

        Raises:
            InputError, ActiveCycleError: as `step`.
        """
        path = np.asarray(root_path, dtype=float)
        now: dict[str, FloatArray] = {n: np.asarray(states[n], dtype=float) for n in self.graph.objects}
        trace, status = [now], []
        known = previous
        for tick, root_next in enumerate(path, start=1):
            now, known = self.step(now, root_next, active, known, tick * TICK)
            trace.append(now)
            status.append(known)
        start = {n: np.broadcast_to(trace[0][n], trace[-1][n].shape) for n in self.graph.objects}
        return (
            {n: np.stack([start[n], *(t[n] for t in trace[1:])]) for n in self.graph.objects},
            {e: np.array([s[e] for s in status]) for e in self.graph.interactions},
        )

    def spread(self, child: str, active: Sequence[Interaction]) -> FloatArray:
        """Standard deviation of a one-tick prediction while some edges are active, shape (n_variables,)."""
        acting = {e: self._edge(e) for e in active if e.child == child}
        return spread_of(self.passive[child], acting, self.noise[child])[0]

    def customary(self, edge: Interaction) -> tuple[str, ...]:
        """What always held while an interaction was active, in words, without being known to matter; see `Customary`.

        Raises:
            InputError: if there is no such interaction.
        """
        return self._edge(edge).customary.labels

    def suspects(self, edge: Interaction) -> tuple[str, ...]:
        """Objects that may be to blame where an interaction is not active although its classifier saw no reason.

        Those that the classifier and the customary conditions look at; where there are no such conditions, the child
        and all that act on it.

        Raises:
            InputError: if there is no such interaction.
        """
        learned = self._edge(edge)
        if not learned.customary.inputs:
            return self._around(edge.child)
        looked = {n for i in (*learned.status.inputs, *learned.customary.inputs) for n in objects_of(i)}
        return tuple(n for n in self._around(edge.child) if n in looked | {edge.child})

    def cautious(self, edges: Collection[Interaction]) -> InteractionModel:
        """The same model, in which some interactions are active only under their customary conditions.

        Raises:
            InputError: if there is no such interaction.
        """
        return replace(self, edges={**self.edges, **{e: self._edge(e).cautious() for e in edges}})

    def with_noise(self, noise: dict[str, FloatArray]) -> InteractionModel:
        """The same model with sensors of another noise, shape (n_variables,) per object."""
        return replace(self, noise=noise)

    def report(self) -> dict[str, object]:
        """Figures and warnings of every model; see `report`."""
        return report(self)

    @cached_property
    def _incoming(self) -> dict[str, tuple[Interaction, ...]]:
        place = {e: k for k, e in enumerate(self.order)}
        return {n: tuple(sorted(self.graph.incoming(n), key=place.__getitem__)) for n in self.graph.objects}

    @cached_property
    def _groups(self) -> list[Group]:
        return groups_of(self.graph, self._incoming, self.edges, self.passive)

    def _sweep(self, members: tuple[str, ...]) -> tuple[str, ...]:
        return members if len(members) == 1 else self._sweeps[members]

    @cached_property
    def _sweeps(self) -> dict[tuple[str, ...], tuple[str, ...]]:
        return sweeps_of(self.graph, self._incoming, self.order)

    @cached_property
    def _cycles(self) -> list[Ring]:
        return rings_of(self.graph)

    def refuse_cycles(self, on: Mapping[Interaction, BoolArray], time: float | None) -> None:
        """Refuse a cycle of interactions that are active at the same time.

        Args:
            on: status of all interactions, or of those of one strongly connected component, shape (n,).
            time: named in the error [s].

        Raises:
            ActiveCycleError: names the interactions.
        """
        refuse_active(self._cycles, on, time)

    def _around(self, child: str) -> tuple[str, ...]:
        return (child, *self.graph.parents(child))

    def _edge(self, edge: Interaction) -> LearnedInteraction:
        if edge not in self.edges:
            known = ", ".join(e.name for e in self.edges)
            raise InputError(f"there is no learned interaction {getattr(edge, 'name', edge)!s}; learned are {known}")
        return self.edges[edge]
