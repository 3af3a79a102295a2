"""Paths that are cut out of demonstrations, to choose a controller by."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ichain_drake.control.settings import TRACKING
from ichain_drake.control.tracking import validation
from ichain_drake.control.tracking.path import PathLimits, TimedPath
from ichain_drake.control.tracking.validation import ValidationCase, make_cases, validation_error
from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.state import FloatArray, Role, StateSpace, Variable
from ichain_drake.timing import TICK

TICKS, HALF = 20, TRACKING.smoothing // 2
LIMITS = PathLimits(speed=30.0)
CAR = StateSpace("car", (
    Variable("row"),
    Variable("x", "px", role=Role("position", "screen", "x")),
    Variable("y", "px", role=Role("position", "screen", "y")),
    Variable("heading", "rad", kind="angle", role=Role("orientation", "screen", "z")),
))  # fmt: skip


def chain(*pieces: FloatArray) -> Any:
    graph = InteractionGraph({"hand": CAR, "car": CAR}, [("hand", "car")])
    return SimpleNamespace(graph=graph, names=("hand", "car"), targets=(1, 2), validation=pieces)


def drive(rows: int, step: float = 10.0) -> FloatArray:
    """Along y, shaking a little; the first variable counts rows, the heading is nonsense."""
    t = np.arange(float(rows))
    return np.column_stack([t, (-1.0) ** t, step * t, np.full(rows, 3.0)])


def test_a_path_is_the_smoothed_drive_and_begins_in_the_middle_of_what_was_smoothed() -> None:
    cases = make_cases(chain(drive(80)), LIMITS, 5, TICKS, 0)
    assert len(cases) == 5
    rows = sorted(int(c.start[0]) - HALF for c in cases)
    assert len(set(rows)) == 5
    assert set(rows) <= set(range(0, 80 - TICKS - TRACKING.smoothing, TICKS // 4))
    for case in cases:
        assert np.abs(case.start[1]) < 0.1, "smoothed"
        assert case.start[2] == pytest.approx(10.0 * case.start[0])
        assert case.start[3] == pytest.approx(np.pi / 2, abs=0.1), "along the path, whatever was read"
        np.testing.assert_allclose(case.path.points[[0, -1], 1] - case.start[2], [0.0, 10.0 * (TICKS - 1)], atol=1e-9)
    again, other = (make_cases(chain(drive(80)), LIMITS, 5, TICKS, seed) for seed in (0, 1))
    assert [c.start[0] for c in again] == [c.start[0] for c in cases] != [c.start[0] for c in other]


def test_there_are_no_more_paths_than_the_demonstrations_have_room_for() -> None:
    needed = TICKS + TRACKING.smoothing
    assert len(make_cases(chain(drive(needed + 1), drive(needed + 1 + TICKS // 4)), LIMITS, 9, TICKS, 0)) == 3
    with pytest.raises(InputError, match=f"no demonstration of car is longer than {needed} ticks; record a longer"):
        make_cases(chain(drive(needed)), LIMITS, 9, TICKS, 0)


def test_where_it_stood_still_there_is_no_path() -> None:
    """A quarter of nominal speed is the least, 2.5 px a tick."""
    fast, slow = drive(80, step=2.8), drive(80, step=2.2)
    assert len(make_cases(chain(slow, fast), LIMITS, 99, TICKS, 0)) == len(
        make_cases(chain(fast), LIMITS, 99, TICKS, 0)
    )
    with pytest.raises(InputError, match="it hardly moves or turns too sharply for 30 a second"):
        make_cases(chain(slow), LIMITS, 99, TICKS, 0)


def straight(y: float = 0.0, speed: float = 30.0) -> ValidationCase:
    limits = PathLimits(speed=speed, corridor=10.0)
    return ValidationCase(TimedPath(np.array([[0.0, y], [200.0, y]]), limits), np.array([0.0, 0.0, y, 0.0]))


class Follower:
    """A world in which a car is wherever its hand is told to be, but for what is wrong with each of several runs."""

    lookahead, memory_size = 3, 1

    def __init__(self, *off: float, speed: float = 1.0) -> None:
        self.off, self.speed = np.array(off), speed
        self.seen: list[tuple[list[FloatArray], FloatArray, FloatArray]] = []
        self.ticks: list[tuple[dict[str, FloatArray], dict[str, FloatArray], dict[Any, FloatArray]]] = []

    def decide(self, states: list[FloatArray], wanted: FloatArray, memory: FloatArray) -> Any:
        self.seen.append(([s.copy() for s in states], wanted, memory))
        return wanted[:, 0], memory + 1.0, None

    def tick(self, states: dict[str, FloatArray], command: FloatArray, *, normal: Any, scale: Any) -> Any:
        self.ticks.append((states, normal, scale))
        car = states["car"].copy()
        goal = np.column_stack([command[:, 0], command[:, 1] + self.off])
        car[:, 1] += self.speed * (goal[:, 0] - car[:, 1])
        car[:, 2] = goal[:, 1]
        return {"hand": np.column_stack([car[:, 0], command, car[:, 3]]), "car": car}


def judged(world: Follower, cases: list[ValidationCase], monkeypatch: pytest.MonkeyPatch, seed: int = 0) -> float:
    made = chain()
    edge = made.graph.interactions[0]
    lower, upper = np.array([0.0, -4.0, 0.0, 0.0]), np.array([2.0, 0.0, 0.0, 1.0])
    made.links = [
        SimpleNamespace(
            interaction=edge, forward=SimpleNamespace(model="model", residual_std="spread"),
            parent_lower=lower, parent_upper=upper, child_scale=np.array([9.0, 0.3, 0.4, 9.0]),
        )
    ]  # fmt: skip
    asked: list[Any] = []
    monkeypatch.setattr(validation, "LearnedGraphReference", lambda graph, models: asked.append(models) or world)
    error = validation_error(made, world, cases, seed)  # type: ignore[arg-type]
    assert asked == [{edge: "model"}]
    assert all(scale == {edge: "spread"} for _, _, scale in world.ticks)
    return error


def test_a_follower_is_judged_by_how_far_it_is_off_from_its_first_tick_on(monkeypatch: pytest.MonkeyPatch) -> None:
    """All that it is off is to the side; where it starts is nobody's mistake."""
    for off in (0.0, 2.0):
        assert judged(Follower(off), [straight()], monkeypatch) == pytest.approx(off, abs=0.3)
    two = judged(Follower(1.0, -2.0, 3.0, 4.0), [straight(y) for y in (0.0, 10.0, 20.0, 30.0)], monkeypatch)
    assert two == pytest.approx(2.0, abs=0.1), "of four the better three"


def test_a_run_is_lost_where_it_is_many_usual_steps_off_and_more_than_some_must_not_be(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    most = TRACKING.lost * 0.5  # a usual step is 0.3 by 0.4
    assert judged(Follower(0.95 * most), [straight()], monkeypatch) == pytest.approx(0.95 * most, abs=0.1)
    assert judged(Follower(1.05 * most), [straight()], monkeypatch) == np.inf
    cases = [straight(y) for y in (0.0, 50.0, 100.0, 150.0)]
    assert judged(Follower(1.0, 1.0, 1.0, 99.0), cases, monkeypatch) == pytest.approx(1.0, abs=0.1)
    assert judged(Follower(1.0, 1.0, 99.0, 99.0), cases, monkeypatch) == np.inf
    assert judged(Follower(np.nan), [straight()], monkeypatch) == np.inf


def test_who_takes_much_longer_than_the_path_has_not_followed_it(monkeypatch: pytest.MonkeyPatch) -> None:
    case = straight()
    longest = int(np.ceil((1.0 + TRACKING.band) * case.path.time[-1] / TICK))
    quick = Follower(0.0)
    assert judged(quick, [case], monkeypatch) < np.inf
    assert len(quick.ticks) == pytest.approx(case.path.time[-1] / TICK, abs=2.0), "it ends where the path does"
    slow = Follower(0.0, speed=0.4)
    assert judged(slow, [case], monkeypatch) == np.inf
    assert len(slow.ticks) == longest
    late = judged(Follower(0.0, 0.0, speed=0.9), [case, straight(speed=12.0)], monkeypatch)
    assert late < np.inf, "each has its own time, and all that of the slowest path"


def test_a_policy_is_asked_with_where_all_are_and_what_is_wanted_in_the_coming_ticks(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    world, case = Follower(0.0, 0.0), straight()
    judged(world, [case, straight(40.0)], monkeypatch)
    (hand, car), wanted, memory = world.seen[0]
    np.testing.assert_array_equal(hand, [[1.0, -2.0, 0.0, 0.5]] * 2)
    np.testing.assert_array_equal(car, [[0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 40.0, 0.0]])
    np.testing.assert_allclose(wanted[0], case.path.at_time(TICK * np.array([1.0, 2.0, 3.0])))
    np.testing.assert_allclose(wanted[1, :, 1], 40.0)
    assert not memory.any()
    assert [m.tolist() for _, _, m in world.seen[1:3]] == [[[1.0], [1.0]], [[2.0], [2.0]]]
    np.testing.assert_allclose(world.seen[5][1][0, 0, 0] - world.seen[4][1][0, 0, 0], 30.0 * TICK, atol=1.0)


def test_noise_is_the_same_for_every_policy(monkeypatch: pytest.MonkeyPatch) -> None:
    worlds = [Follower(off) for off in (0.0, 1.0, 0.0)]
    for world, seed in zip(worlds, (3, 3, 4), strict=True):
        judged(world, [straight()], monkeypatch, seed)
    normals = [w.ticks[4][1] for w in worlds]
    assert list(normals[0]) == ["car"], "the hand goes where it is told"
    np.testing.assert_array_equal(normals[0]["car"], normals[1]["car"])
    assert (normals[0]["car"] != normals[2]["car"]).all()
    assert normals[0]["car"].shape == (1, 4)
