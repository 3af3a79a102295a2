"""Which of many predicted drives go on, and what those that never began were waiting for."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from toy_models import ToyModel

from ichain_drake.control.planning.drive_option import DriveOption
from ichain_drake.control.planning.drive_run import Run
from ichain_drake.control.planning.motion_run import MotionRun
from ichain_drake.control.planning.stops import Stop
from ichain_drake.control.settings import PLANNING
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.state import StateSpace, Variable

PRESS, FLOW = Interaction("robot", "tap"), Interaction("tap", "tank")
BEGIN = 4


def asked(**more: Any) -> Any:
    """Three drives after three steps and the next: the last of them ended before."""
    return SimpleNamespace(n=3, lost=[None] * 3, last=np.array([BEGIN, BEGIN, 1]), **more)


@pytest.mark.parametrize(("step", "noted"), [(BEGIN - 2, False), (BEGIN - 1, True), (BEGIN, False)])
def test_a_drive_whose_chain_is_not_active_ends_and_the_first_that_is_missing_is_noted_where_it_begins(
    step: int, noted: bool
) -> None:
    run = asked(drives=[SimpleNamespace(chain=(PRESS, FLOW))] * 3)
    status = {PRESS: np.array([True, True, False]), FLOW: np.array([True, False, False])}
    assert Run.check(run, status, step, BEGIN).tolist() == [True, False, False]
    assert run.lost == [None, FLOW if noted else None, None], "one that drove before has not lost what it drove by"


@pytest.mark.parametrize(("step", "noted"), [(BEGIN - 2, False), (BEGIN - 1, True), (BEGIN, False)])
def test_a_motion_ends_where_its_object_is_lost_but_while_it_is_taken_anew(step: int, noted: bool) -> None:
    run = asked(motions=[SimpleNamespace(edge=PRESS)] * 3, away=np.array([True, False, False]))
    assert MotionRun.check(run, {PRESS: np.zeros(3, dtype=bool)}, step, BEGIN).tolist() == [True, False, False]
    assert run.lost == [None, PRESS if noted else None, None]
    run = asked(motions=[SimpleNamespace(edge=PRESS)] * 3, away=np.zeros(3, dtype=bool))
    run.lost[1] = PRESS  # it was out of reach from the first
    assert MotionRun.check(run, {PRESS: np.ones(3, dtype=bool)}, step, BEGIN).tolist() == [True, False, True]


def test_the_robot_is_where_it_holds_after_its_ramp() -> None:
    run: Any = SimpleNamespace(ramp=np.array([0, 1, 2, 4]), first=np.zeros((4, 1)), hold=np.ones((4, 1)))
    np.testing.assert_allclose(Run.robot(run, 0)[:, 0], [1.0, 1.0, 0.5, 0.25])
    np.testing.assert_allclose(Run.robot(run, 3)[:, 0], 1.0)


def lever(*drives: DriveOption, start: float = 0.5) -> Run:
    """A tank that fills by a tenth of where a robot holds a lever, while it holds it beyond 0."""
    level = Variable("level", lower=0.0, upper=100.0)
    spaces = {"robot": StateSpace("robot", (Variable("x", "m"),)), "tank": StateSpace("tank", (level,))}
    shown = [{"robot": [x], "tank": [y]} for x, y in ((0.0, 0.0), (1.0, 30.0))]
    model = ToyModel(
        InteractionGraph(spaces, ["robot->tank"]),
        {"robot->tank": lambda s: s["robot"][:, 0] - 0.01},
        {"robot->tank": lambda p, q, c: 0.1 * q},
        {"tank": ["hold"]},
        {"robot->tank": shown},
        {},
    )
    now = {"robot": np.array([-1.0]), "tank": np.array([start])}
    return Run(model, [(now, d) for d in drives], np.array([-1.0]))  # type: ignore[arg-type]


def held(at: float, first: float, direction: int = 1, rate: float = 0.1, carry: Any = None) -> DriveOption:
    hold, before = ({"robot": np.array([x]), "tank": np.array([7.0])} for x in (at, first))
    return DriveOption((Interaction("robot", "tank"),), 0, direction, rate, carry, hold, before)


def test_a_ramp_takes_as_many_ticks_as_the_robot_needs() -> None:
    run = lever(held(1.0, 1.0), held(1.0, 0.9), held(1.0, 0.89), held(-0.5, 1.0))
    assert run.ramp.tolist() == [0, 1, 2, 15]
    np.testing.assert_array_equal(run.now["robot"][:, 0], [1.0, 0.9, 0.89, 1.0])
    np.testing.assert_array_equal(run.now["tank"][:, 0], 0.5)
    np.testing.assert_array_equal(run.value(run.now), 0.5)


def test_what_is_carried_is_where_the_drive_begins_and_comes_back_to_where_it_was() -> None:
    carry = SimpleNamespace(edge=Interaction("robot", "tank"), follow=[0])
    run = lever(held(-1.0, -1.0), held(-1.0, -1.0, carry=carry))
    np.testing.assert_array_equal(run.now["tank"][:, 0], [0.5, 7.0])
    ends = {n: v[[1, 0]] for n, v in run.now.items()}
    back = run.undo(ends, [Stop(1, 0), Stop(0, 0)])
    np.testing.assert_array_equal(back["tank"][:, 0], [0.5, 0.5])
    np.testing.assert_array_equal(ends["tank"][:, 0], [7.0, 0.5], "what is handed in is left alone")


@pytest.mark.parametrize(("step", "steps"), [(0, 0), (1, 1), (3, 3), (5, 4)])
def test_the_robot_goes_back_the_way_it_came_as_far_as_it_was_gone(step: int, steps: int) -> None:
    """A ramp of 4 from 0.1 to 0.5, of which a part was gone; on the way back the tank fills, too."""
    run = lever(held(0.5, 0.1))
    at = 0.1 + 0.1 * min(step, 4)
    back = run.undo({"robot": np.array([[at]]), "tank": np.array([[2.0]])}, [Stop(0, step)])
    way = [at + (k + 1) / steps * (0.1 - at) for k in range(steps)]
    assert back["tank"][0, 0] == pytest.approx(2.0 + 0.1 * sum(way))
    assert back["robot"][0, 0] == pytest.approx(0.1)


def test_ticks_are_counted_for_each_drive_and_stop_where_it_ends() -> None:
    run = lever(held(1.0, 0.8), held(-1.0, -1.0))
    run.drive()
    assert run.lost == [None, Interaction("robot", "tank")]
    ticks = np.array(run.ticks_at)
    assert (np.diff(ticks[:, 0]) >= 1).all(), "a step takes a tick at least"
    last = int(run.last[1])
    assert (ticks[last:, 1] == ticks[last, 1]).all()
    level = np.array([b["tank"][0, 0] for b in run.history])
    begin = 3  # a ramp of two and a link
    np.testing.assert_allclose(level[: begin + 1], 0.5 + np.cumsum([0.0, 0.09, 0.1, 0.1]))
    level_then = np.minimum(level[begin] + 0.1 * (ticks[begin:, 0] - ticks[begin, 0]), 100.0)
    np.testing.assert_allclose(level[begin:], level_then, rtol=1e-9)
    assert len(run.history) == len(run.ticks_at) == int(run.last[0]) + 1
    assert level[-1] == 100.0


@pytest.mark.parametrize(("direction", "rate", "moving"), [(1, 0.1, True), (-1, 0.1, False), (1, 50.0, False)])
def test_a_drive_goes_on_while_its_variable_changes_by_a_share_of_its_rate(
    direction: int, rate: float, moving: bool
) -> None:
    run = lever(held(1.0, 1.0, direction, rate))
    run.ticks_at = [np.array([k]) for k in range(PLANNING.window + 3)]
    values = [np.array([0.1 * k]) for k in range(PLANNING.window + 3)]
    assert run._moving(values, run.ticks_at[-1], 1).tolist() == [moving]
    early = [np.array([0.0])] * 4
    assert run._moving(early, np.array([3]), 1).tolist() == [True], "too early to tell"
    run.ticks_at = [np.array([2 * k]) for k in range(PLANNING.window + 3)]
    least = PLANNING.least * run.rate[0]
    for share, goes in ((0.9, False), (1.1, True)):
        slow = [np.array([direction * share * least * 2 * k]) for k in range(PLANNING.window + 3)]
        assert run._moving(slow, run.ticks_at[-1], 1).tolist() == [goes], "a tick, not a step"


def test_interactions_are_asked_anew_once_in_a_while() -> None:
    run = lever(held(1.0, 1.0))
    asked_in = [k for k in range(3 * PLANNING.probe) if run.rechecks(k)]
    assert asked_in == [0, PLANNING.probe, 2 * PLANNING.probe]
    assert run.pauses() == 0


def test_each_drive_is_undone_by_as_many_steps_as_it_went() -> None:
    run = lever(held(0.5, 0.1), held(0.5, 0.1), held(0.5, 0.1))
    at = np.array([0.2, 0.4, 0.5])
    stops = [Stop(0, 1), Stop(2, 3), Stop(1, 4)]
    back = run.undo({"robot": at[:, None], "tank": np.full((3, 1), 2.0)}, stops)
    np.testing.assert_allclose(back["robot"][:, 0], 0.1)
    filled = [0.1 * 0.1, 0.1 * (0.3 + 0.2 + 0.1), 0.1 * (0.4 + 0.3 + 0.2 + 0.1)]
    np.testing.assert_allclose(back["tank"][:, 0], 2.0 + np.array(filled))
