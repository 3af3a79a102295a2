"""Rewards and ends of episodes: a goal's conditions, a path's progress and distance."""

import numpy as np
import pytest

import ichain_drake as ic
from ichain_drake.environments.judges import GoalJudge, PathJudge
from ichain_drake.timing import FRAMES_PER_TICK, TICK

THING = ic.StateSpace("thing", (ic.Variable("level"), ic.Variable("lid", kind="binary"), ic.Variable("x", "m")))
GRAPH = ic.InteractionGraph({"hand": ic.StateSpace("hand", (ic.Variable("x", "m"),)), "thing": THING}, ["hand->thing"])


def states(level: float, lid: float = 0.0, x: float = 0.0) -> dict[str, np.ndarray]:
    return {"hand": np.zeros(1), "thing": np.array([level, lid, x])}


def flags(active: float) -> dict[str, np.ndarray]:
    return {"thing": np.array([active])}


def test_rewards_are_changes_of_the_share_that_holds() -> None:
    judge = GoalJudge(["thing.level >= 0.5 and not hand->thing", "keep thing.x within 0.1", "thing.lid == 1"], GRAPH)
    judge.begin(states(0.0, x=3.0), flags(1.0))
    rewards = []
    for level, lid, x, active in [(0.6, 0, 3, 1), (0.6, 0, 3.2, 1), (0.6, 1, 3.05, 1), (0.6, 1, 2.95, 0)]:
        verdict = judge.see({}, [states(level, lid, x)], flags(active))
        rewards.append(verdict.reward)
    assert rewards == pytest.approx([0.25, -0.25, 0.5, 0.25])
    assert verdict.terminated
    assert verdict.success


def test_every_sign_is_read() -> None:
    for text, yes, no in [
        ("thing.level > 1", 1.1, 1.0),
        ("thing.level < 1", 0.9, 1.0),
        ("thing.level <= start", 0.5, 0.6),
        ("thing.level >= start", 0.5, 0.4),
    ]:
        judge = GoalJudge([text], GRAPH)
        judge.begin(states(0.5), flags(0.0))
        assert judge.see({}, [states(yes)], flags(0.0)).success, text
        assert not judge.see({}, [states(no)], flags(0.0)).success, text
    judge = GoalJudge(["hand->thing"], GRAPH)
    judge.begin(states(0.0), flags(0.0))
    assert judge.see({}, [states(0.0)], flags(1.0)).success


def test_how_near_is_equal_is_not_made_up() -> None:
    with pytest.raises(ic.InputError, match="thing.level is a real number"):
        GoalJudge(["thing.level == 0.5"], GRAPH)
    with pytest.raises(ic.InputError, match="no goal is given"):
        GoalJudge([], GRAPH)


def test_who_keeps_to_a_path_at_its_pace_gets_one_a_tick() -> None:
    scenario = ic.load_scenario("car_game", physics="ideal")
    limits = scenario.path_limits()
    path = ic.TimedPath(np.array([[0.0, 0.0], [150.0, 0.0]]), limits)
    judge = PathJudge(scenario, path, 2)
    assert judge.names == ("wanted.x+1", "wanted.y+1", "wanted.x+2", "wanted.y+2")
    car = scenario.graph.objects["car"]

    def at(x: float, y: float = 0.0) -> dict[str, np.ndarray]:
        state = np.zeros(len(car))
        state[:2] = x, y
        return {"car": state}

    judge.begin(at(0.0), {})
    step = limits.speed * TICK
    np.testing.assert_allclose(judge.observe(at(0.0)), [step, 0, 2 * step, 0])
    verdict, place = None, 0.0
    while verdict is None or not verdict.terminated:
        frames = [at(place + step * k / FRAMES_PER_TICK) for k in range(FRAMES_PER_TICK + 1)]
        place += step
        verdict = judge.see(frames[-1], frames, {})
        if place < 150 - step:
            assert verdict.reward == pytest.approx(1.0, abs=0.1)
    assert verdict.success
    judge.begin(at(0.0), {})
    aside = judge.see(at(0.0, 5.0), [at(0.0, 5.0)] * 2, {})
    assert aside.reward == pytest.approx(-5.0 / limits.corridor)
