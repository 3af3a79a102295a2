"""Skills from demonstrated events, and the way to them."""

from types import SimpleNamespace

import numpy as np
import pytest
from small_job import GRAPH, fresh, learned, readings

from ichain_drake.control.planning.skills import Skills, _ranking
from ichain_drake.control.planning.travel import step_towards
from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction
from ichain_drake.learning.status.events import SwitchingWindow

BOX, VALVE = Interaction("hand", "box"), Interaction("hand", "valve")
SPACE = GRAPH.objects["hand"]


def test_an_activation_goes_where_the_object_is_now() -> None:
    model, skills, _ = learned()
    world = fresh()
    ends = []
    for place in ([0.35, 0.1, 0.0], [0.25, 0.2, 0.05]):
        world.box = np.array(place)
        world.record()
        path = skills.path(model, BOX, True, readings(world), 0)
        closes = path[int(np.argmax(path[:, 3] > 0.5))]
        assert np.abs(closes[:3] - place).max() < 0.03  # the world's reach; seen in a turned and shifted camera
        assert path[0, 3] == 0.0
        ends.append(closes[:3])
    assert np.linalg.norm(ends[1] - ends[0]) > 0.1


def test_each_attempt_takes_another_event() -> None:
    model, skills, _ = learned()
    states = readings(fresh())
    paths = [skills.path(model, VALVE, True, states, k) for k in range(3)]
    assert len({p[-1].tobytes() for p in paths}) == 3


def test_letting_go_keeps_the_grasp_until_it_opens() -> None:
    model, skills, _ = learned()
    states = readings(fresh()) | {"hand": np.array([0.36, 0.09, 0.01, 1.0])}
    path = skills.path(model, BOX, False, states, 0)
    assert path[0, 3] == 0.0
    np.testing.assert_allclose(path[0, :3], [0.36, 0.09, 0.01], atol=0.004)


def test_what_was_taken_again_at_once_was_no_letting_go() -> None:
    model, skills, _ = learned()
    states = readings(fresh()) | {"hand": np.array([0.36, 0.09, 0.01, 1.0])}
    whole = skills.path(model, BOX, False, states, 0)
    shown = skills.deactivations[BOX]
    # However sure the classifier is of where it ended: it ended there because the hand was about to close again.
    away = np.vstack([shown[0].root[: shown[0].event], shown[0].root[shown[0].event] + [0.5, 0.5, 0.5, 0.0]])
    again = SwitchingWindow(away, shown[0].child, shown[0].event)
    with_it = Skills(skills.activations, {BOX: (again, *shown)})
    np.testing.assert_array_equal(with_it.path(model, BOX, False, states, 0), whole)
    assert len(Skills(skills.activations, {BOX: (again,)}).path(model, BOX, False, states, 0)) > 0  # all there is


def test_a_designers_function_stands_in() -> None:
    model, _, _ = learned()
    way = np.array([[0.1, 0.2, 0.3, 0.0], [0.1, 0.2, 0.3, 1.0]])
    skills = Skills.of(model, {(BOX, True): lambda states, attempt: way + attempt})
    np.testing.assert_array_equal(skills.path(model, BOX, True, readings(fresh()), 1), way + 1)
    assert len(skills.path(model, BOX, False, readings(fresh()), 0)) > 0


def test_what_was_never_shown_and_what_is_no_edge_of_the_robot_is_refused() -> None:
    model, _, _ = learned()
    with pytest.raises(InputError, match="hand->box: it is activated in no demonstration; add a piece"):
        Skills({}, {}).path(model, BOX, True, readings(fresh()), 0)
    with pytest.raises(InputError, match="tap->box; skills belong to the robot's own"):
        Skills.of(model, {(Interaction("tap", "box"), True): lambda s, k: np.zeros((1, 4))})


def test_steps_are_straight_and_what_jumps_changes_on_arrival() -> None:
    now, goal, limit = np.zeros(4), np.array([0.1, 0.05, 0.0, 1.0]), np.array([0.04, 0.04, 0.04, 1.0])
    seen = []
    for _ in range(3):
        now, there = step_towards(SPACE, now, goal, limit)
        seen.append(there)
        assert now[0] == pytest.approx(2 * now[1])
        assert now[3] == float(there)
    assert seen == [False, False, True]


def test_what_was_shown_for_longer_after_it_let_go_comes_first_and_then_what_ends_most_surely_inactive() -> None:
    """Rows from the event on: a second and one more make it whole, or as many as there are."""
    model = SimpleNamespace(graph=GRAPH, decide=lambda edge, batch: batch["hand"][:, 0])
    states = {n: np.zeros(len(s.observable)) for n, s in GRAPH.objects.items()}

    def order(*shown: tuple[int, float]) -> list[int]:
        """Of windows with so many rows from the event on, at whose end the decision is so."""
        paths = [np.repeat([[end, 0.0, 0.0, 0.0]], rows + 2, axis=0) for rows, end in shown]
        windows = [SwitchingWindow(p, np.zeros(3), 2) for p in paths]
        return _ranking(model, BOX, windows, paths, states, False)  # type: ignore[arg-type]

    assert order((3, -0.9), (4, -0.2), (9, -0.5)) == [2, 1, 0]
    assert order((1, -0.9), (2, -0.2), (2, -0.3)) == [2, 1, 0]
    assert order((1, -0.2), (1, -0.9)) == [1, 0]
