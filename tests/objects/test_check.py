"""`check_object` passes for what keeps the contract and names the clause for what breaks it."""

from typing import Any, ClassVar

import numpy as np
import pytest
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from ichain_drake.objects import Car, ContractError, Joystick, ObjectSettings, WorldObject, check_object
from ichain_drake.robot import HandSpec
from ichain_drake.state import StateSpace, Variable

KNOB = StateSpace("knob", (Variable("turn", "rad", -1.0, 1.0),))
HAND = HandSpec(["x", "y", "z", "grip"]).space


class Tank(WorldObject):
    """A user's own object: all that has to be written."""

    state_space: ClassVar[StateSpace] = StateSpace("tank", (Variable("level", "l", 0.0, 9.0), Variable("flow", "l/s")))
    process_noise_size: ClassVar[int] = 1

    def step(self, state: Any, parents: Any, active: Any, noise: Any, dt: float) -> Any:
        flow = active["knob"] * parents["knob"][..., 0] + 0.01 * noise[..., 0]
        return np.stack([state[..., 0] + dt * flow, flow], axis=-1)

    def measure(self, state: Any, noise: Any) -> Any:
        return state + 0.1 * noise


@pytest.mark.parametrize(
    "system",
    [
        Joystick("stick", {"hand": HAND}),
        Car("car", {"stick": Joystick.state_space}),
        Tank("tank", {"knob": KNOB}, settings=ObjectSettings(dropouts=((0.1, 0.2),))),
    ],
    ids=lambda s: s.get_name(),
)
def test_sound_objects_pass(system: WorldObject) -> None:
    check_object(system)
    check_object(system)  # it is left as it was


class OtherSizedMeasurement(Tank):
    def measure(self, state: Any, noise: Any) -> Any:
        return state[..., :1]


class OtherSizedStep(Tank):
    def step(self, state: Any, parents: Any, active: Any, noise: Any, dt: float) -> Any:
        return state[..., :1]


class OneRowOnly(Tank):
    """Works on one row; a batch raises."""

    def step(self, state: Any, parents: Any, active: Any, noise: Any, dt: float) -> Any:
        level, flow = state
        return np.array([level + dt * flow, parents["knob"][0]])


class MixesRows(Tank):
    """Accepts a batch, but one row leaks into the others."""

    def step(self, state: Any, parents: Any, active: Any, noise: Any, dt: float) -> Any:
        return state + parents["knob"].mean()


class OwnGenerator(Tank):
    def step(self, state: Any, parents: Any, active: Any, noise: Any, dt: float) -> Any:
        return state + np.random.default_rng().standard_normal(state.shape)


class OwnMeasurementGenerator(Tank):
    def measure(self, state: Any, noise: Any) -> Any:
        return state + np.random.default_rng().standard_normal(state.shape)


class InPlace(Tank):
    def step(self, state: Any, parents: Any, active: Any, noise: Any, dt: float) -> Any:
        state[..., 0] += dt
        return state


class NotFinite(Tank):
    def step(self, state: Any, parents: Any, active: Any, noise: Any, dt: float) -> Any:
        return state * np.nan


class ForgetsAParent(Tank):
    def decide_active(self, *_: Any) -> dict[str, bool]:
        return {}


class BodyWithoutSampling(Tank):
    state_space: ClassVar[StateSpace] = StateSpace(
        "tank", (Variable("level", measured_in="plant"), Variable("flow", measured_in="plant"))
    )


@pytest.mark.parametrize(
    ("broken", "clause"),
    [
        (OtherSizedMeasurement, "measure gave shape"),
        (OtherSizedStep, r"step turned shape \(2,\) into \(1,\)"),
        (OneRowOnly, "step fails on a batch .* vectorise over leading dimensions"),
        (MixesRows, "other values for a batch than row by row"),
        (OwnGenerator, "two steps from one state differ; draw no own noise"),
        (OwnMeasurementGenerator, "two runs from one context differ; draw no own noise"),
        (InPlace, "step changes the arrays"),
        (NotFinite, "not finite"),
        (ForgetsAParent, "decide_active must decide on every parent"),
        (BodyWithoutSampling, "does not implement sample_body"),
    ],
)
def test_each_broken_object_fails_with_its_own_clause(broken: type[Tank], clause: str) -> None:
    with pytest.raises(ContractError, match=f"tank: .*{clause}"):
        check_object(broken("tank", {"knob": KNOB}))


class HomeMade(LeafSystem):
    """Not derived from `WorldObject`: its `state` is computed from the input at once."""

    state_space = Tank.state_space

    def __init__(self, outputs: dict[str, int]) -> None:
        super().__init__()
        self.set_name("tank")
        self.parents = {"knob": KNOB}
        port = self.DeclareVectorInputPort("knob", 1)

        def calc(context: Context, out: BasicVector) -> None:
            out.SetFromVector(np.full(out.size(), port.Eval(context)[0]))

        for name, size in outputs.items():
            self.DeclareVectorOutputPort(name, size, calc)


@pytest.mark.parametrize(
    ("outputs", "clause"),
    [
        ({"state": 2, "measured": 2, "valid": 1, "active": 1}, "`state` port depends directly on an input"),
        ({"state": 2, "measured": 2, "valid": 1}, "no output port 'active'"),
        ({"state": 3, "measured": 2, "valid": 1, "active": 1}, "output port 'state' has size 3, not 2"),
    ],
)
def test_wrong_ports_are_found(outputs: dict[str, int], clause: str) -> None:
    with pytest.raises(ContractError, match=clause):
        check_object(HomeMade(outputs))  # type: ignore[arg-type]
