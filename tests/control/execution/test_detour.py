"""Ways around places at which a robot was stopped, and what tells that it was."""

from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from small_job import GRAPH, executor, fresh, readings

from ichain_drake.control.execution.detour import Blocked, Detour, stopped_before
from ichain_drake.control.execution.switching import Switch
from ichain_drake.control.execution.tasks import Failed
from ichain_drake.control.settings import EXECUTION, PLANNING
from ichain_drake.errors import UnreachableError
from ichain_drake.graph import Interaction
from ichain_drake.learning.settings import LEARNING
from ichain_drake.motion_query import MotionQuery
from ichain_drake.state import FloatArray, Role, StateSpace, Variable

SPACE = StateSpace(
    "digger",
    (
        *(Variable(a, "m", 0.0, 2.0, role=Role("position", "pit", a)) for a in "xy"),
        Variable("swing", "rad", kind="angle"),
        Variable("jaw", "1", 0.0, 1.0, "binary"),
    ),
)
LIMIT = np.array([0.1, 0.1, 0.4, 1.0])
START, GOAL = np.array([0.5, 1.0, 3.0, 0.0]), np.array([1.5, 1.0, -3.0, 1.0])


def wall(low: float, high: float, x: float = 1.0) -> FloatArray:
    return np.array([[x, y] for y in np.arange(low, high + 1e-9, 0.1)])


def path(places: FloatArray, again: int = 0) -> FloatArray:
    return Detour(SPACE, LIMIT, Blocked(places, again=again)).path(MotionQuery(START, GOAL))


def test_where_nothing_is_in_the_way_it_is_straight() -> None:
    rows = path(wall(1.5, 2.0))
    assert len(rows) == 10
    np.testing.assert_allclose(rows[:, 1], 1.0)
    np.testing.assert_array_equal(rows[-1], GOAL)


def test_it_leads_around_what_is_known_in_steps_and_turns_the_short_way() -> None:
    places = wall(0.6, 2.0)
    rows = path(places)
    steps = np.diff(np.vstack([START, rows]), axis=0)[:, :2]
    assert np.abs(steps).max() <= 0.1 + 1e-9
    assert np.abs(rows[:, None, :2] - places).max(axis=2).min() > 0.05
    assert rows[:, 1].min() < 0.55
    assert np.abs(rows[:, 2]).min() > 2.9  # past pi, not past 0
    assert not rows[:-1, 3].any()
    np.testing.assert_array_equal(rows[-1], GOAL)


def test_a_goal_that_is_blocked_or_walled_off_is_out_of_reach() -> None:
    with pytest.raises(UnreachableError, match="stopped on the way there"):
        path(GOAL[None, :2] + 0.02)
    with pytest.raises(UnreachableError, match="stopped on every way there"):
        path(wall(0.0, 2.0))
    with pytest.raises(UnreachableError, match="stopped on the way there"):
        path(wall(1.5, 2.0), again=LEARNING.few + 1)


def test_places_are_those_of_one_load_and_known_ones_are_counted() -> None:
    step, here = LIMIT[:2], np.array([1.0, 1.0])
    once = Blocked().met(here, "", step)
    twice = once.met(here + 0.005, "", step)
    assert (len(twice.places), twice.again) == (2, 1)
    assert once.met(here + 0.1, "", step).again == 0
    loaded = twice.met(here, "rock", step)
    assert (len(loaded.places), loaded.again, loaded.held) == (1, 0, "rock")


def model(noise: float = 0.0) -> SimpleNamespace:
    graph = SimpleNamespace(root="digger", objects={"digger": SPACE})
    return SimpleNamespace(graph=graph, step_limit={"digger": LIMIT}, noise={"digger": np.full(4, noise)})


@pytest.mark.parametrize(
    ("moved", "ahead", "noise", "stopped"),
    [
        (0.0, 0.2, 0.0, True),
        (0.05, 0.2, 0.0, False),  # it gets on
        (0.0, 0.04, 0.0, False),  # it is as good as there
        (0.01, 0.2, 0.005, True),  # a reading's noise is no motion
        (0.0, 0.2, 0.06, False),  # nor is it a way to go
    ],
)
def test_a_robot_that_does_not_get_on_though_it_should_was_stopped(
    moved: float, ahead: float, noise: float, stopped: bool
) -> None:
    readings = [{"digger": START + [k * moved / 2, 0, 0, 0]} for k in range(3)]
    command = readings[-1]["digger"] + [ahead, 0, 0, 1]
    found = stopped_before(model(noise), readings, command)  # type: ignore[arg-type]
    assert (found is not None) == stopped
    if found is not None:
        np.testing.assert_allclose(found, readings[-1]["digger"][:2] + [0.1, 0.0])
    assert stopped_before(model(noise), readings[1:], command) is None  # type: ignore[arg-type]


@pytest.mark.parametrize(("far", "path", "travels"), [(True, [GOAL], True), (False, [GOAL], False), (True, [], False)])
def test_a_robot_on_its_way_should_not_be_stopped_but_one_that_does_as_was_shown_may_push(
    far: bool, path: list[FloatArray], travels: bool
) -> None:
    assert Switch(Interaction("digger", "rock"), path=path, far=far).travels == travels


@pytest.mark.parametrize(("cause", "kept"), [("reach", False), ("carry", True)])
def test_where_there_was_no_way_what_was_in_it_is_found_out_anew(cause: str, kept: bool) -> None:
    world = fresh()
    run = executor(["box.water >= 0.4"], world)
    memory = run.start(readings(world)["hand"])
    memory.readings, memory.blocked = [readings(world)] * 4, Blocked(np.ones((1, 3)))
    run._failed(memory, Failed(GRAPH.interactions[0], cause, "no way"))
    assert (memory.blocked is not None) == kept


def stopped(moved: FloatArray, way: FloatArray, rows: int = LEARNING.ticks, noise: float = 1e-6) -> FloatArray | None:
    """What is said of a digger that moved so in some ticks and is told to go so far."""
    model = SimpleNamespace(
        graph=SimpleNamespace(root="digger", objects={"digger": SPACE}),
        step_limit={"digger": LIMIT},
        noise={"digger": np.full(4, noise)},
    )
    here = np.array([0.5, 1.0, 3.0, 0.0])
    readings = [{"digger": here - moved * (rows - 1 - k) / max(rows - 1, 1)} for k in range(rows)]
    return stopped_before(model, readings, here + way)  # type: ignore[arg-type]


FAR, NOTHING = np.array([0.05, 0.3, 0.0, 0.0]), np.zeros(4)


def test_it_is_stopped_where_it_is_told_to_go_on_and_does_not() -> None:
    np.testing.assert_allclose(stopped(NOTHING, FAR), [0.5 + 0.05 / 3, 1.1], err_msg="one step further")
    np.testing.assert_allclose(stopped(NOTHING, [0.07, 0.0, 0.0, 0.0]), [0.57, 1.0], err_msg="less than a step")  # type: ignore[arg-type]
    assert stopped(NOTHING, FAR, rows=LEARNING.ticks - 1) is None, "too early to tell"
    turned = stopped(NOTHING, np.array([0.0, 0.0, 0.8, 0.0]))
    np.testing.assert_allclose(turned, [0.5, 1.0], err_msg="it may be stopped as it turns")
    assert stopped(NOTHING, np.array([0.0, 0.0, 0.0, 1.0])) is None, "what jumps is no way"


@pytest.mark.parametrize(("share", "gets_on"), [(0.9, False), (1.1, True)])
def test_how_much_is_getting_on_and_how_much_is_told_to(share: float, gets_on: bool) -> None:
    least = share * EXECUTION.slack * 0.1
    assert (stopped(np.array([least, 0.0, 0.0, 0.0]), FAR) is None) is gets_on
    assert (stopped(np.array([share * LEARNING.surely * 0.01, 0.0, 0.0, 0.0]), FAR, noise=0.01) is None) is gets_on
    short = share * PLANNING.push * 0.1
    assert (stopped(NOTHING, np.array([short, 0.0, 0.0, 0.0])) is None) is not gets_on
    loud = share * LEARNING.surely * 0.05
    assert (stopped(NOTHING, np.array([loud, 0.0, 0.0, 0.0]), noise=0.05) is None) is not gets_on
    assert stopped(np.array([0.0, 0.0, 0.0, 1.0]), FAR) is not None, "what jumps does not get anywhere"


def test_what_was_met_again_and_again_is_out_of_reach() -> None:
    assert len(path(wall(1.5, 2.0), again=LEARNING.few))
    with pytest.raises(UnreachableError, match="stopped on the way there"):
        path(wall(1.5, 2.0), again=LEARNING.few + 1)


def test_corners_are_cut_as_far_as_nothing_is_known_to_be_in_the_way() -> None:
    detour = Detour(SPACE, LIMIT, Blocked(wall(0.6, 2.0)))
    corners = detour._around(START[:2], GOAL[:2])
    np.testing.assert_array_equal([corners[0], corners[-1]], [START[:2], GOAL[:2]])
    for a, b in pairwise(corners):
        assert detour._clear(a, b)
    for a, b in pairwise(corners[::2]):
        assert not detour._clear(a, b), "none of them is needless"
    length = sum(np.max(np.abs(b - a)) for a, b in pairwise(corners))
    assert 1.0 <= length < 1.35


def test_a_place_is_hit_within_so_many_steps_of_it_along_every_axis() -> None:
    detour = Detour(SPACE, LIMIT, Blocked(np.array([[1.0, 1.0], [0.3, 0.3]])))
    places_ = np.array([[1.04, 1.0], [1.06, 1.0], [1.04, 1.06], [0.3, 0.26], [0.95, 0.95]])
    assert detour._hits(places_, 0.5).tolist() == [True, False, False, True, False]
    assert detour._hits(places_, 1.0).tolist() == [True] * 5
    assert detour._clear(np.array([1.0, 1.0]), np.array([1.2, 1.0])) is False, "from where it stands, half a step on"
    assert detour._clear(np.array([1.11, 1.0]), np.array([1.5, 1.0])) is True
