"""One step for many rows gives each the bits that it has alone, powers and all."""

from typing import Any, ClassVar

import numpy as np
import pytest

from ichain_drake.objects import Joystick, ObjectSettings, WorldObject
from ichain_drake.objects.rows import NotTogetherError, ObjectRows, decide_rows
from ichain_drake.objects.vehicles.vehicle import joined
from ichain_drake.robot import HandSpec
from ichain_drake.state import StateSpace, Variable, columns
from ichain_drake.timing import FRAMES_PER_TICK

KNOB = StateSpace("knob", (Variable("turn"),))
HAND = HandSpec(["x", "y", "z", "grip"]).space


class Squared(WorldObject):
    """Takes powers of numbers, for which numpy has another routine than for arrays."""

    state_space: ClassVar[StateSpace] = StateSpace("squared", (Variable("a"), Variable("b")))

    def step(self, state: Any, parents: Any, active: Any, noise: Any, dt: float) -> Any:
        (a, _), (b,) = columns(state), columns(parents["knob"])
        return joined(state, [a**2 + b**1.5, np.abs(a) ** 0.7 + 0 * active["knob"]])


class ManyPowers(Squared):
    """Takes powers of one variable by another, of a constant, and in place."""

    def step(self, state: Any, parents: Any, active: Any, noise: Any, dt: float) -> Any:
        (a, b), (c,) = columns(state), columns(parents["knob"])
        d = c + 0.1
        d **= 1.7
        return joined(state, [np.abs(a) ** c + d, 1.1**b])


class SquaredArrays(Squared):
    """Takes powers of arrays, also where these have no dimension."""

    def step(self, state: Any, parents: Any, active: Any, noise: Any, dt: float) -> Any:
        return np.stack([state[..., 0] ** 2, parents["knob"][..., 0] ** 1.5], axis=-1)


class SquaredMean(Squared):
    """Gives other values for many rows."""

    def step(self, state: Any, parents: Any, active: Any, noise: Any, dt: float) -> Any:
        return state - (state.mean(axis=0) if state.ndim > 1 else 0.0)


class Endless(Squared):
    """Grows out of all numbers after the first tick, in one row."""

    def step(self, state: Any, parents: Any, active: Any, noise: Any, dt: float) -> Any:
        return np.where(state > 1.0, np.inf, state)


def rows_of(cls: type[WorldObject], count: int, **settings: Any) -> ObjectRows:
    return ObjectRows([cls("thing", {"knob": KNOB}, settings=ObjectSettings(**settings))] * count)


def stepped(cls: type[WorldObject]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """States, the knob, and states after a step that was compared with that of each row alone."""
    rng = np.random.default_rng(0)
    states, knob = rng.normal(size=(3000, 2)), rng.uniform(0, 3, (3000, 1))
    return (
        states,
        knob,
        rows_of(cls, 3000).step(states, {"knob": knob}, np.ones((3000, 1)), 0, np.ones(3000, dtype=bool)),
    )


def test_powers_are_those_of_numbers_where_a_step_takes_numbers() -> None:
    states, knob, after = stepped(Squared)
    assert type(after) is np.ndarray
    assert (after[:, 0] != states[:, 0] ** 2 + knob[:, 0] ** 1.5).any()
    states, knob, after = stepped(ManyPowers)
    assert (after[:, 1] != 1.1 ** states[:, 1]).any()
    states, knob, after = stepped(SquaredArrays)
    np.testing.assert_array_equal(after[:, 0], states[:, 0] ** 2)
    with pytest.raises(NotTogetherError, match="other bits for many rows than for one"):
        stepped(SquaredMean)


def test_what_is_no_state_is_noticed_at_any_time() -> None:
    rows, states = rows_of(Endless, 2), np.array([[0.0, 1.0], [0.0, 2.0]])
    with pytest.raises(NotTogetherError, match="no states of many rows"):
        rows.step(states, {"knob": np.zeros((2, 1))}, np.ones((2, 1)), FRAMES_PER_TICK, np.zeros(2, dtype=bool))


def test_objects_that_need_a_plant_or_a_past_are_refused() -> None:
    with pytest.raises(NotTogetherError, match="drop-outs"):
        rows_of(Squared, 2, dropouts=((1.0, 2.0),))


class Turned(Squared):
    """Has settings of its own, which matter only later."""

    def __init__(self, gain: float, places: tuple[float, ...] = (), seed: int = 0) -> None:
        super().__init__("thing", {"knob": KNOB}, settings=ObjectSettings(seed=seed))
        self.drawn_with = seed
        self.gain, self.about = gain, {"places": np.array(places)}


def test_objects_that_differ_in_anything_but_the_seed_are_refused() -> None:
    ObjectRows([Turned(1.0, (2.0,), seed) for seed in (1, 2)])
    for other in (Turned(1.5, (2.0,)), Turned(1.0, (2.5,)), Turned(1.0)):
        with pytest.raises(NotTogetherError, match="thing differs from run to run"):
            ObjectRows([Turned(1.0, (2.0,)), other])


class LooseGrip(Joystick):
    """Is never held, whatever its hand does."""

    def decide_active(self, *given: Any) -> Any:
        return {"hand": False}


def test_rows_are_not_decided_by_a_rule_that_a_subclass_has_replaced() -> None:
    closed, before = {"hand": np.array([[0.5, 0.0, 0.15, 1.0]] * 2)}, {"hand": np.zeros(2, dtype=bool)}
    for kind, held in ((Joystick, True), (LooseGrip, False)):
        stick = kind("stick", {"hand": HAND})
        states = np.tile(stick.default_state(), (2, 1))
        np.testing.assert_array_equal(decide_rows(stick, states, closed, before)["hand"], [held, held])


class Leaning(Squared):
    """Where it is follows from all rows, while it is touched."""

    def settle(self, state: Any, parents: Any, active: Any) -> Any:
        if not np.any(active["knob"]):
            return state
        return state + (state.mean(axis=0) if state.ndim > 1 else 0.0)


def test_what_settles_is_compared_with_each_row_alone_where_that_is_asked() -> None:
    rows, states = rows_of(Leaning, 3), np.arange(6.0).reshape(3, 2)
    assert rows.settles
    assert not rows_of(Squared, 3).settles
    told, off, on = {"knob": np.ones((3, 1))}, np.zeros((3, 1)), np.ones((3, 1))
    np.testing.assert_array_equal(rows.settle(states, told, off, np.ones(len(states), dtype=bool)), states)
    np.testing.assert_array_equal(
        rows.settle(states, told, on, np.zeros(len(states), dtype=bool)), states + states.mean(axis=0)
    )
    with pytest.raises(NotTogetherError, match="thing: settle gives other bits for many rows than for one"):
        rows.settle(states, told, on, np.ones(len(states), dtype=bool))
