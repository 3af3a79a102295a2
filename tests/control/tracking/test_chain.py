"""From a learned chain to a controller: what validation chooses, and that names play no part."""

import itertools
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from ichain_drake.control.tracking.chain import (
    METHODS,
    ChainController,
    Choice,
    ControlCandidates,
    _best,
    make_controller,
)
from ichain_drake.control.tracking.levels import InverseLevel, PredictiveLevel
from ichain_drake.control.tracking.path import PathLimits, TimedPath, path_error
from ichain_drake.control.tracking.validation import make_cases, validation_error
from ichain_drake.demonstrations import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.learning.chain.chain import LearnedChain, LinkCandidates, learn_chain
from ichain_drake.learning.chain.link import EstimatorSpec
from ichain_drake.state import Role, StateSpace, Variable
from ichain_drake.timing import TICK

LIMITS = PathLimits(speed=30.0, turn_rate=2.0, spacing=1.0, smoothing=20.0, tolerance=3.0)
QUICK = ControlCandidates(efforts=(0.02, 5.0), cases=4, ticks=20)
NAMES = ("hand", "lever", "sled")


def spaces(words: tuple[str, ...]) -> dict[str, StateSpace]:
    """A hand with p, q; a lever that mirrors it; a sled with velocity and position, pushed by the lever."""
    h, lever, sled, p, q, m, n, x, y, v, w = words
    return {
        h: StateSpace(h, (Variable(p, "m", role=Role("position", "r", "x")), Variable(q, "m"))),
        lever: StateSpace(lever, (Variable(m), Variable(n))),
        sled: StateSpace(
            sled,
            (
                Variable(x, "px", role=Role("position", "s", "x")),
                Variable(y, "px", role=Role("position", "s", "y")),
                Variable(v, "px/s"),
                Variable(w, "px/s"),
            ),
        ),
    }


PLAIN = (*NAMES, "p", "q", "m", "n", "x", "y", "v", "w")
RANDOM = ("zq", "aa", "mmm", "g7", "b1", "kk", "c2", "u9", "d3", "tt", "e4")


def lever_of(hand: np.ndarray) -> np.ndarray:
    return np.tanh(4.0 * hand)


def sled_after(sled: np.ndarray, lever: np.ndarray) -> np.ndarray:
    velocity = 0.6 * sled[..., 2:] + 40.0 * lever
    return np.concatenate([sled[..., :2] + TICK * velocity, velocity], axis=-1)


def demonstration(words: tuple[str, ...], rows: int = 260) -> Demonstration:
    rng = np.random.default_rng(0)
    hand, sled, data = np.zeros(2), np.zeros(4), []
    goal = np.zeros(2)
    for k in range(rows):
        if k % 6 == 0:
            goal = rng.uniform(-0.15, 0.15, 2) - 0.0005 * sled[:2]
        noisy_lever = lever_of(hand) + 0.003 * rng.standard_normal(2)
        data.append(np.concatenate([hand, noisy_lever, sled]))
        hand = np.clip(hand + np.clip(goal - hand, -0.08, 0.08), -0.2, 0.2)
        sled = sled_after(sled, lever_of(hand)) + np.array([0.1, 0.1, 0.2, 0.2]) * rng.standard_normal(4)
    columns = [f"{o}.{v}" for o, s in spaces(words).items() for v in s.names]
    return Demonstration(pd.DataFrame(np.array(data), columns=columns).assign(time=TICK * np.arange(rows)))


def learned(words: tuple[str, ...] = PLAIN) -> LearnedChain:
    objects = spaces(words)
    graph = InteractionGraph(objects, list(itertools.pairwise(objects)))
    candidates = LinkCandidates(
        (EstimatorSpec("polynomial", {"degree": 3}),), (EstimatorSpec("polynomial", {"degree": 3}),), aims=(1, 2)
    )
    return learn_chain([demonstration(words)], graph, words[2], words[7:9], {"*": candidates})


@pytest.fixture(scope="module")
def chain() -> LearnedChain:
    return learned()


def follow(controller: ChainController, path: TimedPath) -> tuple[np.ndarray, bool]:
    """The controller in the true world without noise."""
    policy, hand, sled = controller.policy, np.zeros(2), np.concatenate([path.points[0], [0.0, 0.0]])
    memory, progress, places = np.zeros((1, policy.memory_size)), 0, [sled[:2]]
    for _ in range(200):
        progress = path.advance(sled[:2], progress, 4 * TICK)
        if path.near_end(progress):
            return np.array(places), True
        wanted = path.at_time(path.time[progress] + TICK * np.arange(1, policy.lookahead + 1))
        states = [hand[None], lever_of(hand)[None], sled[None]]
        command, memory, _ = policy.decide(states, wanted[None], memory)
        hand = command[0]
        sled = sled_after(sled, lever_of(hand))
        places.append(sled[:2])
    return np.array(places), False


def test_the_mirroring_link_is_controlled_by_its_inverse(chain: LearnedChain) -> None:
    assert [link.is_static for link in chain.links] == [True, False]
    levels = make_controller(chain, "predictive", LIMITS, QUICK).policy.levels
    assert [type(level) for level in levels] == [InverseLevel, PredictiveLevel]


@pytest.mark.parametrize("method", METHODS)
def test_a_learned_chain_follows_a_path_that_it_has_never_seen(chain: LearnedChain, method: str) -> None:
    t = np.linspace(0, 2 * np.pi, 500)
    path = TimedPath(np.stack([60 * np.sin(t), 40 * np.sin(2 * t)], axis=1), LIMITS)
    places, completed = follow(make_controller(chain, method, LIMITS, QUICK), path)
    assert completed
    assert path_error(places, path) < 1.0  # px, with 10 px a tick


@pytest.mark.parametrize("method", METHODS)
def test_the_option_with_the_least_validation_error_is_taken(chain: LearnedChain, method: str) -> None:
    said: list[str] = []
    controller = make_controller(chain, method, LIMITS, QUICK, said.append)
    errors = [o.error for o in controller.options]
    assert len(errors) == len(said) == (2 if method == "predictive" else len(chain.links[-1].inverses))
    assert controller.choice.error == min(errors)
    assert len(set(errors)) > 1
    if method == "predictive":
        assert controller.choice.weights is not None
        assert controller.choice.weights.effort == 0.02  # not 5, which hardly moves


def test_validation_is_repeatable_and_a_lost_policy_is_infinitely_bad(chain: LearnedChain) -> None:
    cases = make_cases(chain, LIMITS, 4, 20, seed=3)
    for one, two in zip(cases, make_cases(chain, LIMITS, 4, 20, seed=3), strict=True):
        np.testing.assert_array_equal(one.path.points, two.path.points)
    policy = make_controller(chain, "predictive", LIMITS, QUICK).policy
    assert validation_error(chain, policy, cases, 1) == validation_error(chain, policy, cases, 1) < 2.0
    # One that is lost of four is not counted, two are.
    off = [replace(c, start=c.start + [1e4, 0.0, 0.0, 0.0]) for c in cases]
    assert validation_error(chain, policy, [*cases[:3], off[3]], 1) < 2.0
    assert validation_error(chain, policy, [*cases[:2], *off[2:]], 1) == np.inf

    class Idle:
        memory_size, lookahead = 0, 1

        def decide(self, states: list[np.ndarray], wanted: np.ndarray, memory: np.ndarray) -> tuple:
            return np.zeros((len(wanted), 2)), memory, []

    assert validation_error(chain, Idle(), cases, 1) == np.inf  # type: ignore[arg-type]


def test_names_play_no_part(chain: LearnedChain) -> None:
    """Every object and variable renamed to random words: the same models and the same decisions, to the last bit."""
    renamed = learned(RANDOM)
    for one, two in zip(chain.links, renamed.links, strict=True):
        assert str(one.forward.spec) == str(two.forward.spec)
        for name, array in one.forward.model.frozen.arrays().items():
            np.testing.assert_array_equal(array, two.forward.model.frozen.arrays()[name])
    controllers = [make_controller(c, "predictive", LIMITS, QUICK) for c in (chain, renamed)]
    path = TimedPath(np.array([[0.0, 0.0], [80.0, 30.0]]), LIMITS)
    np.testing.assert_array_equal(*(follow(c, path)[0] for c in controllers))


def test_what_can_not_be_controlled_or_validated_is_refused(chain: LearnedChain) -> None:
    with pytest.raises(InputError, match="control.method 'magic': choose predictive or inverse"):
        make_controller(chain, "magic", LIMITS)
    with pytest.raises(InputError, match="no demonstration of sled is longer than 411 ticks"):
        make_cases(chain, LIMITS, 4, 400, seed=0)
    with pytest.raises(InputError, match="no part of the demonstrations of sled can be a validation path"):
        make_cases(chain, PathLimits(speed=1e4), 4, 20, seed=0)


def test_without_validation_inverses_are_chosen_by_their_score_and_weights_in_the_middle() -> None:
    scored = [Choice(str(s), np.nan, SimpleNamespace(score=s)) for s in (0.9, 0.2, 0.5)]  # type: ignore[arg-type]
    assert _best(scored).label == "0.9"
    assert _best([Choice(name, np.inf) for name in "abc"]).label == "b"
    assert _best([Choice("a", np.inf), Choice("b", 2.0), Choice("c", 1.0)]).label == "c"
