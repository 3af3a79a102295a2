"""How frames are turned, from single ticks of which some are no motion together at all."""

import numpy as np
import pytest

from ichain_drake.learning.discovery.log import Log, RawPiece, make_log
from ichain_drake.learning.discovery.turning import tick_alignment
from ichain_drake.state import Role, StateSpace, Variable

NOISE, ROWS, ALONE, ON = 1e-4, 200, 120, 160


def place(frame: str, *axes: str) -> tuple[Variable, ...]:
    return tuple(Variable(a, "m", role=Role("position", frame, a)) for a in axes)


def turned_by(angle: float) -> np.ndarray:
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def log(frame: str, moved: np.ndarray, seed: int = 0, wrong: int = 0, roll: bool = False) -> tuple[Log, np.ndarray]:
    """A hand rests, goes about alone, then with a box, through `moved`; in `wrong` of those ticks the box is jolted."""
    rng = np.random.default_rng(seed)
    roles = (Variable("roll", "rad", -np.pi, np.pi, "angle", Role("orientation", "robot", "x")),) if roll else ()
    spaces = {
        "hand": StateSpace("hand", (*place("robot", "x", "y"), *roles)),
        "box": StateSpace("box", place(frame, "x", "y")),
    }
    step = 0.03 * rng.normal(size=(ROWS, 2)) * (np.arange(ROWS) >= ALONE)[:, None]
    hand = np.cumsum(step, axis=0)
    on = np.arange(ROWS) >= ON
    box = np.cumsum(np.where(on[:, None], step @ moved.T, 0.0), axis=0) + [0.4, -0.2]
    for k in rng.choice(np.arange(ON + 2, ROWS), wrong, replace=False):
        box[k:] += [0.3, 0.3]
    states = {"hand": np.c_[hand, np.zeros((ROWS, len(roles)))], "box": box}
    states = {n: s + NOISE * rng.normal(size=s.shape) for n, s in states.items()}
    made = make_log([RawPiece("p", states)], spaces, "hand", {})
    return made, on[made.t + 1]


@pytest.mark.parametrize("angle", [0.0, 0.7, -1.2])
def test_the_turn_of_a_camera_is_found_though_some_ticks_are_jolts(angle: float) -> None:
    made, on = log("camera", turned_by(angle), wrong=4)
    found = tick_alignment(made, "hand", "box", on)
    assert found is not None
    np.testing.assert_allclose(found.turn, turned_by(angle), atol=0.1)  # its prior is not turned
    assert found.sway.shape == (2, 0)
    np.testing.assert_allclose(np.linalg.det(found.turn), 1.0)


def test_of_one_frame_nothing_is_turned_and_the_shift_is_where_it_is_held() -> None:
    made, on = log("robot", np.eye(2))
    found = tick_alignment(made, "hand", "box", on)
    assert found is not None
    np.testing.assert_array_equal(found.turn, np.eye(2))
    held = (made.states["box"] - made.states["hand"])[made.t][on]
    np.testing.assert_allclose(found.shift, np.median(held, axis=0), atol=1e-6)


def test_what_does_not_move_with_it_has_no_alignment() -> None:
    made, on = log("robot", np.eye(2))
    assert tick_alignment(made, "hand", "box", ~on) is None
    other, _ = log("camera", np.eye(2), seed=1)
    mixed = {"hand": made.states["hand"], "box": other.states["box"]}
    assert tick_alignment(make_log([RawPiece("p", mixed)], made.spaces, "hand", {}), "hand", "box", on) is None


def test_ticks_in_which_the_parent_rests_say_nothing() -> None:
    made, on = log("robot", np.eye(2))
    still = {n: s.copy() for n, s in made.states.items()}
    for s in still.values():
        s[ALONE:] = s[ALONE]
    quiet = make_log([RawPiece("p", still)], made.spaces, "hand", {})
    assert tick_alignment(quiet, "hand", "box", on) is None


def test_a_robot_that_may_turn_but_did_not_sways_nothing() -> None:
    made, on = log("camera", turned_by(0.5), roll=True)
    found = tick_alignment(made, "hand", "box", on)
    assert found is not None
    assert found.sway.shape == (2, 2)
    np.testing.assert_allclose(found.turn, turned_by(0.5), atol=0.1)
    np.testing.assert_allclose(found.sway, 0.0, atol=0.02)


def test_between_unlike_axes_the_turn_is_any_linear_map_and_a_turning_hand_sways_the_box() -> None:
    """A box on a table of two coordinates, swept along by an arm of three that turns: what turns it is told apart."""
    rng = np.random.default_rng(2)
    roll = Variable("roll", "rad", -np.pi, np.pi, "angle", Role("orientation", "robot", "x"))
    spaces = {
        "hand": StateSpace("hand", (*place("robot", "x", "y", "z"), roll)),
        "box": StateSpace("box", place("table", "x", "y")),
    }
    hand = np.cumsum(0.03 * rng.normal(size=(ROWS, 3)), axis=0)
    angle = np.cumsum(0.2 * rng.normal(size=ROWS) * (np.arange(ROWS) >= ALONE))
    turn, sway = np.array([[0.0, 1.0, 0.2], [-1.0, 0.0, 0.5]]), np.array([[0.1, 0.0], [0.0, 0.1]])
    box = hand @ turn.T + np.c_[np.cos(angle), np.sin(angle)] @ sway.T + [0.4, -0.2]
    states = {"hand": np.c_[hand, angle], "box": box}
    made = make_log([RawPiece("p", states)], spaces, "hand", {})
    made.noise["hand"][:] = NOISE  # too much goes on for it to be seen
    found = tick_alignment(made, "hand", "box", np.ones(len(made.t), dtype=bool))
    assert found is not None
    np.testing.assert_allclose(found.turn, turn, atol=1e-3)
    np.testing.assert_allclose(found.sway, sway, atol=2e-3)
    np.testing.assert_allclose(found.shift, [0.4, -0.2], atol=5e-3)
    assert found.rows > ROWS - ALONE
    assert found.unexplained < 1e-3
