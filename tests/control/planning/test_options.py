"""Where a drive begins: quiet, near the driving pose, and where the object has been before it was turned."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from toy_models import tap

from ichain_drake.control.planning.carries import CarryOption, find_carries
from ichain_drake.control.planning.drive_option import DriveOption
from ichain_drake.control.planning.frames import Frames
from ichain_drake.control.planning.options import (
    _in_context,
    _joint_samples,
    _probe,
    _quiet_row,
    _shown,
    _subsumed,
    _unseen,
    chains,
    find_drives,
)
from ichain_drake.control.settings import PLANNING
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.rules import without
from ichain_drake.state import Role, StateSpace, Variable

CARRY = Interaction("robot", "cup")


def model(seen: list[list[float]], *, roles: bool = True) -> SimpleNamespace:
    place = Role("position", "world", "z") if roles else None
    cup = StateSpace("cup", (Variable("z", "m", role=place), Variable("tilt", "rad")))
    graph = InteractionGraph({"robot": StateSpace("robot", (Variable("z", "m"),)), "cup": cup}, ["robot->cup"])
    active = {"robot": np.zeros((len(seen), 1)), "cup": np.array(seen)}
    edges = {CARRY: SimpleNamespace(examples=SimpleNamespace(active=active))}
    return SimpleNamespace(graph=graph, edges=edges, noise={"cup": np.array([0.002, 0.02])})


def carry() -> CarryOption:
    return CarryOption(CARRY, np.array([0, 1]), np.array([[0.1, 0.0], [0.2, 0.02]]))


def test_a_low_place_that_was_only_seen_turned_is_far_from_what_was_seen() -> None:
    # The cup was low when tilted; upright it was never below 0.4.
    seen = model([[0.5, 0.0], *[[0.4, 0.0]] * 3, [0.4, -1.2], *[[0.28, -1.2]] * 3])
    width = np.array([0.5, 2.0])
    away = _unseen(seen, carry(), np.array([[0.4, -0.8], [0.28, -1.2]]), width)  # type: ignore[arg-type]
    np.testing.assert_allclose(away, [0.005, 0.12 / 0.5 + 0.005], atol=1e-9)


def test_where_a_thing_was_only_ever_turned_it_was_not_shown() -> None:
    """The cup was as low as 0.31 when tilted; upright something stopped it at 0.32: five noises above."""
    seen = model([*[[0.35, 0.0]] * 3, [0.35, -1.2], *[[0.32, 0.0]] * 3, *[[0.31, -1.2]] * 3])
    poses = np.array([[0.354, -1.2], [0.31, -1.2]])
    assert _shown(seen, carry(), poses).tolist() == [True, True]  # type: ignore[arg-type]
    seen.noise["cup"] /= 2.0
    assert _shown(seen, carry(), poses).tolist() == [True, False]  # type: ignore[arg-type]


def test_what_was_passed_through_once_is_not_taken_for_seen() -> None:
    passed = model([*[[0.5, 0.0]] * 3, [0.28, 0.0]])
    away = _unseen(passed, carry(), np.array([[0.5, 0.0], [0.28, 0.0]]), np.array([0.5, 2.0]))  # type: ignore[arg-type]
    np.testing.assert_allclose(away, [0.005, 0.22 / 0.5 + 0.005], atol=1e-9)
    few = model([[0.5, 0.0], [0.28, 0.0]])
    assert _unseen(few, carry(), np.array([[0.5, 0.0]]), np.array([0.5, 2.0]))[0] > 0.4  # type: ignore[arg-type]


def test_a_drive_begins_quietly_where_the_cup_was_let_go_rather_than_nearest_to_where_it_drives() -> None:
    seen = model([[0.5, 0.0]], roles=False)
    seen.low = {"cup": np.zeros(2), "robot": np.zeros(1)}
    seen.high = {"cup": np.array([0.5, 2.0]), "robot": np.ones(1)}
    poses = np.array([[0.5, -1.0], [0.2, 0.0], [0.45, -0.9], [0.2, 0.0]])
    robot = np.array([[0.0], [0.4], [0.0], [0.1]])  # the hand of the last is less far away
    batch, quiet = {"cup": poses, "robot": robot}, np.array([False, True, True, True])
    assert _quiet_row(seen, carry(), batch, quiet, 0) == 3  # type: ignore[arg-type]
    quiet[[1, 3]] = False
    assert _quiet_row(seen, carry(), batch, quiet, 0) == 2  # type: ignore[arg-type]
    assert _quiet_row(seen, carry(), batch, np.zeros(4, dtype=bool), 0) == 0  # type: ignore[arg-type]


def test_without_positions_every_pose_is_as_good() -> None:
    seen = model([[0.5, 0.0]], roles=False)
    assert not _unseen(seen, carry(), np.array([[0.4, -0.8]]), np.array([0.5, 2.0])).any()  # type: ignore[arg-type]


def test_a_drive_is_found_from_where_there_is_room_for_it() -> None:
    """The fastest sample of a fire that grows with its heat stands just below the hottest there is."""
    spaces = {n: StateSpace(n, (Variable("z", upper=1.0),)) for n in ("robot", "knob", "pot")}
    turn, heat = Interaction("robot", "knob"), Interaction("knob", "pot")
    still = np.zeros((40, 1))
    samples = {"robot": still, "knob": still, "pot": np.linspace(0.2, 0.97, 40)[:, None]}

    def step(states: dict, root: np.ndarray, active: object = None, *, strict: bool = True) -> tuple[dict, dict]:
        return {"robot": root, "knob": states["knob"], "pot": np.minimum(states["pot"] * 1.01, 1.0)}, {}

    examples = SimpleNamespace(active=samples)
    fire = SimpleNamespace(
        graph=InteractionGraph(spaces, ["robot->knob", "knob->pot"]),
        edges={
            e: SimpleNamespace(examples=examples, effects=[SimpleNamespace(variable=0)], alignment=None, relative=False)
            for e in (turn, heat)
        },
        passive={n: SimpleNamespace(variables=[SimpleNamespace(kind="hold")]) for n in ("knob", "pot")},
        low=dict.fromkeys(spaces, np.zeros(1)),
        high=dict.fromkeys(spaces, np.ones(1)),
        noise=dict.fromkeys(spaces, np.full(1, 0.004)),
        decide=lambda e, states: np.ones(len(states["pot"])),
        step=step,
    )
    drives = find_drives(fire, ())  # type: ignore[arg-type]
    assert [(d.chain, d.direction) for d in drives] == [((turn, heat), 1)]


def test_what_is_spilled_by_tilting_does_not_follow_the_hand() -> None:
    cup = StateSpace("cup", (Variable("z", "m"), Variable("tilt", "rad"), Variable("water", lower=0.0)))
    graph = InteractionGraph({"robot": StateSpace("robot", (Variable("z", "m"), Variable("roll", "rad"))), "cup": cup},
                             ["robot->cup"])  # fmt: skip
    rng = np.random.default_rng(0)
    pose = np.column_stack([rng.uniform(0, 0.5, 60), rng.uniform(-0.95, 0.3, 60)])
    samples = {"robot": pose, "cup": np.column_stack([pose, np.full(60, 0.6)])}

    def effect(edge: Interaction, states: dict, parent_next: np.ndarray) -> np.ndarray:
        moved = parent_next - states["robot"]
        return np.column_stack([moved, -0.3 * np.maximum(-0.9 - parent_next[:, 1], 0.0)])

    examples = SimpleNamespace(active=samples, deactivations=SimpleNamespace(after=samples))
    model = SimpleNamespace(
        graph=graph,
        edges={CARRY: SimpleNamespace(examples=examples, alignment=None, relative=False)},
        passive={"cup": SimpleNamespace(variables=[SimpleNamespace(kind="hold")] * 3)},
        low={"cup": np.zeros(3)},
        high={"cup": np.ones(3)},
        noise={"cup": np.full(3, 0.001)},
        step_limit={"robot": np.array([0.04, 0.2])},
        effect=effect,
    )
    (carry,) = find_carries(model)  # type: ignore[arg-type]
    assert carry.follow.tolist() == [0, 1]


PUSH = Interaction("robot", "bell")


def bell(low: float = -1.0, high: float = 1.0) -> SimpleNamespace:
    """A robot on a rail rings a bell for good by being within 10 cm of it."""
    rail = Role("position", "rail", "x")
    spaces = {
        "robot": StateSpace("robot", (Variable("x", "m", low, high, role=rail),)),
        "bell": StateSpace("bell", (Variable("x", "m", role=rail), Variable("rung", lower=0, upper=1, kind="binary"))),
    }

    def decide(edge: Interaction, states: dict) -> np.ndarray:
        return 0.1 - np.abs(states["robot"][..., 0] - states["bell"][..., 0])

    def step(states: dict, root: np.ndarray, active: object = None, *, strict: bool = True) -> tuple[dict, dict]:
        rung = np.maximum(states["bell"][:, 1], decide(PUSH, states | {"robot": root}) >= 0)
        return {"robot": root, "bell": np.stack([states["bell"][:, 0], rung], axis=1)}, {}

    near = np.array([-0.09, -0.05, 0.0, 0.06])
    after = {"robot": near[:, None], "bell": np.tile([0.0, 1.0], (4, 1))}
    before = {"robot": near[:1, None] - 0.05, "bell": np.array([[0.0, 0.0]])}
    begun = SimpleNamespace(before=before, after={n: v[:1] for n, v in after.items()})
    learned = SimpleNamespace(
        examples=SimpleNamespace(active=after, activations=begun), effects=[SimpleNamespace(variable=1)],
        alignment=None, relative=True,
    )  # fmt: skip
    return SimpleNamespace(
        graph=InteractionGraph(spaces, ["robot->bell"]),
        edges={PUSH: learned},
        passive={"bell": SimpleNamespace(variables=[SimpleNamespace(kind="hold")] * 2)},
        low={"robot": np.full(1, -1.0), "bell": np.zeros(2)},
        high={"robot": np.ones(1), "bell": np.ones(2)},
        noise={"robot": np.full(1, 1e-9), "bell": np.full(2, 1e-9)},
        decide=decide,
        step=step,
    )


def drive_of(learned: SimpleNamespace) -> DriveOption:
    (drive,) = find_drives(learned, ())
    return drive


def test_what_is_done_for_good_at_first_touch_is_driven_from_as_it_was_before() -> None:
    """In all rows in which the two touch the bell has been rung; it is held by the surest of them, not the first."""
    drive = drive_of(bell())
    assert (drive.chain, drive.variable, drive.direction, drive.anchor) == ((PUSH,), 1, 1, "bell")
    assert drive.hold["bell"][1] == 0.0
    assert drive.hold["robot"][0] == 0.0
    assert len(drive.others["robot"]) == 4


def test_of_several_ways_of_holding_it_the_surest_within_reach_is_taken() -> None:
    learned = bell()
    drive, frames = drive_of(learned), Frames(learned)
    robot = [
        None if (placed := drive.placed(frames, {"bell": np.array([x, 0.0])})) is None else placed.hold["robot"][0]
        for x in (0.5, 1.04, 1.2)
    ]
    np.testing.assert_allclose(robot[:2], [0.5, 0.99])
    assert robot[2] is None


def test_a_quiet_beginning_is_placed_where_its_object_is_too() -> None:
    learned = bell()
    found = drive_of(learned)
    before = found.hold | {"robot": found.hold["robot"] - 0.3}
    none = {n: v[:0] for n, v in found.others.items()}
    drive = replace(found, before=before, others=none).placed(Frames(learned), {"bell": np.array([0.5, 0.0])})
    assert drive is not None
    np.testing.assert_allclose([drive.hold["robot"][0], drive.before["robot"][0]], [0.5, 0.2])


def test_how_near_a_quiet_pose_is_counts_by_the_range_of_each_variable() -> None:
    """Off by .2 of .5 m it is farther away than by .5 of 2 rad."""
    seen = model([[0.5, 0.0]], roles=False)
    seen.low = {"cup": np.zeros(2), "robot": np.zeros(1)}
    seen.high = {"cup": np.array([0.5, 2.0]), "robot": np.ones(1)}
    poses = np.array([[0.3, 1.0], [0.1, 1.0], [0.3, 0.5]])
    known = CarryOption(CARRY, np.array([0, 1]), poses)
    batch = {"cup": poses, "robot": np.zeros((3, 1))}
    with without(["unseen"]):
        assert _quiet_row(seen, known, batch, np.array([False, True, True]), 0) == 2  # type: ignore[arg-type]


TAKE, PRESS, RUN, FALL = (
    Interaction(*e) for e in (("robot", "cup"), ("robot", "tap"), ("tap", "tank"), ("tank", "cup"))
)


def test_all_chains_from_the_robot_on_are_found_short_ones_first() -> None:
    model: Any = tap()
    found = chains(model)
    assert [len(c) for c in found] == [1, 1, 2, 3]
    assert set(found) == {(TAKE,), (PRESS,), (PRESS, RUN), (PRESS, RUN, FALL)}


def test_a_chain_is_driven_from_states_in_which_all_of_it_is_active() -> None:
    model: Any = tap()
    joint = _joint_samples(model, (PRESS, RUN, FALL))
    on = [model.decide(e, joint) >= 0 for e in (PRESS, RUN, FALL)]
    assert len(joint["cup"]) > 0
    assert np.all(on)
    every = {n: np.concatenate([model.edges[e].examples.active[n] for e in (PRESS, RUN, FALL)]) for n in joint}
    active = np.all([model.decide(e, every) >= 0 for e in (PRESS, RUN, FALL)], axis=0)
    for name, rows in joint.items():
        np.testing.assert_array_equal(rows, every[name][active])
    many = model.edges[PRESS].examples
    many.active = {n: np.concatenate([v[:1]] * (3 * PLANNING.poses)) for n, v in many.active.items()}
    many.active["tank"][:, 0] = np.linspace(0.0, 1.0, 3 * PLANNING.poses)
    few = _joint_samples(model, (PRESS,))["tank"][:, 0]
    assert len(few) == PLANNING.poses
    np.testing.assert_allclose(few, np.linspace(0.0, 1.0, PLANNING.poses), atol=0.02)


def test_what_changes_over_some_ticks_with_the_robot_held_is_predicted() -> None:
    """Water falls by .04 a tick; the cup stands under the tap in the first, and beside it in the second."""
    model: Any = tap()
    one = {"robot": [2.0, 0.0], "tap": [1.0], "tank": [0.8, 0.0], "cup": [1.0, 0.1]}
    batch = {n: np.array([v, v]) for n, v in one.items()}
    batch["cup"][1, 0] = 0.0
    change = _probe(model, batch, 5)
    np.testing.assert_allclose(change["tank"][:, 0], -0.2)
    np.testing.assert_allclose(change["cup"][:, 1], [0.2, 0.0])
    np.testing.assert_allclose(change["cup"][:, 0], 0.0)
    np.testing.assert_array_equal(batch["tank"][:, 0], 0.8, "what is handed in stays")
    long = _probe(model, batch, 40)
    np.testing.assert_allclose(long["tank"][:, 0], -0.8, atol=0.04, err_msg="until it is empty")


def test_a_drive_says_how_fast_it_is_and_from_where() -> None:
    model: Any = tap()
    found = {d.chain[-1]: d for d in find_drives(model, find_carries(model))}
    assert set(found) == {RUN, FALL}
    fill, drain = found[FALL], found[RUN]
    assert (fill.variable, fill.direction, drain.variable, drain.direction) == (1, 1, 0, -1)
    assert fill.rate == pytest.approx(0.04)
    assert drain.rate == pytest.approx(0.04)
    for drive in (fill, drain):
        assert drive.carry is None
        assert abs(drive.hold["robot"][0] - 2.0) < 0.05
        np.testing.assert_array_equal(drive.before["robot"], drive.hold["robot"])
        assert all(model.decide(e, drive.hold) >= 0 for e in drive.chain)


def test_what_a_longer_chain_says_of_a_carried_object_is_not_said_by_a_shorter_one() -> None:
    model: Any = tap()
    (carry,) = find_carries(model)
    under = {
        "robot": np.array([1.0, 1.0]),
        "tap": np.zeros(1),
        "tank": np.array([0.8, 0.0]),
        "cup": np.array([1.0, 0.1]),
    }
    beside_ = {**under, "cup": np.array([0.2, 0.1])}
    pour = Interaction("cup", "pot")
    model.decide = lambda e, states: 0.1 - np.abs(states["cup"][..., 0] - 1.0)
    short, long = (DriveOption(c, 1, 1, 0.1, carry, under, under) for c in ((TAKE,), (TAKE, pour)))
    assert _subsumed(model, short, [short, long])
    assert not _subsumed(model, short, [short])
    assert not _subsumed(model, long, [short, long])
    assert not _subsumed(model, replace(short, hold=beside_), [short, long]), "where that is not active"
    assert not _subsumed(model, replace(short, carry=None), [short, long])
    with without(["subsumed"]):
        assert not _subsumed(model, short, [short, long])


def test_samples_are_compared_in_the_surroundings_of_one_of_them() -> None:
    model: Any = tap()
    (carry,) = find_carries(model)
    batch = {
        "robot": np.array([[1.9, 0.0], [2.1, 1.0]]), "tap": np.array([[0.1], [0.2]]),
        "tank": np.array([[0.3, 0.0], [0.4, 0.1]]), "cup": np.array([[0.5, 0.6], [0.7, 0.8]]),
    }  # fmt: skip
    out = _in_context(model, Frames(model), (PRESS, RUN), None, batch, 1, None)
    np.testing.assert_array_equal(out["robot"], batch["robot"])
    np.testing.assert_array_equal(out["tap"], batch["tap"], "the first object is as it was in each")
    np.testing.assert_array_equal(out["tank"], [[0.4, 0.1]] * 2)
    np.testing.assert_array_equal(out["cup"], [[0.7, 0.8]] * 2)
    held = _in_context(model, Frames(model), (TAKE,), carry, batch, 0, None)
    np.testing.assert_array_equal(held["cup"], [[0.5, 0.6], [0.7, 0.6]], "where it is carried, not what is in it")
    np.testing.assert_array_equal(held["tank"], [[0.3, 0.0]] * 2)
