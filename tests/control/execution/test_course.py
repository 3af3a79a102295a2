"""Ways that the robot's side lays out: followed tick by tick, kept while the goal moves little, and refused."""

import numpy as np
import pytest
from small_job import drive, fresh, learned, readings, where

from ichain_drake.control.execution.carried import Carried
from ichain_drake.control.execution.course import Course
from ichain_drake.control.execution.executor import Executor
from ichain_drake.control.execution.tasks import Mode, View
from ichain_drake.control.planning.goals import parse_goal
from ichain_drake.errors import UnreachableError
from ichain_drake.motion_query import MotionQuery
from ichain_drake.state import FloatArray, StateSpace, Variable

SPACE = StateSpace(
    "crane", (Variable("a", "m", -1.0, 1.0), Variable("b", "m", -1.0, 1.0), Variable("jaw", "1", 0.0, 1.0, "binary"))
)
LIMIT = np.array([0.1, 0.1, 1.0])
START, GOAL = np.zeros(3), np.array([0.4, 0.0, 1.0])


class OverTheTop:
    """A robot that first goes up along its second or third variable; it refuses what it is told to."""

    def __init__(self, axis: int = 1, refused: int = 0, *, blocked: bool = False) -> None:
        self.axis, self.refused, self.blocked = axis, refused, blocked
        self.asked: list[tuple[FloatArray, str | None, dict[str, FloatArray]]] = []

    def path(self, query: MotionQuery) -> FloatArray:
        now, goal = np.asarray(query.now), np.asarray(query.goal)
        self.asked.append((goal, query.held, dict(query.left)))
        if self.blocked or len(self.asked) <= self.refused:
            raise UnreachableError("the boom and the shed are in the way")
        up = np.array([0.0, 0.0, 0.0, 0.0])[: len(now)]
        up[self.axis] = 0.05
        middle = 0.5 * (now + goal) + up
        rows = [now + k / 4 * (middle - now) for k in range(1, 5)] + [
            middle + k / 4 * (goal - middle) for k in (1, 2, 3)
        ]
        jumps = [i for i in range(len(now)) if i == len(now) - 1]
        out = np.array([*rows, goal])
        out[:-1, jumps] = now[jumps]
        return out


def follow(motion: OverTheTop | None, goals: list[FloatArray]) -> list[FloatArray]:
    course, out = Course(), [START]
    for goal in goals:
        command, there = course.towards(SPACE, out[-1], goal, LIMIT, motion, "load", lambda: {"box": START})
        out.append(command)
        if there:
            break
    return out


def test_without_a_motion_the_way_is_straight() -> None:
    rows = follow(None, [GOAL] * 20)
    np.testing.assert_allclose(rows, [[0.1 * k, 0.0, float(k == 4)] for k in range(5)], atol=1e-12)


def test_a_way_that_was_laid_out_is_gone_row_by_row() -> None:
    motion = OverTheTop()
    rows = follow(motion, [GOAL] * 20)
    assert len(rows) == 9
    assert max(r[1] for r in rows) == pytest.approx(0.05)
    np.testing.assert_array_equal(rows[-1], GOAL)
    assert [(held, list(left)) for _, held, left in motion.asked] == [("load", ["box"])]


def test_a_goal_that_moves_little_is_the_same_and_one_that_moves_far_is_not() -> None:
    motion = OverTheTop()
    near = GOAL + [0.02, 0.0, 0.0]
    np.testing.assert_array_equal(follow(motion, [GOAL] * 3 + [near] * 20)[-1], near)
    assert len(motion.asked) == 1
    far = GOAL + [0.3, 0.0, 0.0]
    np.testing.assert_array_equal(follow(motion, [GOAL] * 3 + [far] * 20)[-1], far)
    assert len(motion.asked) == 3


FILL = ["box.water >= 0.4", "not hand->box"]


def with_motion(motion: OverTheTop) -> tuple[Executor, object]:
    world = fresh()
    model, skills, planner = learned()
    return Executor(model, skills, planner.plan, parse_goal(FILL, model, readings(world)), motion=motion), world


def test_an_execution_says_what_it_holds_and_where_it_let_go() -> None:
    motion = OverTheTop(axis=2)
    run, world = with_motion(motion)
    memory = drive(run, world)  # type: ignore[arg-type]
    assert (memory.mode, memory.reason) == (Mode.REACHED, "goal reached")
    held = [h for _, h, _ in motion.asked]
    assert held[0] is None
    assert "box" in held
    assert memory.carried.held is None
    box = world.box  # type: ignore[attr-defined]
    np.testing.assert_allclose(memory.carried.left["box"][:2], box[:2], atol=0.03)
    assert all("box" in left for _, h, left in motion.asked if h == "box"), "how it is held is read"


def test_what_slipped_or_was_moved_is_no_longer_where_the_robot_left_it() -> None:
    model, world = learned()[0], fresh()
    now, root = readings(world), np.array([0.3, 0.1, 0.0, 1.0])
    left = Carried().taken("box", now["box"]).let_go(root)
    np.testing.assert_array_equal(where(left, model, now)["box"], root)
    pushed = now | {"box": now["box"] + np.eye(len(now["box"]))[0] * 0.2}
    robot = where(left.settled("box", now["box"]), model, pushed)["box"]
    went = robot[:3] - where(Carried(), model, now)["box"][:3]
    assert np.linalg.norm(went) == pytest.approx(0.2, abs=2e-3), "in a frame that is turned to the robot's"
    np.testing.assert_array_equal(where(Carried(), model, pushed)["box"], robot)
    seen = left.settled("box", now["box"])
    held = seen.taken("box", now["box"])
    assert held == Carried("box", origin=tuple(now["box"]))
    assert held.taken("box", now["box"] + 1.0) == held  # where it was when it was taken, not on the way
    assert Carried("box").slipped() == Carried()
    assert Carried().settled("box", now["box"]) == Carried()


def test_where_there_is_no_way_the_next_demonstrated_event_is_tried() -> None:
    run, world = with_motion(OverTheTop(axis=2, refused=1))
    memory = drive(run, world)  # type: ignore[arg-type]
    assert memory.mode == Mode.REACHED
    assert memory.replans == 0


def test_where_there_is_no_way_at_all_it_stops_and_says_why() -> None:
    run, world = with_motion(OverTheTop(blocked=True))
    commands: list[FloatArray] = []
    memory = drive(run, world, each=lambda m: commands.append(m.command))  # type: ignore[arg-type]
    assert (memory.mode, memory.cause) == (Mode.STOPPED, "reach")
    assert "the boom and the shed are in the way" in memory.reason
    assert "given up after 5 new plans" in memory.reason
    assert [c.no_way for c in memory.experience.contradictions] == ["to it"] * 6
    np.testing.assert_array_equal(commands, np.tile(readings(fresh())["hand"], (len(commands), 1)))  # nor blindly away


def test_a_way_is_laid_out_anew_when_something_was_moved_by_somebody_else() -> None:
    """Once the box is elsewhere, and not while the hand carries it."""
    asked = []
    for shift in (0.0, 0.12):
        motion = OverTheTop(axis=2)
        run, world = with_motion(motion)
        first = readings(world)["box"]

        def push(tick: int, world: object, shift: float = shift) -> None:
            if tick == 6:
                world.box = world.box + [-shift, 0.0, 0.0]  # type: ignore[attr-defined]

        memory = drive(run, world, mishap=push)  # type: ignore[arg-type]
        assert (memory.mode, memory.reason) == (Mode.REACHED, "goal reached")
        assert memory.replans == 0
        assert (memory.places.moved > 0) == (shift > 0)
        asked.append([goal for goal, held, _ in motion.asked if held is None][:5])
        assert np.linalg.norm(readings(world)["box"] - first) > 0.05
    np.testing.assert_array_equal(asked[0][0], asked[1][0])
    assert max(np.abs(asked[1][0] - goal)[:2].max() for goal in asked[1][1:]) > 0.1, "to where the box is now"


def test_a_way_with_something_in_the_hand_is_laid_out_anew_too() -> None:
    motion, course, command = OverTheTop(axis=2), Course(), readings(fresh())["hand"]
    asked = []
    for moved in (0, 0, 1, 1):
        view = View(learned()[0], learned()[1], [readings(fresh())], command, motion=motion, moved=moved)
        view.travel(course, command + [0.1, 0.0, 0.0, 0.0], "box")
        asked.append(len(motion.asked))
    assert asked == [1, 1, 2, 2]
