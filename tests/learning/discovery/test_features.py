"""Columns of an effect in all ticks: a reading's noise is no motion and no flow."""

import numpy as np
import pytest

from ichain_drake.learning.discovery.features import Features, _alive, features
from ichain_drake.learning.discovery.log import RawPiece, make_log
from ichain_drake.learning.discovery.residual import Residual
from ichain_drake.learning.effects.alignment import Alignment, PositionGroup
from ichain_drake.state import FloatArray, Role, StateSpace, Variable

NOISE = 0.01
AMOUNT, HEAT = Variable("amount", role=Role("amount")), Variable("heat", role=Role("intensive", of="amount"))
PLACE = tuple(Variable(a, role=Role("position", "table", a)) for a in "xy")


def residual(spaces: dict[str, StateSpace], states: dict[str, FloatArray]) -> Residual:
    """Of the last object; read with this noise."""
    log = make_log([RawPiece("p", states)], spaces, next(iter(spaces)), {})
    for noise in log.noise.values():
        noise[:] = NOISE
    child = list(spaces)[-1]
    return Residual(log, child, dict.fromkeys(range(len(spaces[child])), None))


def poured(flow: list[float]) -> tuple[Residual, Features]:
    """A jug that loses so much in each tick; its heat is 3, that of the cup 1."""
    amount = 10.0 - np.r_[0.0, np.cumsum(flow)]
    rows = len(amount)
    states = {
        "hand": np.linspace(0.0, 1.0, rows)[:, None],
        "jug": np.c_[amount, np.full(rows, 3.0)],
        "cup": np.c_[np.full(rows, 2.0), np.ones(rows)],
    }
    spaces = {
        "hand": StateSpace("hand", (Variable("x"),)),
        **{n: StateSpace(n, (AMOUNT, HEAT)) for n in ("jug", "cup")},
    }
    made = residual(spaces, states)
    return made, features(made, "jug", None)


def by_label(found: Features, text: str) -> FloatArray:
    (k,) = [k for k, label in enumerate(found.labels) if label.startswith(text)]
    return found.values[:, k]


def test_what_flows_is_received_and_mixed_and_nothing_flows_back() -> None:
    _, found = poured([0.0, 1.0, 1.0, 0.0, 0.0, 0.0, -1.0, 0.0])
    np.testing.assert_allclose(by_label(found, "received"), [0, 1, 1, 0, 0, 0, 0, 0], atol=1e-9)
    np.testing.assert_allclose(by_label(found, "mixing"), np.array([0, 1, 1, 0, 0, 0, 0, 0]) / 3.0 * 2.0, atol=1e-4)


def test_a_flow_within_the_noise_of_readings_is_none() -> None:
    _, found = poured([0.0, 0.5 * NOISE, 0.0, 0.0, 0.0])
    assert not by_label(found, "received").any()


def test_columns_know_their_noise_and_what_roles_declare() -> None:
    made, found = poured([0.0, 1.0, 0.0])
    received, mixing = (next(k for k, n in enumerate(found.labels) if n.startswith(w)) for w in ("received", "mixing"))
    assert found.declared == {0: (received,), 1: (mixing,)}
    assert [found.labels[found.own[i]] for i in (0, 1)] == ["child amount", "child heat"]
    changes = [k for k, n in enumerate(found.labels) if n.startswith("change of")]
    expected = np.zeros(len(found.labels))
    expected[[received, *changes]] = NOISE
    np.testing.assert_array_equal(found.noise, expected)
    assert not found.passive
    np.testing.assert_array_equal(by_label(found, "child heat"), made.lagged[:, 1])


def test_motion_with_the_parent_is_that_beyond_the_noise_of_readings() -> None:
    rng = np.random.default_rng(0)
    step = np.where(np.arange(40)[:, None] % 2, 20.0 * NOISE, 0.1 * NOISE) * rng.choice([-1.0, 1.0], (40, 2))
    hand = np.cumsum(np.r_[np.zeros((1, 2)), step], axis=0)
    spaces = {"hand": StateSpace("hand", PLACE), "box": StateSpace("box", PLACE)}
    made = residual(spaces, {"hand": hand, "box": np.zeros_like(hand) + rng.normal(size=hand.shape)})
    group = PositionGroup("table", ("x", "y"), (0, 1))
    alignment = Alignment(group, group, (), np.eye(2), np.zeros((2, 0)), np.zeros(2), 20, 0.0)
    made.log.noise["hand"][:] = [0.5 * NOISE, 1.5 * NOISE]
    found = features(made, "hand", alignment)
    motion = [k for k, label in enumerate(found.labels) if label.startswith("motion")]
    np.testing.assert_allclose(found.noise[motion], NOISE)
    np.testing.assert_allclose(found.values[:, motion], np.where(np.arange(40)[:, None] % 2, step, 0.0), atol=1e-12)
    assert found.declared == {0: (motion[0],), 1: (motion[1],)}


def test_of_what_an_object_does_by_itself_its_own_variables_tell_one_reading_before() -> None:
    space = StateSpace("top", (Variable("x"), Variable("yaw", "rad", kind="angle"), Variable("z")))
    states = np.random.default_rng(0).normal(size=(20, 3))
    made = residual(
        {"hand": StateSpace("hand", (Variable("x"),)), "top": space}, {"hand": states[:, :1], "top": states}
    )
    found = features(made, "top", None)
    assert found.labels == ("x", "cos(yaw)", "sin(yaw)", "z")
    lagged = states[np.maximum(np.arange(19) - 1, 0)]
    np.testing.assert_array_equal(
        found.values, np.c_[lagged[:, 0], np.cos(lagged[:, 1]), np.sin(lagged[:, 1]), lagged[:, 2]]
    )
    assert (found.own, found.declared, found.passive) == ({0: 0, 2: 3}, {}, True)
    assert not found.noise.any()


@pytest.mark.parametrize(
    ("change", "alive"),
    [
        ([0, 4.4, 0, 0], [False, True, False, False]),  # clear together with those beside it
        ([0, 3.4, 0, 0], [False, False, False, False]),
        ([3, 4.4, -4, 0], [True, False, False, False]),  # it goes back at once
        ([3, 4.6, -4, 0], [True, True, False, False]),  # clear by itself
        ([1.1, 1.1, 1.4, 0.9], [False, True, False, False]),  # three at a time make one
        ([0, 0, -4.4, 0], [False, False, True, False]),
    ],
)
def test_a_change_is_one_with_those_beside_it_or_by_itself(change: list[float], alive: list[bool]) -> None:
    states = np.random.default_rng(0).normal(size=(5, 1))
    made = residual({n: StateSpace(n, (Variable("x"),)) for n in ("hand", "box")}, {"hand": states, "box": states})
    assert _alive(made, np.array(change, dtype=float), 1.0).tolist() == alive


def test_ticks_of_another_piece_are_not_beside_it() -> None:
    spaces = {n: StateSpace(n, (Variable("x"),)) for n in ("hand", "box")}
    states = np.random.default_rng(0).normal(size=(8, 1))
    pieces = [RawPiece(n, {"hand": s, "box": s}) for n, s in (("a", states[:4]), ("b", states[4:]))]
    made = Residual(make_log(pieces, spaces, "hand", {}), "box", {0: None})
    change = np.array([0.0, 0.0, 2.0, 2.0, 0.0, 0.0])
    assert not _alive(made, change, 1.0).any()
    assert _alive(made, np.roll(change, 1), 1.0).tolist() == [False, False, False, True, True, False]
