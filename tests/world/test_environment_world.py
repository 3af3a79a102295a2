"""Somebody else's environment as a world: the same states, replayed from any context; and what is refused."""

import dataclasses

import numpy as np
import pytest

pytest.importorskip("gymnasium", reason="Gymnasium is missing: pip install 'ichain_drake[games]'")

from push_environment import CrateEnv, spec
from pydrake.systems.analysis import Simulator

import ichain_drake as ic
from ichain_drake.world.environment_world import environment_world
from ichain_drake.world.open_environment import OpenEnvironment

WANTED = np.array([0.5, 0.5, 0.0])


def started(start: int = 3, **changed: object) -> tuple[ic.World, Simulator]:
    world = environment_world(OpenEnvironment(spec(**changed)), start)
    simulator = Simulator(world)
    simulator.Initialize()
    return world, simulator


def go(simulator: Simulator, world: ic.World, wanted: np.ndarray, tick: int) -> None:
    world.GetInputPort("hand_command").FixValue(simulator.get_mutable_context(), wanted)
    simulator.AdvanceTo(tick * ic.TICK)


def values(world: ic.World, simulator: Simulator, port: str = "state") -> dict[str, np.ndarray]:
    context = simulator.get_context()
    return {n: world.GetOutputPort(f"{n}.{port}").Eval(context).copy() for n in world.graph.objects}


def test_a_tick_is_its_steps_closed_on_what_is_read() -> None:
    world, simulator = started()
    env = CrateEnv()
    env.reset(seed=3)
    crate = env.state[3:5].copy()
    ways = [np.append(crate, 0.0)] * 10 + [np.append(crate, 1.0)] * 2 + [np.array([0.8, 0.3, 1.0])] * 8
    for tick, wanted in enumerate(ways, 1):
        go(simulator, world, wanted, tick)
        for _ in range(2):
            env.step(np.array([*np.clip(wanted[:2] - env.state[:2], -0.03, 0.03), wanted[2]]))
        found = values(world, simulator)
        np.testing.assert_array_equal(found["claw"][:3], env.state[:3])
        np.testing.assert_array_equal(found["crate"][:2], env.state[3:5])
        assert world.GetOutputPort("crate.active").Eval(simulator.get_context())[0] == env.state[5]
    assert env.state[5] == 1.0, "the crate was never held"


def test_a_clone_replays_from_the_middle_though_the_environment_is_elsewhere() -> None:
    world, simulator = started()
    go(simulator, world, WANTED, 3)
    clone = simulator.get_context().Clone()
    go(simulator, world, WANTED, 9)
    other = Simulator(world, clone)
    other.AdvanceTo(9 * ic.TICK)
    for name, value in values(world, simulator).items():
        np.testing.assert_array_equal(value, values(world, other)[name])


def test_readings_have_the_declared_noise_and_repeat() -> None:
    world, simulator = started(noise_std={"crate.x": 0.01, "claw.y": 0.02})
    seen = []
    for tick in range(1, 41):
        go(simulator, world, WANTED, tick)
        truth, read = values(world, simulator), values(world, simulator, "measured")
        seen.append([*(read["crate"] - truth["crate"][:2]), *(read["claw"] - truth["claw"][:3])])
    std = np.std(seen, axis=0)
    assert 0.006 < std[0] < 0.014
    assert 0.012 < std[3] < 0.028
    np.testing.assert_array_equal(std[[1, 2, 4]], 0.0)


def test_the_end_of_an_episode_freezes_it() -> None:
    world, simulator = started()
    crate = values(world, simulator)["crate"]
    ways = [np.append(crate[:2], 0.0)] * 12 + [np.append(crate[:2], 1.0)] + [np.array([1.2, 0.5, 1.0])] * 20
    for tick, wanted in enumerate(ways, 1):
        go(simulator, world, wanted, tick)
    claw = values(world, simulator)["claw"]
    np.testing.assert_array_equal(claw[3:], [1.0, 1.0, 0.0])  # reward, terminated, truncated
    go(simulator, world, np.zeros(3), len(ways) + 5)
    np.testing.assert_array_equal(values(world, simulator)["claw"], claw)


def test_a_turn_goes_the_short_way_and_an_absolute_number_as_it_is() -> None:
    space = ic.StateSpace("ship", (ic.Variable("h", "rad", -np.pi, np.pi, "angle"), ic.Variable("v")))
    thing = ic.StateSpace("thing", (ic.Variable("x"),))
    terms = (ic.RootTerm("h", scale=2.0), ic.RootTerm("v", relative=False))
    wanted = dataclasses.replace(spec(), objects={"ship": space, "thing": thing}, interactions=["ship->thing"],
                                 actions=terms, noise_std={})  # fmt: skip
    np.testing.assert_allclose(wanted.action(np.array([-3.0, 5.0]), np.array([3.0, 1.0])), [2 * (2 * np.pi - 6), 5.0])


class Random(CrateEnv):
    """Drifts at random."""

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict]:
        result = super().step(action)
        self.state[3] += 0.001 * self.np_random.standard_normal()
        return result


class Secret(CrateEnv):
    """Has a state that nobody is told of."""

    count = 0

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict]:
        self.count += 1
        result = super().step(action)
        self.state[3] += 0.001 * self.count
        return result


def test_random_numbers_of_a_stochastic_environment_are_the_worlds() -> None:
    with pytest.raises(ic.InputError, match="say so with stochastic=True"):
        OpenEnvironment(spec(make=Random))
    world, simulator = started(make=Random, stochastic=True)
    go(simulator, world, WANTED, 6)
    again, other = started(make=Random, stochastic=True)
    go(other, again, WANTED, 6)
    first = values(world, simulator)["crate"]
    np.testing.assert_array_equal(first, values(again, other)["crate"])
    go(simulator, world, WANTED, 7)
    assert values(world, simulator)["crate"][0] != first[0]


@pytest.mark.parametrize(
    ("changed", "what"),
    [
        ({"make": Secret}, "its snapshot does not hold all of its state"),
        ({"actions": (ic.RootTerm("x"),)}, "an action has 3 number"),
        ({"actions": (ic.RootTerm("z"),) * 3}, "claw has no variable 'z'"),
        ({"steps_per_tick": 0}, "steps_per_tick is 0"),
        ({"noise_std": {"crate.z": 0.1}}, "noise_std of 'crate.z'"),
        ({"noise_std": {"crate.x": -0.1}}, "noise_std of 'crate.x'"),
    ],
)
def test_what_does_not_fit_is_refused(changed: dict[str, object], what: str) -> None:
    with pytest.raises(ic.InputError, match=what):
        OpenEnvironment(spec(**changed))


@pytest.mark.parametrize(
    ("changed", "what"),
    [
        ({"read": lambda env: {"claw": env.state[:3]}}, "`read` gives no crate; it gives claw"),
        ({"read": lambda env: {"claw": env.state[:3], "crate": env.state[:1]}}, "crate: shape"),
        ({"read": lambda env: {"claw": env.state[:3], "crate": [np.nan, 0]}}, "crate: x is not a finite number"),
        ({"active": lambda env: {}}, "`active` does not tell about claw->crate"),
    ],
)
def test_what_is_read_wrongly_is_told(changed: dict[str, object], what: str) -> None:
    with pytest.raises(ic.InputError, match=what):
        OpenEnvironment(spec(**changed)).start(0)
