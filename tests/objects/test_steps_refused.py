"""What a step of a user's object must not give: object, variable and time are named."""

from typing import Any, ClassVar

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.objects import ContractError, ObjectSettings, WorldObject, check_object
from ichain_drake.robot import HandSpec, RobotSpec, build_robot
from ichain_drake.state import StateSpace, Variable
from ichain_drake.world.world import World

HAND = HandSpec(["x", "y", "z", "grip"]).space


class Tank(WorldObject):
    state_space: ClassVar[StateSpace] = StateSpace("tank", (Variable("level", "l"), Variable("flow", "l/s")))
    wrong: Any = None

    def step(self, state: Any, parents: Any, active: Any, noise: Any, dt: float) -> Any:
        after = np.stack([state[..., 0] + 1.0, state[..., 1]], axis=-1)
        return self.wrong(after) if state.ndim == 1 and state[0] >= 3 else after


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (lambda s: s * [1.0, np.nan], "tank: step gave a non-finite flow at t = 0.100 s"),
        (lambda s: s + [1e300, 0.0], r"tank: step gave 1e\+300 for level at t = 0.100 s"),
        (lambda s: s[:1], r"tank: step gave shape \(1,\) for a state \(2,\) at t = 0.100 s"),
        (lambda s: ["full", "none"], "tank: step gave values of type <U4, not numbers, at t = 0.100 s"),
        (lambda s: s + 1j, "tank: step gave values of type complex128, not numbers, at t = 0.100 s"),
        (lambda s: [None, s], "tank: step gave list, not numbers, at t = 0.100 s"),
    ],
)
def test_it_is_named_with_variable_and_time(wrong: Any, message: str) -> None:
    system = Tank("tank", {"hand": HAND})
    system.wrong = wrong
    simulator = Simulator(system)
    system.GetInputPort("hand").FixValue(simulator.get_mutable_context(), np.zeros(4))
    simulator.Initialize()
    with pytest.raises(InputError, match=message):
        simulator.AdvanceTo(1.0)


class Dripping(Tank):
    """Draws from a generator of its own, now and then: one step alone rarely shows it."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self._drops = np.random.default_rng(0)

    def step(self, state: Any, parents: Any, active: Any, noise: Any, dt: float) -> Any:
        drops = self._drops.uniform(size=np.shape(state)[:-1]) < 0.3
        return np.stack([state[..., 0] + drops, state[..., 1]], axis=-1)


class RowByRow(Tank):
    """Adds up over the whole batch."""

    def step(self, state: Any, parents: Any, active: Any, noise: Any, dt: float) -> Any:
        return state + np.sum(parents["hand"])


def test_randomness_is_told_from_batching() -> None:
    with pytest.raises(ContractError, match="draw no own noise"):
        check_object(Dripping("tank", {"hand": HAND}))
    with pytest.raises(ContractError, match="vectorise over leading dimensions"):
        check_object(RowByRow("tank", {"hand": HAND}))


def test_two_objects_with_one_number_are_refused() -> None:
    """The number keys the noise: theirs would be the same."""
    spec = RobotSpec(hand=HandSpec(["x", "y", "z", "grip"]))
    graph = InteractionGraph(
        {"hand": HAND, "one": Tank.state_space, "two": Tank.state_space}, ["hand->one", "hand->two"]
    )

    def world(first: int, second: int) -> World:
        made = {
            name: Tank(name, {"hand": HAND}, None, ObjectSettings(number))
            for name, number in (("one", first), ("two", second))
        }
        return World(graph, build_robot(spec, "ideal"), made)

    world(1, 2)
    with pytest.raises(InputError, match="objects one and two both have object_id 1, so their noise"):
        world(1, 1)
