"""Algorithm 1 on chains of any length, with learned inverses and with prediction."""

import itertools

import numpy as np
import pandas as pd
import pytest

from ichain_drake.control.tracking.levels import InverseLevel, PredictiveLevel, PredictiveWeights
from ichain_drake.control.tracking.move_to import MoveTo, RobotLevel
from ichain_drake.demonstrations import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.learning.chain.chain import LearnedChain, LinkCandidates, learn_chain
from ichain_drake.learning.chain.link import EstimatorSpec
from ichain_drake.learning.estimators import make_estimator
from ichain_drake.learning.frozen import freeze
from ichain_drake.state import StateSpace, Variable
from ichain_drake.timing import TICK

TWO = StateSpace("two", (Variable("a"), Variable("b")))
LINEAR = (EstimatorSpec("polynomial", {"degree": 1}),)


def after_tick(child: np.ndarray, parent_next: np.ndarray) -> np.ndarray:
    """Every link drags its child most of the way, turned a little: it needs a few ticks to follow."""
    return child + 0.75 * (parent_next @ np.array([[1.0, 0.2], [-0.2, 1.0]]) - child)


def advance(states: list[np.ndarray], command: np.ndarray) -> list[np.ndarray]:
    after = [command]
    for child in states[1:]:
        after.append(after_tick(child, after[-1]))
    return after


def learned(length: int, rows: int = 300) -> LearnedChain:
    """A chain of so many objects, learned from a random walk of the first."""
    rng = np.random.default_rng(length)
    names = [f"o{i}" for i in range(length)]
    states = [np.zeros(2) for _ in names]
    walk, data = np.zeros(2), []
    for _ in range(rows):
        data.append(np.concatenate([*states, walk]))
        walk = np.clip(walk + rng.uniform(-0.5, 0.5, 2), -2, 2)
        states = advance(states, walk)
    columns = [f"{n}.{v}" for n in (*names, "command") for v in "ab"]
    table = pd.DataFrame(np.array(data), columns=columns).assign(time=TICK * np.arange(rows))
    table[["command.a", "command.b"]] = table[["command.a", "command.b"]].shift(-1).ffill()
    graph = InteractionGraph(dict.fromkeys(names, TWO), list(itertools.pairwise(names)))
    candidates = LinkCandidates(LINEAR, LINEAR, features=("raw",), forward_actions=("next",))
    return learn_chain([Demonstration(table)], graph, names[-1], ["a", "b"], {"*": candidates})


def policy(chain: LearnedChain, kind: str) -> MoveTo:
    levels = []
    for link in chain.links:
        if kind == "inverse":
            levels.append(InverseLevel(link.best_inverse.model, link.child_limit))
        else:
            levels.append(
                PredictiveLevel(
                    link.forward.model, TWO, (0, 1), link.child_scale, link.parent_lower, link.parent_upper,
                    link.parent_scale, PredictiveWeights(horizon=4),
                )
            )  # fmt: skip
    robot = RobotLevel(TWO, chain.hand_limit, chain.command, chain.command_lower, chain.command_upper)
    return MoveTo(tuple(levels), robot)


@pytest.mark.parametrize("kind", ["inverse", "predictive"])
@pytest.mark.parametrize("length", [2, 3, 4, 5, 6])
def test_the_last_object_of_a_chain_of_any_length_is_brought_to_its_target(length: int, kind: str) -> None:
    """Two runs in one batch, in the true world; the hand never moves faster than it did in the demonstrations."""
    chain = learned(length)
    of = policy(chain, kind)
    target = np.array([[0.5, -0.4], [-0.3, 0.6]])
    states, memory = [np.zeros((2, 2)) for _ in range(length)], np.zeros((2, of.memory_size))
    for _ in range(60):
        command, memory, handed_down = of.decide(states, np.repeat(target[:, None], of.lookahead, axis=1), memory)
        assert len(handed_down) == length - 1
        assert (np.abs(command - states[0]) <= chain.hand_limit + 1e-9).all()
        assert ((command >= chain.command_lower) & (command <= chain.command_upper)).all()
        states = advance(states, command)
    np.testing.assert_allclose(states[-1], target, atol=0.02)


def test_each_run_of_a_batch_is_decided_for_itself() -> None:
    of, rng = policy(learned(3), "predictive"), np.random.default_rng(0)
    states, wanted = [rng.uniform(-1, 1, (4, 2)) for _ in range(3)], rng.uniform(-1, 1, (4, 4, 2))
    memory = np.zeros((4, of.memory_size))
    together = of.decide(states, wanted, memory)
    for i in range(4):
        alone = of.decide([s[i : i + 1] for s in states], wanted[i : i + 1], memory[i : i + 1])
        np.testing.assert_allclose(alone[0][0], together[0][i], atol=1e-9)
        np.testing.assert_allclose(alone[1][0], together[1][i], atol=1e-9)


def test_levels_of_both_kinds_keep_their_own_memory() -> None:
    chain = learned(3)
    lower, upper = policy(chain, "inverse").levels[0], policy(chain, "predictive").levels[1]
    robot = policy(chain, "inverse").robot
    mixed = MoveTo((lower, upper), robot)
    assert mixed.memory_size == upper.memory_size == 1 + 4 * 2
    assert mixed.lookahead == 4
    states = [np.zeros((1, 2))] * 3
    _, memory, _ = mixed.decide(states, np.ones((1, 4, 2)), np.zeros((1, 9)))
    assert memory[0, 0] == 1.0


class PlansAhead:
    """A level that wants its parent at 1, 2 and 3 in the three coming ticks, times `factor`."""

    memory_size, lookahead = 0, 3

    def __init__(self, factor: float) -> None:
        self.factor = factor
        self.seen: list[np.ndarray] = []

    def decide(self, child, parent, wanted, memory):
        self.seen.append(wanted.copy())
        return self.factor * np.arange(1.0, 4.0).reshape(1, 3, 1) * np.ones((1, 3, 2)), memory


def test_of_a_plan_the_next_tick_is_commanded_and_reported_and_all_of_it_is_handed_down() -> None:
    lower, upper = PlansAhead(0.1), PlansAhead(0.01)
    robot = RobotLevel(TWO, np.full(2, 9.0), None, np.full(2, -9.0), np.full(2, 9.0))
    command, _, reported = MoveTo((lower, upper), robot).decide(
        [np.zeros((1, 2))] * 3, np.ones((1, 3, 2)), np.zeros((1, 0))
    )
    np.testing.assert_allclose(command, 0.1)
    np.testing.assert_allclose(reported, [np.full((1, 2), 0.1), np.full((1, 2), 0.01)])
    np.testing.assert_allclose(lower.seen[0][0, :, 0], [0.01, 0.02, 0.03])


def test_the_number_of_states_must_fit() -> None:
    of = policy(learned(2), "inverse")
    with pytest.raises(InputError, match="3 states given for a chain of 2 objects"):
        of.decide([np.zeros((1, 2))] * 3, np.zeros((1, 1, 2)), np.zeros((1, 0)))


def test_the_robot_level_corrects_with_the_learned_command_and_stays_in_range() -> None:
    rows = np.random.default_rng(0).uniform(-1, 1, (50, 2))
    command = freeze(make_estimator("polynomial", degree=1).fit(rows, rows + 0.1))
    robot = RobotLevel(TWO, np.full(2, 0.3), command, np.full(2, -9.0), np.full(2, 0.35))
    wanted = np.array([[0.2, 2.0], [-0.9, 0.0]])
    together = robot.decide(np.zeros((2, 2)), wanted)
    # Limited to a step of 0.3 in a straight line, then 0.1 more as learned, then at most 0.35.
    np.testing.assert_allclose(together, [[0.13, 0.35], [-0.2, 0.1]], atol=1e-3)
    np.testing.assert_allclose(robot.decide(np.zeros((1, 2)), wanted[:1])[0], together[0], atol=1e-12)
