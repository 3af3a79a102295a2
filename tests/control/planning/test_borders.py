"""A drive may stop where an interaction becomes possible or stops being possible, and objects go where one would be."""

from types import SimpleNamespace

import numpy as np
import pytest
from toy_models import TAP_START, tap

from ichain_drake.control.planning.borders import active_samples, crossed, find_borders
from ichain_drake.control.planning.carries import find_carries
from ichain_drake.control.planning.enabling import find_enabling
from ichain_drake.control.planning.frames import Frames
from ichain_drake.control.planning.goals import parse_goal
from ichain_drake.control.planning.options import find_drives
from ichain_drake.control.planning.places import carry_targets
from ichain_drake.control.planning.plan import Plan
from ichain_drake.control.planning.planner import GraphPlanner
from ichain_drake.control.planning.simulate import simulate
from ichain_drake.graph import Interaction

FALL, TAKE = Interaction("tank", "cup"), Interaction("robot", "cup")


def narrow():
    """A tap whose tank gives water only while it holds between .35 and .65."""
    model = tap()
    place = model.gates[FALL]
    model.gates[FALL] = lambda s: np.minimum(place(s), 0.15 - np.abs(s["tank"][:, 0] - 0.5))
    return model


def test_borders_lie_just_inside_the_range_in_which_an_interaction_is_possible() -> None:
    model = narrow()
    model.low["tank"][0], model.high["tank"][0] = 0.0, 1.0
    found = [b for b in find_borders(model, find_carries(model)) if b.edge == FALL]
    assert {(b.object, b.variable) for b in found} == {("tank", 0)}
    low, high = sorted(b.value for b in found)
    assert 0.35 < low < 0.45
    assert 0.55 < high < 0.65


def test_a_drive_stops_there_and_not_at_the_brim() -> None:
    model = narrow()
    model.low["tank"][0], model.high["tank"][0] = 0.0, 1.0
    carries = find_carries(model)
    drive = next(d for d in find_drives(model, carries) if d.chain[-1].child == "tank")
    start = {**TAP_START, "tank": np.array([0.8, 0.0])}
    borders = [b for b in find_borders(model, carries) if b.edge == FALL]
    (found,) = simulate(model, [(start, drive)], start["robot"], (), borders)
    values = sorted((b.value for b in borders), reverse=True)
    np.testing.assert_allclose([o.end for o in found], [*values, 0.0], atol=1e-6)
    assert len(simulate(model, [(start, drive)], start["robot"], ())[0]) == 1


def test_where_a_series_passes_a_value() -> None:
    assert crossed(np.array([0.0, 1.0, 3.0]), 2.0) == (2, 0.5)
    assert crossed(np.array([2.0, 1.0]), 2.0) is None  # it begins there
    assert crossed(np.array([2.0, 1.0, 0.5]), 2.0) is None
    assert crossed(np.array([0.0, 1.0]), 2.0) is None


def test_an_object_is_brought_where_something_later_makes_its_interaction_possible() -> None:
    # Water falls only while the tap is pressed, which nothing does yet when the cup is placed.
    model = tap()
    place = model.gates[FALL]
    model.gates[FALL] = lambda s: np.minimum(place(s), s["tap"][:, 0] - 0.5)
    carry = find_carries(model)[0]
    enabling = find_enabling(model, carry)
    assert [e.edge for e in enabling] == [FALL]
    np.testing.assert_allclose(enabling[0].place, [1.0], atol=0.05)
    assert enabling[0].missing(
        model, Frames(model), [TAP_START, {**TAP_START, "cup": np.array([1.0, 0.0])}]
    ).tolist() == [True, False]
    (targets,) = carry_targets(model, carry, [TAP_START], TAP_START, (), enabling)
    assert any(abs(t[0] - 1.0) < 0.05 for t in targets)
    assert not any(abs(t[0] - 1.0) < 0.05 for t in carry_targets(model, carry, [TAP_START], TAP_START, ())[0][:1])
    found = GraphPlanner(model).plan(TAP_START, parse_goal(["cup.water >= 0.5"], model))
    assert isinstance(found, Plan)
    assert [s.chain[-1] for s in found.steps] == [TAKE, FALL]


def test_where_an_interaction_should_be_possible_and_failed_an_object_is_brought_where_it_was_shown() -> None:
    model, there = tap(), {**TAP_START, "cup": np.array([0.5, 0.0])}
    place = model.gates[FALL]
    model.gates[FALL] = lambda s: np.minimum(place(s) + 0.6, s["tap"][:, 0] - 0.5)
    carry = find_carries(model)[0]
    enabling = find_enabling(model, carry)
    assert [e.missing(model, Frames(model), [there]).tolist() for e in enabling if e.edge == FALL] == [[False]]
    for doubted, brought in (((), 0), ((TAKE,), 0), ((TAKE, FALL), 1)):
        (targets,) = carry_targets(model, carry, [there], there, (), enabling, [doubted])
        assert len(targets) == len(carry_targets(model, carry, [there], there, ())[0]) + brought


def test_a_place_and_an_opening_that_one_motion_changes_are_wanted_together() -> None:
    model = tap()
    # The cup's water is told by its place: a drawer's opening, say.
    model.acts[TAKE] = lambda p, q, c: np.repeat(q[..., :1] - p[..., :1], 2, axis=-1)
    model.edges[TAKE].effects.append(SimpleNamespace(variable=1))
    carry = find_carries(model)[0]
    assert carry.follow.tolist() == [0, 1]
    start = {**TAP_START, "cup": np.array([0.2, 0.1])}
    goal = parse_goal(["0.39 <= cup.water <= 0.41"], model, start)
    wanted = carry_targets(model, carry, [start], start, goal.conditions)[0][0]
    assert wanted[1] == 0.4
    assert abs((wanted[0] - wanted[1]) - (start["cup"][0] - start["cup"][1])) < 1e-6 or wanted[0] - 0.4 in carry.places


def test_what_the_classifier_denies_is_no_example_however_near_it_is() -> None:
    model = tap()
    every = len(model.edges[FALL].examples.active["cup"])
    for decisions, count in ((0.0, every), (-0.5, 0), (-1e-9, 0)):
        model.gates[FALL] = lambda s, d=decisions: np.full(len(s["cup"]), d)
        assert len(active_samples(model, FALL)["cup"]) == count


def test_an_object_is_brought_beside_the_other_end_of_an_interaction_that_looks_at_both(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The tank can't be brought to the cup: the cup's place is one beside the tank."""
    monkeypatch.setattr(Frames, "is_relative", lambda self, edge: True)
    model = tap()
    (found,) = find_enabling(model, find_carries(model)[0])
    assert (found.edge, found.anchor) == (FALL, "tank")


def test_an_object_enables_what_needs_it_at_the_place_where_that_is_surest() -> None:
    """Water falls into a cup where it stands under the tank; the tap asks nothing of the cup."""
    model = tap()
    (carry,) = find_carries(model)
    found = {e.edge: e for e in find_enabling(model, carry)}
    assert set(found) == {FALL}, "only what its place may matter to"
    enabling = found[FALL]
    np.testing.assert_allclose(enabling.place, [1.0])
    assert (enabling.anchor, enabling.carry) == (None, carry)
    frames = Frames(model)
    nodes = [{**TAP_START, "cup": np.array([x, 0.1])} for x in (0.2, 1.0, 1.04, 1.06)]
    assert enabling.missing(model, frames, nodes).tolist() == [True, False, False, True]
    np.testing.assert_allclose(enabling.place_in(frames, nodes[0]), [1.0])
    model.gates[FALL] = lambda s: np.full(len(s["cup"]), -1.0)
    assert find_enabling(model, carry) == (), "where it was never active nothing is known"


def test_an_interaction_is_impossible_where_it_is_in_half_of_what_was_shown() -> None:
    model = tap()
    (carry,) = find_carries(model)
    (enabling,) = find_enabling(model, carry)
    count = len(enabling.samples["cup"])
    nodes = [{**TAP_START, "cup": np.array([1.0, 0.1])}]
    tank = enabling.samples["tank"][:, 0]
    assert len(set(tank)) == count == 2
    model.gates[FALL] = lambda s: np.where(s["tank"][:, 0] == tank[0], 1.0, -1.0)
    assert enabling.missing(model, Frames(model), nodes).tolist() == [True]
    model.gates[FALL] = lambda s: np.ones(len(s["cup"]))
    assert enabling.missing(model, Frames(model), nodes).tolist() == [False]
