"""What the base class gives every object: modes with hysteresis, drop-outs, noise, errors."""

from typing import Any, ClassVar

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context

from ichain_drake.errors import InputError
from ichain_drake.noise import NoiseStream
from ichain_drake.objects import ObjectSettings, WorldObject
from ichain_drake.objects.rows import decide_rows
from ichain_drake.state import StateSpace, Variable
from ichain_drake.timing import FRAME

KNOB = StateSpace("knob", (Variable("turn"),))


class Counter(WorldObject):
    """Counts frames; the interaction starts above a turn of 0.6 and ends below 0.4."""

    state_space: ClassVar[StateSpace] = StateSpace("counter", (Variable("frames"), Variable("active_frames")))

    def step(self, state: Any, parents: Any, active: Any, noise: Any, dt: float) -> Any:
        return state + np.stack([np.ones_like(active["knob"]), active["knob"]], axis=-1)

    def decide_active(self, state: Any, parents: Any, active: Any, touch: float | None) -> dict[str, bool]:
        return {"knob": bool(parents["knob"][0] > (0.4 if active["knob"] else 0.6))}

    def measure(self, state: Any, noise: Any) -> Any:
        return state + 0.1 * noise


class Stone(Counter):
    """Nothing moves it: `step` hands back the very array that it was given."""

    def step(self, state: Any, parents: Any, active: Any, noise: Any, dt: float) -> Any:
        return state


class Rig:
    """An object alone, with its parent's state set from frame to frame."""

    def __init__(self, system: WorldObject, turn: float = 0.0) -> None:
        self.system = system
        self.simulator = Simulator(system)
        self.context: Context = self.simulator.get_mutable_context()
        system.GetInputPort("knob").FixValue(self.context, [turn])
        self.simulator.Initialize()

    def frame(self, turn: float) -> None:
        self.system.GetInputPort("knob").FixValue(self.context, [turn])
        self.simulator.AdvanceTo((round(self.context.get_time() / FRAME) + 1) * FRAME)

    def read(self, port: str) -> np.ndarray:
        return self.system.GetOutputPort(port).Eval(self.context).copy()


def make(cls: type[Counter] = Counter, **settings: Any) -> Counter:
    return cls("counter", {"knob": KNOB}, settings=ObjectSettings(**settings))


def test_modes_change_by_events_with_hysteresis() -> None:
    rig = Rig(make())
    seen = []
    for turn in (0.5, 0.59, 0.61, 0.5, 0.41, 0.39, 0.5, 0.61):
        rig.frame(turn)
        seen.append(int(rig.read("active")[0]))
    assert seen == [0, 0, 1, 1, 1, 0, 0, 1]
    # A decision at t is in force in the frame that starts at t: every active frame was counted, none late.
    assert rig.read("state").tolist() == [8.0, sum(seen)]


@pytest.mark.parametrize(("turn", "expected"), [(0.7, 1.0), (0.5, 0.0)])
def test_modes_are_right_before_the_first_frame(turn: float, expected: float) -> None:
    """The initialization event decides, from 'inactive' before."""
    assert Rig(make(), turn).read("active")[0] == expected


def test_measured_follows_the_declared_noise_stream() -> None:
    rig = Rig(make(object_id=4, seed=9, noise_scale=2.0))
    stream = NoiseStream(9, 4, "measurement", (0, 1))
    for k in range(1, 5):
        rig.frame(0.0)
        np.testing.assert_allclose(rig.read("measured"), rig.read("state") + 0.2 * stream.at(k), atol=1e-15)


class OneByOne(Counter):
    """Its sensor takes its state apart: of many rows it gives other values than of each."""

    def measure(self, state: Any, noise: Any) -> Any:
        return np.array([state[0], state[1]]) + 0.1 * noise


class Summing(Counter):
    """The same, in another shape."""

    def measure(self, state: Any, noise: Any) -> Any:
        return np.array([state[0] + noise[0], state[1]])


@pytest.mark.parametrize("kind", [Counter, OneByOne, Summing])
@pytest.mark.parametrize("frames", [[], [3], [0, 7], [2, 511, 512]])
def test_readings_of_many_frames_are_those_of_each(kind: type[Counter], frames: list[int]) -> None:
    counter = make(kind, object_id=4, seed=9, noise_scale=2.0)
    states = np.random.default_rng(0).normal(size=(len(frames), 2))
    stream = NoiseStream(9, 4, "measurement", (0, 1))
    expected = [counter.measure(s, 2.0 * stream.at(k)) for s, k in zip(states, frames, strict=True)]
    np.testing.assert_array_equal(counter.readings(states, frames), np.reshape(expected, (-1, 2)))


def test_noise_scale_zero_measures_the_truth() -> None:
    rig = Rig(make(noise_scale=0.0))
    rig.frame(1.0)
    np.testing.assert_array_equal(rig.read("measured"), rig.read("state"))


def test_a_drop_out_holds_the_last_value_and_says_so() -> None:
    """Sampled at frames, as controllers and tables do: `valid` is 0 in the interval, `measured` what it was before."""
    rig = Rig(make(dropouts=((3.5 * FRAME, 7.5 * FRAME),)))
    rows, valid = [rig.read("measured")], [rig.read("valid")[0]]
    for _ in range(10):
        rig.frame(0.0)
        rows.append(rig.read("measured"))
        valid.append(rig.read("valid")[0])
    assert valid == [1, 1, 1, 1, 0, 0, 0, 0, 1, 1, 1]
    for row in rows[4:8]:
        np.testing.assert_array_equal(row, rows[3])
    assert not np.array_equal(rows[8], rows[3])
    # The world itself goes on.
    assert rig.read("state")[0] == 10


def test_a_drop_out_from_the_start_holds_the_first_measurement() -> None:
    system = Counter("counter", {"knob": KNOB}, np.array([5.0, 6.0]), ObjectSettings(3, 1, dropouts=((0.0, 1.0),)))
    rig = Rig(system)
    expected = [5.0, 6.0] + 0.1 * NoiseStream(1, 3, "measurement", (0, 1)).at(0)
    np.testing.assert_array_equal(rig.read("measured"), expected)
    rig.frame(0.0)
    np.testing.assert_array_equal(rig.read("measured"), expected)


def test_a_step_may_hand_back_the_state_that_it_was_given() -> None:
    rig = Rig(make(Stone))
    rig.frame(0.0)
    assert rig.read("state").tolist() == [0.0, 0.0]


def test_a_clone_of_the_context_has_the_same_future() -> None:
    rig = Rig(make(seed=5), 0.7)
    rig.simulator.AdvanceTo(0.5)
    futures = []
    for _ in range(2):
        again = Simulator(rig.system, rig.context.Clone())
        again.AdvanceTo(1.5)
        futures.append(rig.system.GetOutputPort("measured").Eval(again.get_context()).copy())
    rig.simulator.AdvanceTo(1.5)
    np.testing.assert_array_equal(futures[0], futures[1])
    np.testing.assert_array_equal(futures[0], rig.read("measured"))


def test_states_are_checked_where_they_enter() -> None:
    system = make()
    context = system.CreateDefaultContext()
    system.set_state(context, [3.0, 2.0])
    assert system.get_state(context).tolist() == [3.0, 2.0]
    with pytest.raises(InputError, match="counter: state: active_frames is not a finite number"):
        system.set_state(context, [3.0, np.nan])
    with pytest.raises(InputError, match="counter: initial state: shape"):
        Counter("counter", {"knob": KNOB}, np.zeros(3))


def test_a_step_that_diverges_names_object_variable_and_time() -> None:
    class Divergent(Counter):
        def step(self, state: Any, parents: Any, active: Any, noise: Any, dt: float) -> Any:
            return np.array([0.0, np.inf]) if state[0] else state + 1.0

    rig = Rig(Divergent("counter", {"knob": KNOB}))
    with pytest.raises(InputError, match=r"counter: step gave a non-finite active_frames at t = 0\.033 s"):
        rig.simulator.AdvanceTo(1.0)


def test_a_step_of_another_shape_names_object_and_shapes() -> None:
    class Wide(Counter):
        def step(self, state: Any, parents: Any, active: Any, noise: Any, dt: float) -> Any:
            return np.append(state, 0.0)

    rig = Rig(Wide("counter", {"knob": KNOB}))
    with pytest.raises(InputError, match=r"counter: step gave shape \(3,\) for a state \(2,\)"):
        rig.simulator.AdvanceTo(1.0)


def test_an_object_without_step_says_so() -> None:
    class Empty(WorldObject):
        state_space: ClassVar[StateSpace] = KNOB

    with pytest.raises(NotImplementedError, match="Empty does not implement step"):
        Rig(Empty("e", {"knob": KNOB})).simulator.AdvanceTo(0.1)


def test_many_rows_are_decided_as_each_is_alone() -> None:
    parents, before = {"knob": np.array([[0.7], [0.5], [0.5], [0.3]])}, {"knob": np.array([False, False, True, True])}
    decided = decide_rows(make(), np.zeros((4, 2)), parents, before)
    np.testing.assert_array_equal(decided["knob"], [True, False, True, False])
