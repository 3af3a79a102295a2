"""Environments that don't do what they declare: named with the variable and when."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from ichain_drake.errors import InputError
from ichain_drake.objects import Joystick, ObjectSettings

gymnasium = pytest.importorskip("gymnasium", reason="Gymnasium is missing: pip install 'ichain_drake[games]'")

from ichain_drake.objects.gymnasium import ActionTerm, GameEnvironment, GameSpec, GymnasiumGame  # noqa: E402

Step = Callable[["Slope", Any], Any]


class Slope(gymnasium.Env):
    """A ball on a slope; what it does otherwise, a test says."""

    observation_space = gymnasium.spaces.Box(-2.0, 2.0, (2,), np.float64)
    action_space = gymnasium.spaces.Box(-1.0, 1.0, (1,), np.float64)

    def __init__(self, pace: float = 0.01) -> None:
        self.pace = pace

    def reset(self, *, seed: int | None = None, options: Any = None) -> Any:
        super().reset(seed=seed)
        self.state = np.array([0.0, 0.1])
        return self.state.copy(), {}

    def step(self, action: Any) -> Any:
        self.state = self.state + self.pace * np.array([self.state[1], float(action[0])])
        return self.state.copy(), 0.0, False, False, {}


def opened(make: Callable[[], Any], **more: Any) -> GameEnvironment:
    return GameEnvironment(GameSpec(lambda mode: make(), (ActionTerm("x_axis"),), **more))


def stepped(environment: GameEnvironment, count: int = 200) -> None:
    system = GymnasiumGame("game", {"stick": Joystick.state_space}, environment, settings=ObjectSettings(3))
    state = system.default_state()
    for _ in range(count):
        state = system.step(state, {"stick": np.array([0, 0, 1.0, 0])}, {"stick": np.float64(1)}, np.zeros(0), 1 / 30)


def test_one_that_keeps_to_its_space_is_fine() -> None:
    stepped(opened(Slope), 50)


def test_observations_that_leave_the_space_are_named() -> None:
    with pytest.raises(InputError, match=r"environment Slope: observation_\d is 2\.\d+ after \d+ steps; its"):
        stepped(opened(lambda: Slope(0.5)))


class Far(Slope):
    def reset(self, *, seed: int | None = None, options: Any = None) -> Any:
        super().reset(seed=seed)
        self.state = np.array([7.0, 0.0])
        return self.state.copy(), {}


class Nan(Slope):
    def step(self, action: Any) -> Any:
        _, *rest = super().step(action)
        late = self.state[0] > 0.02
        return np.array([math.nan if late else self.state[0], 0.0]), *rest


class OldReset(Slope):
    def reset(self, *, seed: int | None = None, options: Any = None) -> Any:
        return super().reset(seed=seed)[0]


class OlderReset(Slope):
    def reset(self) -> Any:  # type: ignore[override]
        return super().reset()[0]


class OldStep(Slope):
    def step(self, action: Any) -> Any:
        observation, reward, done, _, info = super().step(action)
        return observation, reward, done, info


class OwnGenerator(Slope):
    def step(self, action: Any) -> Any:
        self.mine = getattr(self, "mine", np.random.default_rng(0))
        observation, *rest = super().step(action)
        self.state = observation + 0.001 * self.mine.standard_normal(2)
        return self.state.copy(), *rest


class OldGenerator(Slope):
    np_random = np.random.RandomState(0)  # type: ignore[assignment]  # noqa: NPY002

    def reset(self, *, seed: int | None = None, options: Any = None) -> Any:
        self.state = np.array([0.0, 0.1])
        return self.state.copy(), {}


@pytest.mark.parametrize(
    ("kind", "message"),
    [
        (Far, "observation_0 is 7 at its start; its space declares -2 to 2"),
        (Nan, r"observation_0 is nan after \d+ steps"),
        (OldReset, r"environment OldReset: its reset gives no \(observation, info\); it follows an older interface"),
        (OlderReset, "its reset takes no seed and options"),
        (OldStep, r"its step gives 4 values, not \(observation, reward"),
        (OwnGenerator, "draws from a random generator of its own"),
        (OldGenerator, "its np_random is no NumPy Generator"),
    ],
)
def test_what_does_not_keep_to_the_interface(kind: type[Slope], message: str) -> None:
    with pytest.raises(InputError, match=message) as caught:
        stepped(opened(kind))
    assert "\n" not in str(caught.value)
