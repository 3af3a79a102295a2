"""What is remembered of things that the robot took and let go of."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from small_job import fresh, learned, readings, where

from ichain_drake.control.execution.carried import Carried, Places
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import StateSpace, Variable

TAKE = Interaction("hand", "box")
THERE = readings(fresh())["box"]
ROOT = np.array([0.2, 0.1, 0.0, 1.0])


def off_by(share: float, variable: str = "x") -> dict[str, np.ndarray]:
    """States in which the box is off by a share of the demonstrated range of one of its variables."""
    model, _, _ = learned()
    i, box = model.graph.objects["box"].index(variable), THERE.copy()
    box[i] += share * (model.high["box"][i] - model.low["box"][i])
    return {**readings(fresh()), "box": box}


def test_taken_followed_let_go_and_settled() -> None:
    nothing = Carried()
    assert (nothing.held, nothing.following, nothing.ticks) == (None, "", 0)
    held = nothing.taken("box", THERE)
    assert (held.held, held.origin, held.following) == ("box", tuple(THERE), "")
    assert held.taken("box", THERE + 1.0) is held, "taken once"
    seen = held.watched(True)
    assert (seen.following, seen.ticks) == ("box", 1)
    assert seen.watched(None).following == "box", "where nothing moves, what was seen last holds"
    assert (seen.watched(None).ticks, seen.watched(False).following) == (2, "")
    put = seen.let_go(ROOT)
    assert (put.held, put.following, put.origin) == (None, "", ())
    np.testing.assert_array_equal(put.left["box"], ROOT)
    assert put.seen == {}
    np.testing.assert_array_equal(put.settled("box", THERE).seen["box"], THERE)
    assert put.settled("tap", THERE) is put, "never held"
    again = put.settled("box", THERE).taken("box", THERE)
    assert (again.left, again.seen) == ({}, {}), "in the hand it stands nowhere"


def test_what_slipped_was_not_let_go_of() -> None:
    lost = Carried().taken("box", THERE).slipped()
    assert (lost.held, lost.left) == (None, {})


@pytest.mark.parametrize(("away", "stands"), [(0.0, True), (0.04, True), (-0.04, True), (0.07, False), (-0.07, False)])
def test_a_thing_stands_where_it_was_let_go_of_until_it_is_seen_to_have_moved(away: float, stands: bool) -> None:
    """A twentieth of the demonstrated range."""
    model, _, _ = learned()
    put = Carried().taken("box", THERE).let_go(ROOT)
    np.testing.assert_array_equal(where(put, model, off_by(0.9))["box"], ROOT, "nothing was measured since: believed")
    put, held = put.settled("box", THERE), Carried().taken("box", THERE)
    for variable in "xyz":
        assert held.stayed(model, off_by(away, variable)) == stands
    assert held.stayed(model, off_by(0.8, "water")), "what it holds says nothing about where it is"
    assert not Carried().stayed(model, off_by(0.0))


def test_where_a_thing_is_its_readings_tell_however_it_was_let_go_of() -> None:
    """A usual grasp would have it there: the hand that let go of it had slipped by two fifths of its range."""
    model, _, _ = learned()
    there = where(Carried(), model, off_by(0.0))["box"]
    for variable, i in (("x", 0), ("y", 1), ("z", 2)):
        now = off_by(0.4, variable)
        put = Carried().taken("box", THERE).let_go(there).settled("box", now["box"])
        slip = now["box"] - THERE
        went = where(put, model, now)["box"][:3] - there[:3]
        assert np.linalg.norm(went) == pytest.approx(slip[i]), "in a frame that is turned to the robot's"
        assert slip[i] > 0.01


def test_what_slipped_in_the_hand_is_where_it_is_read_at_the_same_tick() -> None:
    model, _, _ = learned()
    held, now = Carried().taken("box", THERE), readings(fresh())
    usual = where(Carried(), model, now)["box"]
    for slip in (0.0, 0.02):
        low = {**now, "hand": usual, "box": now["box"] - np.eye(len(THERE))[2] * slip}
        before = {n: low[n] - np.eye(len(low[n]))[2] * 0.03 for n in ("hand", "box")}
        rows = [{**now, **before}, low]
        command = usual + np.eye(4)[2] * 0.06
        found = replace(held, ticks=5).where(model, rows, now, command)["box"]
        np.testing.assert_allclose(found, command - np.eye(4)[2] * slip, atol=1e-4, err_msg="it moves with the hand")
    fresh_in_hand = [{**now, "hand": usual - 0.2}, {**now, "hand": usual}]
    np.testing.assert_allclose(held.where(model, fresh_in_hand, now, usual)["box"], usual, atol=1e-9)


def test_in_the_air_is_where_nothing_was_ever_put() -> None:
    model, _, _ = learned()
    held, now = Carried().taken("box", THERE), off_by(0.0)
    assert held.in_the_air(model, TAKE, off_by(0.4, "z"))
    assert not held.in_the_air(model, TAKE, now), "where it was taken"
    for place in model.edges[TAKE].examples.deactivations.after["box"]:
        assert not held.in_the_air(model, TAKE, {**now, "box": place}), "where it was let go of in a demonstration"
    assert not Carried().in_the_air(model, TAKE, off_by(0.4, "z"))


def test_what_moves_while_the_robot_does_not_hold_it_is_counted() -> None:
    model, _, _ = learned()
    places = Places().seen(model, off_by(0.0), None)
    assert places.moved == 0
    assert set(places.at) == {"box", "valve"}
    assert places.seen(model, off_by(0.04), None).moved == 0, "not clearly elsewhere"
    moved = places.seen(model, off_by(0.07), None)
    assert moved.moved == 1
    assert moved.seen(model, off_by(0.07), None).moved == 1, "once"
    assert moved.seen(model, off_by(0.0), None).moved == 2
    held = moved.seen(model, off_by(0.5), "box")
    assert (held.moved, set(held.at)) == (1, {"valve"}), "the robot moves it"
    assert held.seen(model, off_by(0.9), None).moved == 1, "where it is let go of, it stands from then on"


def test_where_a_thing_stood_still_by_itself_is_known_from_then_on() -> None:
    model, _, _ = learned()
    places = Places()
    for tick in range(2 * LEARNING.look):
        assert len(places.stood.get("box", ())) == (tick >= LEARNING.look)
        places = places.seen(model, off_by(0.0), None)
    for away in (0.1, 0.2, 0.3, 0.4, 0.5):
        places = places.seen(model, off_by(away), None)
    assert len(places.stood["box"]) == 1, "it was on its way"
    for _ in range(LEARNING.look):
        places = places.seen(model, off_by(0.9), "box")
    assert len(places.stood["box"]) == 1, "the robot holds it there"
    for _ in range(LEARNING.look):
        places = places.seen(model, off_by(0.9), None)
    np.testing.assert_array_equal(places.stood["box"], [THERE, off_by(0.9)["box"]])
    in_hand = {**off_by(0.0), "hand": model.edges[TAKE].examples.active["hand"][0]}
    in_hand["box"] = model.edges[TAKE].examples.active["box"][0]
    assert model.decide(TAKE, in_hand) >= 0
    for _ in range(2 * LEARNING.look):
        places = places.seen(model, in_hand, None)
    assert len(places.stood["box"]) == 2, "in the hand it does not stand by itself, whoever knows of that"


@pytest.mark.parametrize("holds", [True, False])
def test_what_another_robot_holds_does_not_stand_by_itself(*, holds: bool) -> None:
    x = (Variable("x", "m"),)
    spaces = {n: StateSpace(n, x) for n in ("left", "right", "jug")}
    graph = InteractionGraph(spaces, ["left->jug", "right->jug"], robots=("left", "right"))
    near = lambda edge, s: 0.1 - abs(float(s[edge.child][0] - s[edge.parent][0]))  # noqa: E731
    one = {n: np.ones(1) for n in spaces}
    model: Any = SimpleNamespace(
        graph=graph, edges=dict.fromkeys(graph.interactions), decide=near, noise=one, low={"jug": np.zeros(1)}, high=one
    )
    now = {"left": np.zeros(1), "right": np.array([0.5 if holds else 0.8]), "jug": np.array([0.5])}
    places = Places()
    for _ in range(LEARNING.look):
        places = places.seen(model, now, None)
    assert len(places.stood.get("jug", ())) == (not holds)
