"""Gymnasium's environments as objects: contract, replay, spaces, ends, and what is refused."""

import math
import re
import subprocess
import sys
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

import ichain_drake
from ichain_drake.errors import InputError
from ichain_drake.objects import Joystick, ObjectSettings, check_object
from ichain_drake.state import StateSpace, Variable
from ichain_drake.timing import FRAME

gymnasium = pytest.importorskip("gymnasium", reason="Gymnasium is missing: pip install 'ichain_drake[games]'")

from ichain_drake.objects.gymnasium import (  # noqa: E402  (after the check for the extra)
    ActionTerm,
    AttributeSnapshot,
    GameEnvironment,
    GameSpec,
    GymnasiumGame,
)
from ichain_drake.objects.gymnasium.spaces import FlatSpace, flat_values, space_variables  # noqa: E402

STICK = {"stick": Joystick.state_space}
PUSH = (ActionTerm("x_axis", scale=2.0),)
SPECS = {
    "pendulum": GameSpec("Pendulum-v1", PUSH, steps_per_frame=Fraction(2, 3)),
    "cart_pole": GameSpec("CartPole-v1", (ActionTerm("x_axis", 0.5, 0.5),)),
    "mountain_car": GameSpec("MountainCarContinuous-v0", (ActionTerm("x_axis"),)),
    "frozen_lake": GameSpec("FrozenLake-v1", (ActionTerm("x_axis", 1.0, 1.0),), stochastic=True),
}


def game(spec: GameSpec, **settings: float) -> GymnasiumGame:
    return GymnasiumGame("game", STICK, GameEnvironment(spec), settings=ObjectSettings(3, **settings))  # type: ignore[arg-type]


def stick_at(x: float) -> np.ndarray:
    return np.array([0.0, 0.0, x, 0.0])


def played(system: GymnasiumGame, seconds: float, x: float, context=None):
    """The context after some time with the stick held."""
    simulator = Simulator(system, context)
    port = system.GetInputPort("stick")
    port.FixValue(simulator.get_mutable_context(), stick_at(x))
    simulator.Initialize()
    simulator.AdvanceTo(seconds)
    return simulator.get_context()


@pytest.mark.parametrize("spec", SPECS.values(), ids=SPECS.keys())
def test_an_environment_keeps_the_contract_of_objects(spec: GameSpec) -> None:
    check_object(game(spec))


def test_it_does_what_the_environment_alone_does() -> None:
    env = gymnasium.make("CartPole-v1")
    observation, _ = env.reset(seed=5)
    system = game(SPECS["cart_pole"], seed=5)
    state = system.default_state()
    np.testing.assert_array_equal(state[:4], observation)
    for k in range(12):
        x = (-1.0) ** (k // 2)
        state = system.step(state, {"stick": stick_at(x)}, {"stick": np.float64(1)}, np.zeros(0), FRAME)
        observation, reward, _, _, _ = env.step(int(x > 0))
        np.testing.assert_array_equal(state[:4], observation)
        assert state[4] == reward


def test_steps_follow_the_clock() -> None:
    """20 steps a second, 30 frames: two of three frames make a step."""
    system = game(SPECS["pendulum"])
    steps = system.state_space.index("steps")
    counts = []
    state = system.default_state()
    for _ in range(9):
        state = system.step(state, {"stick": stick_at(0.1)}, {"stick": np.float64(1)}, np.zeros(0), FRAME)
        counts.append(state[steps])
    assert counts == [0, 1, 2, 2, 3, 4, 4, 5, 6]


def test_a_cloned_context_goes_on_in_the_same_way() -> None:
    """Also after another context has used the same environment, for a stochastic one too."""
    system = game(SPECS["frozen_lake"], seed=1)
    middle = played(system, 0.2, 0.0).Clone()
    ends = []
    for _ in range(2):
        ends.append(system.get_state(played(system, 0.5, 1.0, middle.Clone())))
        played(system, 0.4, -1.0, middle.Clone())
    np.testing.assert_array_equal(*ends)


def test_stochastic_steps_are_a_function_of_the_seed() -> None:
    def walk(seed: int) -> list[float]:
        system = game(SPECS["frozen_lake"], seed=seed)
        context = system.CreateDefaultContext()
        out = []
        for k in range(1, 9):
            played(system, k * FRAME, 0.0, context)
            out.append(float(system.get_state(context)[0]))
        return out

    assert walk(2) == walk(2)
    assert len({tuple(walk(s)) for s in range(4)}) > 1


def test_an_inactive_parent_counts_as_zero() -> None:
    system = game(SPECS["pendulum"])
    state = system.step(
        system.default_state(), {"stick": stick_at(0.0)}, {"stick": np.float64(1)}, np.zeros(0), FRAME
    )  # the first frame of three makes no step
    off = system.step(state, {"stick": stick_at(0.9)}, {"stick": np.float64(0)}, np.zeros(0), FRAME)
    zero = system.step(state, {"stick": stick_at(0.0)}, {"stick": np.float64(1)}, np.zeros(0), FRAME)
    pushed = system.step(state, {"stick": stick_at(0.9)}, {"stick": np.float64(1)}, np.zeros(0), FRAME)
    np.testing.assert_array_equal(off, zero)
    assert np.abs(pushed - zero).max() > 1e-3


def test_an_episode_that_ends_says_so_and_stays() -> None:
    system = game(SPECS["cart_pole"])
    context = played(system, 1.0, 1.0)  # pushed one way the pole falls
    assert system.GetOutputPort("terminated").Eval(context) == [1.0]
    assert system.GetOutputPort("truncated").Eval(context) == [0.0]
    fallen = system.get_state(context)
    later = system.get_state(played(system, 2.0, 1.0, context.Clone()))
    np.testing.assert_array_equal(later[:4], fallen[:4])
    assert system.GetOutputPort("reward").Eval(context) == [0.0]
    # The environment of an ended episode serves another state as if nothing had been.
    fresh = game(SPECS["cart_pole"])
    again, other = system.default_state(), fresh.default_state()
    for _ in range(5):
        arguments = ({"stick": stick_at(-1.0)}, {"stick": np.float64(1)}, np.zeros(0), FRAME)
        again, other = system.step(again, *arguments), fresh.step(other, *arguments)
        np.testing.assert_array_equal(again, other)


def test_a_limit_of_steps_truncates() -> None:
    system = game(GameSpec("Pendulum-v1", PUSH, max_steps=7))
    context = played(system, 1.0, 0.0)
    assert system.GetOutputPort("truncated").Eval(context) == [1.0]
    assert system.get_state(context)[system.state_space.index("steps")] == 7
    assert GameEnvironment(GameSpec("Pendulum-v1", PUSH))._max_steps == 200  # what it is registered with
    assert GameEnvironment(GameSpec("Pendulum-v1", PUSH, max_steps=math.inf))._max_steps == math.inf


def test_ends_are_in_the_truth_and_not_measured() -> None:
    space = game(SPECS["pendulum"]).state_space
    assert space.observable.names == ("observation_0", "observation_1", "observation_2")
    assert space.variables[0].lower == -1.0
    assert {"reward", "terminated", "truncated", "state_0"} <= set(space.names)


def test_variables_can_be_declared_and_read() -> None:
    variables = (Variable("angle", "rad", -math.pi, math.pi, "angle"), Variable("rate", "rad/s"))
    spec = GameSpec("Pendulum-v1", PUSH, "pendulum", variables, lambda env, _: np.array(env.state))
    environment = GameEnvironment(spec)
    assert environment.space.type == "pendulum"
    assert environment.space.observable.variables == variables


def test_what_is_measured_can_be_set_where_that_is_declared() -> None:
    def write(env, values):
        env.state = values.copy()

    variables = (Variable("angle", "rad", -math.pi, math.pi, "angle"), Variable("rate", "rad/s"))
    spec = GameSpec("Pendulum-v1", PUSH, "pendulum", variables, lambda env, _: np.array(env.state), write)
    system = game(spec)
    context = system.CreateDefaultContext()
    state = system.get_state(context)
    state[:2] = 0.5, -1.0
    system.set_state(context, state)
    np.testing.assert_array_equal(system.environment.inner(system.get_state(context)), [0.5, -1.0])

    plain = game(SPECS["pendulum"])
    context = plain.CreateDefaultContext()
    state = plain.get_state(context)
    plain.set_state(context, state)
    with pytest.raises(InputError, match="what it shows can't be set; declare `read` and `write`"):
        plain.set_state(context, state + np.eye(len(state))[0])


def test_nothing_is_drawn_unless_asked_for() -> None:
    pytest.importorskip("pygame", reason="pygame is missing: pip install 'ichain_drake[games]'")
    quiet = game(SPECS["pendulum"])
    assert quiet.environment.env.render_mode is None
    with pytest.raises(InputError, match="rendering is off; declare a render_mode"):
        quiet.render(quiet.CreateDefaultContext())
    drawn = game(GameSpec("Pendulum-v1", PUSH, render_mode="rgb_array"))
    picture = drawn.render(drawn.CreateDefaultContext())
    assert picture.shape == (500, 500, 3)


def test_spaces_become_variables_and_values_there_and_back() -> None:
    spaces = gymnasium.spaces
    space = spaces.Dict(
        {
            "force": spaces.Box(-1.0, 2.0, (2,), np.float32),
            "gear": spaces.Discrete(3, start=-1),
            "lamps": spaces.Tuple([spaces.MultiBinary(2), spaces.MultiDiscrete([2, 5])]),
        }
    )
    variables = space_variables(space, "observation")
    assert [v.kind for v in variables] == ["real", "real", "integer", "binary", "binary", "binary", "integer"]
    assert variables[2].name == "observation_gear"
    assert (variables[2].lower, variables[2].upper) == (-1.0, 1.0)
    flat = FlatSpace(space)
    assert flat.size == len(variables) == 7
    value = flat.value(np.array([-5.0, 0.5, 0.8, 0.7, 0.2, 3.0, 2.4]))
    assert space.contains(value)
    np.testing.assert_array_equal(flat_values(space, value), [-1.0, 0.5, 1.0, 1.0, 0.0, 1.0, 2.0])


class _Counter(gymnasium.Env):
    """Its state is a number, and something that no attribute named `state` shows."""

    def __init__(self) -> None:
        self.observation_space = gymnasium.spaces.Box(-1e6, 1e6, (1,), np.float64)
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (1,), np.float64)
        self.spec = None

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.state, self.secret = 0.0, 0
        return np.array([self.state]), {}

    def step(self, action):
        self.secret += 1
        self.state += self.secret
        return np.array([self.state]), 0.0, False, False, {}


TERM = (ActionTerm("x_axis"),)
REFUSALS = {
    "no state to be found": (GameSpec("Blackjack-v1", TERM), "nothing says how to read its whole state"),
    "not the whole state": (GameSpec(lambda _: _Counter(), TERM), "goes on in another way"),
    "undeclared chance": (GameSpec("FrozenLake-v1", TERM), "say so with stochastic=True"),
    "no such environment": (GameSpec("CartPool-v1", TERM), "environment 'CartPool-v1': .*CartPole"),
    "an old wish": (GameSpec("Pendulum-v1", TERM, keywords={"wind": 1}), "unexpected keyword argument 'wind'"),
    "too few terms": (GameSpec("Pendulum-v1", ()), r"an action has 1 number\(s\), 0 term"),
    "wrong variables": (GameSpec("Pendulum-v1", TERM, variables=(Variable("angle"),)), "has 3 numbers, 1 variables"),
    "nothing said to read": (GameSpec("Pendulum-v1", TERM, read=lambda e, _: e.state), "without `variables`"),
    "another number read": (
        GameSpec("Pendulum-v1", TERM, variables=(Variable("a"),), read=lambda e, _: e.state),
        "2 values are read for 1 variables",
    ),
    "no such attribute": (
        GameSpec("Pendulum-v1", TERM, snapshot=AttributeSnapshot(("status",))),
        "its attribute 'status' does not hold numbers",
    ),
    "no time": (GameSpec("Pendulum-v1", TERM, steps_per_frame=0), "steps_per_frame is 0"),
    "a time limit": (
        GameSpec(lambda _: gymnasium.make("Pendulum-v1"), TERM),
        "wrapped in a time limit, which counts for itself; use max_steps",
    ),
    "a space without size": (
        GameSpec(lambda _: _texting(), TERM),
        "kind Text has no fixed number of values",
    ),
}


def _texting() -> _Counter:
    env = _Counter()
    env.observation_space = gymnasium.spaces.Text(5)
    return env


@pytest.mark.parametrize(("spec", "message"), REFUSALS.values(), ids=REFUSALS.keys())
def test_refusals(spec: GameSpec, message: str) -> None:
    with pytest.raises(InputError, match=message) as refused:
        GameEnvironment(spec)
    assert "\n" not in str(refused.value)


def test_more_snapshot_is_enough() -> None:
    spec = GameSpec(lambda _: _Counter(), TERM, snapshot=AttributeSnapshot(("state", "secret")))
    check_object(game(spec))


def test_action_terms_name_what_the_parents_have() -> None:
    with pytest.raises(InputError, match="game: an action term reads a variable of stick: .*no variable 'pedal'"):
        game(GameSpec("Pendulum-v1", (ActionTerm("pedal"),)))
    with pytest.raises(InputError, match="reads parent 'foot'; its parents are stick"):
        game(GameSpec("Pendulum-v1", (ActionTerm("x_axis", parent="foot"),)))
    two = {**STICK, "foot": StateSpace("foot", (Variable("pedal"),))}
    with pytest.raises(InputError, match="reads parent ''; its parents are stick, foot"):
        GymnasiumGame("game", two, GameEnvironment(SPECS["pendulum"]))
    both = GymnasiumGame("game", two, GameEnvironment(GameSpec("Pendulum-v1", (ActionTerm("pedal", parent="foot"),))))
    check_object(both)


def test_pictures_have_too_many_numbers() -> None:
    pytest.importorskip("Box2D", reason="Box2D is missing: pip install 'ichain_drake[games]'")
    with pytest.raises(InputError, match="an observation has 27648 numbers; declare `variables` and how to `read`"):
        GameEnvironment(GameSpec("CarRacing-v3", TERM * 3))


def test_the_adapter_knows_no_game() -> None:
    for file in (Path(ichain_drake.__file__).parent / "objects" / "gymnasium_game").glob("*.py"):
        words = set(re.findall(r"[a-z]+", file.read_text().lower()))
        assert not words & {"racing", "carracing", "car", "wheel", "hull", "track", "box2d"}, file.name


def test_without_gymnasium_one_line_says_what_to_install() -> None:
    code = (
        "import sys; sys.modules['gymnasium'] = None\n"
        "from ichain_drake.objects.gymnasium import GameEnvironment, GameSpec\n"
        "try:\n    GameEnvironment(GameSpec('Pendulum-v1', ()))\n"
        "except Exception as error:\n    print(type(error).__name__, error)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == (
        "InputError this needs Gymnasium (gymnasium is missing); install it with `pip install 'ichain_drake[games]'`"
    )
