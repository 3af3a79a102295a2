"""The base class of world objects: it makes ports, events, modes and noise, so that a new object is one `step`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, TypedDict

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, InputPort, LeafSystem, State

from ichain_drake.errors import InputError
from ichain_drake.noise import NoiseStream
from ichain_drake.state import FloatArray, StateSpace
from ichain_drake.timing import FRAME

ParentStates = Mapping[str, FloatArray]

_LARGEST = 1e100  # in any unit (hidden variables may be packed bits): the square of much more is infinite


@dataclass(frozen=True)
class ObjectSettings:
    """What a run decides about an object.

    Attributes:
        object_id: key of the object's noise streams, as declared in its scenario.
        seed: seed of the run.
        noise_scale: factor on process and measurement noise; 0 switches both off.
        dropouts: intervals (start, end) [s] in which the sensor holds its last value and reports `valid = 0`.
        body_size: length of the plant's [q; v] of this object's body; 0 where no plant holds it.
        reading_scale: factor on the declared reading noise of vehicles, which are otherwise read without any (paper
            sec. IV).
    """

    object_id: int = 0
    seed: int = 0
    noise_scale: float = 1.0
    dropouts: tuple[tuple[float, float], ...] = ()
    body_size: int = 0
    reading_scale: float = 0.0


class _ParentPorts(Mapping[str, FloatArray]):
    """States of the parents, each read when it is asked for: a mode decided by contact alone needs none of them."""

    def __init__(self, ports: Mapping[str, InputPort], context: Context) -> None:
        self._ports, self._context = ports, context

    def __getitem__(self, name: str) -> FloatArray:
        return self._ports[name].Eval(self._context)

    def __iter__(self) -> Iterator[str]:
        return iter(self._ports)

    def __len__(self) -> int:
        return len(self._ports)


class ObjectArguments(TypedDict, total=False):
    """What every object may be made with beside its name, its parents and what it is itself; see `WorldObject`."""

    initial: FloatArray | None
    settings: ObjectSettings | None


class WorldObject(LeafSystem):
    """An object of the world (paper sec. III: O_i with its MDP M_i), advanced once every 1/30 s.

    A subclass sets `state_space`, implements `step`, and overrides what else it needs. Within one frame, at time t:

    1. unrestricted update: the modes (which incoming interactions are active) are decided from all states at t, with
       the previous modes given for hysteresis. Variables sampled from a body in the plant, and the whole state of a
       `immediate` object, take the value they have at t.
    2. discrete update: `step` leads from t to t + 1/30 s, with the parents' states and the modes of t.

    Drake runs all updates of the first sort before any of the second, so that no object sees a mode or a sampled
    value late, whatever the order of the systems.

    Ports: an input a parent, named after it; with a body also `body` ([q; v]) and `touch` (contact force between
    gripper and body [N]). Outputs `state` (the truth, no feedthrough), `measured` (observable variables as the sensor
    gives them), `valid` (0 during a drop-out), `active` (one 0/1 per incoming interaction; for labels and scoring
    only).

    Args:
        name: system name; the object's name in the interaction graph.
        parents: state space of each parent, by name, in the graph's order.
        initial: state at t = 0, shape (n_variables,); default `default_state`.
        settings: see `ObjectSettings`.
    """

    state_space: ClassVar[StateSpace]
    process_noise_size: ClassVar[int] = 0
    immediate: ClassVar[bool] = False

    def __init__(
        self,
        name: str,
        parents: Mapping[str, StateSpace],
        initial: FloatArray | None = None,
        settings: ObjectSettings | None = None,
    ) -> None:
        super().__init__()
        self.set_name(name)
        self.parents = dict(parents)
        self.settings = settings or ObjectSettings()
        space = self.state_space
        start = space.check(self.default_state() if initial is None else initial, f"{name}: initial state")
        self._settles = type(self).settle is not WorldObject.settle
        self._observable = space.observable_indices
        self._plant = space.plant_indices if self.settings.body_size else np.zeros(0, dtype=np.intp)
        self._process_noise = NoiseStream(
            self.settings.seed, self.settings.object_id, "process", tuple(range(self.process_noise_size))
        )
        self._sensor_noise = NoiseStream(
            self.settings.seed, self.settings.object_id, "measurement", tuple(int(i) for i in self._observable)
        )
        self._parent_ports = {p: self.DeclareVectorInputPort(p, len(s)) for p, s in self.parents.items()}
        if self.settings.body_size:
            self._body_port = self.DeclareVectorInputPort("body", self.settings.body_size)
            self._touch_port = self.DeclareVectorInputPort("touch", 1)

        self._state = self.DeclareDiscreteState(start)
        self._active = self.DeclareDiscreteState(len(self.parents))
        self._clock = self.DeclareDiscreteState(2)  # frame, touch [N] at the last frame
        self._held = self.DeclareDiscreteState(len(self._observable))
        self.DeclareStateOutputPort("state", self._state)
        # Drake tells whatever depends on time of each step of a plant, and passes it on to whatever depends on that.
        when = self.time_ticket() if self.settings.dropouts else self.nothing_ticket()
        self.DeclareVectorOutputPort("measured", len(self._observable), self._calc_measured, {self.xd_ticket(), when})
        self.DeclareVectorOutputPort("valid", 1, self._calc_valid, {when})
        self.DeclareStateOutputPort("active", self._active)

        self.DeclareInitializationUnrestrictedUpdateEvent(self._initialize)
        decides = type(self).decide_active is not WorldObject.decide_active
        if decides or self.immediate or self._settles or len(self._plant):
            self.DeclarePeriodicUnrestrictedUpdateEvent(FRAME, 0.0, self._decide)
        self.DeclarePeriodicDiscreteUpdateEvent(FRAME, 0.0, self._advance)

    # What a subclass provides. All of it works on arrays with any leading batch dimensions.

    def step(
        self, state: FloatArray, parents: ParentStates, active: Mapping[str, FloatArray], noise: FloatArray, dt: float
    ) -> FloatArray:
        """One frame of the object's dynamics (paper sec. III: Tr_i at the world's rate).

        Args:
            state: shape (..., n_variables).
            parents: state of each parent, shape (..., n_parent_variables).
            active: 0 or 1 per parent, shape (...).
            noise: standard normal, shape (..., process_noise_size), already scaled by the run's noise scale.
            dt: duration [s].

        Returns:
            The state dt later, shape (..., n_variables).
        """
        raise NotImplementedError(f"{type(self).__name__} does not implement step")

    def default_state(self) -> FloatArray:
        """State at t = 0 where the scenario gives none, shape (n_variables,)."""
        return np.clip(np.zeros(len(self.state_space)), self.state_space.lower, self.state_space.upper)

    def decide_active(
        self, state: FloatArray, parents: ParentStates, active: Mapping[str, bool], touch: float | None
    ) -> Mapping[str, bool]:
        """Rules of activation and deactivation (paper sec. V), one decision per incoming interaction.

        Args:
            state: shape (n_variables,).
            parents: state of each parent, shape (n_parent_variables,).
            active: the previous decision, for hysteresis.
            touch: contact force between gripper and body [N] at the last frame; None without a body.

        Returns:
            The decision per parent; by default every interaction is always active (paper sec. III, chains).
        """
        return dict.fromkeys(self.parents, True)

    def settle(self, state: FloatArray, parents: ParentStates, active: Mapping[str, bool]) -> FloatArray:
        """What holds at the instant t itself, once the modes of t are decided: the pose of a held object, for instance.

        Called before any `step` of this frame, so that every `step` sees settled states. Values sampled from a body
        are put back afterwards.

        Args:
            state: shape (..., n_variables).
            parents: state of each parent, shape (..., n_parent_variables).
            active: the decision of t per parent, shape (...).

        Returns:
            The state at t, shape (..., n_variables); as it was unless overridden.
        """
        return state

    def sample_body(self, body: FloatArray) -> FloatArray:
        """Values of the variables marked `measured_in: plant`, from the body's [q; v].

        Args:
            body: shape (..., body_size).

        Returns:
            shape (..., n_plant_variables), in state order.
        """
        raise NotImplementedError(f"{type(self).__name__} has a body but does not implement sample_body")

    def measure(self, state: FloatArray, noise: FloatArray) -> FloatArray:
        """What the sensor reads.

        Args:
            state: shape (..., n_variables).
            noise: standard normal, shape (..., n_observable), already scaled.

        Returns:
            shape (..., n_observable); the truth unless overridden.
        """
        return state[..., self._observable]

    # Events and ports.

    def _value(self, context: Context, index: int) -> FloatArray:
        return context.get_discrete_state(index).value()

    def _modes(self, discrete: DiscreteValues) -> dict[str, bool]:
        flags = discrete.value(self._active).tolist()
        return {p: v > 0.5 for p, v in zip(self.parents, flags, strict=True)}

    def _step_once(
        self, context: Context, frame: int, state: FloatArray, parents: ParentStates, active: Mapping[str, Any]
    ) -> FloatArray:
        noise = self._process_noise.at(frame)
        if noise.size:
            noise = noise * self.settings.noise_scale
        return self._checked(self.step(state, parents, active, noise, FRAME), state, context)

    def _checked(self, stepped: Any, state: FloatArray, context: Context) -> FloatArray:
        """What a step gave, as a new array: a step may return the state it was given, which belongs to the context.

        Raises:
            InputError: on another shape, or a variable that is no number or larger than anything measured.
        """
        plain = type(stepped) is np.ndarray and stepped.dtype == float and stepped.shape == state.shape
        if plain and np.maximum.reduce(np.abs(stepped), initial=0.0) <= _LARGEST:  # false where one is no number
            return stepped.copy()
        where, when = f"{self.get_name()}: step gave", f"at t = {context.get_time():.3f} s"
        try:
            given = np.asarray(stepped)
            out = given.astype(float) if given.dtype.kind in "fiub" else None
        except (TypeError, ValueError):
            given, out = None, None
        if given is None or out is None:
            what = type(stepped).__name__ if given is None else f"values of type {given.dtype}"
            raise InputError(f"{where} {what}, not numbers, {when}")
        if out.shape != state.shape:
            raise InputError(f"{where} shape {out.shape} for a state {state.shape} {when}")
        wrong = ~(np.abs(out) <= _LARGEST)
        if wrong.any():
            k = int(np.argmax(wrong))
            what = f"{out[k]:g} for" if np.isfinite(out[k]) else "a non-finite"
            raise InputError(f"{where} {what} {self.state_space.names[k]} {when}")
        return out

    def _initialize(self, context: Context, state: State) -> None:
        """Decide at initialization which interactions are active, so that outputs are right before the first event.

        The sensor takes its first reading, which it holds if a drop-out begins at t = 0.
        """
        self._decide(context, state, advance=False)
        discrete = state.get_mutable_discrete_state()
        reading = self._reading(discrete.value(self._state), int(discrete.value(self._clock)[0]))
        discrete.set_value(self._held, reading)

    def _decide(self, context: Context, state: State, *, advance: bool = True) -> None:
        discrete = state.get_mutable_discrete_state()  # holds what the context does
        value = discrete.value(self._state).copy()
        parents = _ParentPorts(self._parent_ports, context)
        if len(self._plant):
            value[self._plant] = self.sample_body(self._body_port.Eval(context))
        before = self._modes(discrete)
        force = float(discrete.value(self._clock)[1]) if self.settings.body_size else None
        modes = self.decide_active(value, parents, before, force)
        if self.immediate and advance and len(self._plant) < len(value):
            plant_values = value[self._plant]
            active = {p: np.float64(modes[p]) for p in self.parents}
            value = self._step_once(context, int(discrete.value(self._clock)[0]), value, parents, active)
            value[self._plant] = plant_values
        if self._settles:
            plant_values = value[self._plant]
            value = np.array(self.settle(value, parents, modes), dtype=float)
            value[self._plant] = plant_values
        if modes != before:
            discrete.set_value(self._active, [float(modes[p]) for p in self.parents])
        if self.immediate or self._settles or len(self._plant):
            discrete.set_value(self._state, value)

    def _advance(self, context: Context, discrete: DiscreteValues) -> None:
        clock = discrete.get_mutable_value(self._clock)  # what is not set yet is as it is in the context
        if not self.immediate:
            value = discrete.value(self._state)
            parents = _ParentPorts(self._parent_ports, context)
            active = dict(zip(self.parents, discrete.value(self._active), strict=True))
            stepped = self._step_once(context, int(clock[0]), value, parents, active)
            if len(self._plant):
                stepped[self._plant] = value[self._plant]
            discrete.set_value(self._state, stepped)
        if self.settings.body_size:
            # Read here, where the plant's own update at this instant needs the same contact solution anyway.
            clock[1] = self._touch_port.Eval(context)[0]
        clock[0] += 1.0
        if self.settings.dropouts:
            discrete.set_value(self._held, self.GetOutputPort("measured").Eval(context))

    def _dropped_out(self, time: float) -> bool:
        return any(start <= time < end for start, end in self.settings.dropouts)

    def _calc_measured(self, context: Context, output: BasicVector) -> None:
        if self._dropped_out(context.get_time()):
            output.SetFromVector(self._value(context, self._held))
            return
        frame = int(self._value(context, self._clock)[0])
        output.SetFromVector(self._reading(self._value(context, self._state), frame))

    def _reading(self, state: FloatArray, frame: int) -> FloatArray:
        return self.measure(state, self._sensor_noise.at(frame) * self.settings.noise_scale)

    def _calc_valid(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector([0.0 if self._dropped_out(context.get_time()) else 1.0])

    # Access from outside.

    def readings(self, states: FloatArray, frames: Sequence[int]) -> FloatArray:
        """What `measured` showed at some frames, in a run without drop-outs, to the last bit.

        Args:
            states: at these frames, shape (n, n_variables).
            frames: their numbers from the start of the run.
        """
        if not len(frames):
            return np.zeros((0, len(self._observable)))
        last = self._reading(states[-1], frames[-1])
        try:
            read = np.asarray(self.measure(states, self._sensor_noise.rows(frames) * self.settings.noise_scale), float)
        except Exception:  # a sensor that takes one row at a time; what else is wrong with it shows below
            read = np.zeros(0)
        if read.shape == (len(frames), len(last)) and np.array_equal(read[-1], last):
            return read
        return np.array([self._reading(*row) for row in zip(states, frames, strict=True)], dtype=float)

    def set_state(self, context: Context, state: FloatArray | Sequence[float]) -> None:
        """Put the object into a state.

        Args:
            context: the object's own context.
            state: shape (n_variables,).

        Raises:
            InputError: on a wrong shape or a non-finite value.
        """
        context.SetDiscreteState(self._state, self.state_space.check(state, f"{self.get_name()}: state"))

    def get_state(self, context: Context) -> FloatArray:
        """The object's state, shape (n_variables,), from the object's own context."""
        return self._value(context, self._state).copy()
