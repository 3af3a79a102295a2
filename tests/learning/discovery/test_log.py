"""States of pieces as ticks: which rows begin one, which are left out together, and what is known of statuses."""

import numpy as np
import pytest

from ichain_drake.graph import Interaction
from ichain_drake.learning.discovery.log import Log, RawPiece, make_log
from ichain_drake.learning.discovery.settings import DISCOVERY
from ichain_drake.state import Role, StateSpace, Variable

SPACES = {
    "hand": StateSpace("hand", tuple(Variable(a, role=Role("position", "table", a)) for a in "xy")),
    "box": StateSpace("box", (Variable("x"),)),
    "lid": StateSpace("lid", (Variable("on"),)),
}
SIZES = {"a": 5, "b": 30}
PRESS = Interaction("hand", "lid")


def pieces() -> list[RawPiece]:
    rng = np.random.default_rng(0)
    out = []
    for name, n in SIZES.items():
        known = {PRESS: np.r_[np.nan, np.ones(n - 1)]} if name == "a" else {}
        out.append(RawPiece(name, {o: rng.normal(size=(n, len(s))) for o, s in SPACES.items()}, known))
    return out


def made(order: int = 1) -> Log:
    return make_log(pieces()[::order], SPACES, "hand", {})


def first(log: Log) -> list[int]:
    """First row of each piece."""
    return [0, len(log.data.pieces[0])]


def test_a_tick_starts_at_every_row_but_the_last_of_a_piece() -> None:
    log = made()
    a, b = first(log)
    assert [len(p) for p in pieces()] == [5, 30]
    assert sorted(set(range(35)) - set(log.t.tolist())) == [b - 1, 34]
    np.testing.assert_array_equal(log.tick_piece, log.piece[log.t])
    before = log.t - 1
    before[np.isin(log.t, [a, b])] += 1
    np.testing.assert_array_equal(log.back, before)
    rows = {p.name: p.states["box"] for p in pieces()}
    np.testing.assert_array_equal(log.states["box"], np.vstack([rows[p.name] for p in log.data.pieces]))


def test_neither_the_order_of_pieces_nor_names_change_anything() -> None:
    one, other = made(), made(-1)
    for name in SPACES:
        np.testing.assert_array_equal(one.states[name], other.states[name])
    assert one.data.edges == other.data.edges
    renamed = {f"_{n}": s for n, s in reversed(SPACES.items())}
    moved = [RawPiece(p.name, {f"_{n}": s for n, s in p.states.items()}) for p in pieces()]
    again = make_log(moved, renamed, "_hand", {})
    assert [(f"_{e.parent}", f"_{e.child}") for e in one.data.edges] == [(e.parent, e.child) for e in again.data.edges]
    assert one.data.variables == {n[1:]: v for n, v in again.data.variables.items()}


def test_everything_may_act_on_all_but_the_root_and_itself() -> None:
    pairs = {(e.parent, e.child) for e in made().data.edges}
    assert pairs == {("hand", "box"), ("hand", "lid"), ("box", "lid"), ("lid", "box")}
    assert not any(f.any() for p in made().data.pieces for f in p.flags.values())


def test_successive_ticks_go_together_in_a_block_and_a_block_in_a_part() -> None:
    log = made()
    length = 2 * DISCOVERY.window
    for k in range(2):
        block = log.block[log.tick_piece == k]
        np.testing.assert_array_equal(block - block[0], np.arange(len(block)) // length)
    assert not set(log.block[log.tick_piece == 0]) & set(log.block[log.tick_piece == 1])
    assert sorted(set(log.block)) == list(range(4))
    for k in set(log.block):
        assert len(set(log.fold[log.block == k])) == 1
    assert len(set(log.fold)) == min(4, DISCOVERY.parts)


def test_what_is_known_of_a_status_is_that_at_the_ends_of_ticks() -> None:
    log = made()
    assert list(log.known) == [PRESS]
    short = log.piece[log.t] == [len(p) for p in log.data.pieces].index(5)
    assert log.known[PRESS][short].tolist() == [1.0] * 4
    assert np.isnan(log.known[PRESS][~short]).all()
    unknown = [RawPiece(p.name, p.states, {PRESS: np.full(len(p), np.nan)}) for p in pieces()]
    assert make_log(unknown, SPACES, "hand", {}).known == {}


def test_frames_of_the_root_are_not_turned_unless_it_is_known_that_they_are() -> None:
    np.testing.assert_array_equal(made().turns["table"], np.eye(2))
    turned = -np.eye(2)
    assert make_log(pieces(), SPACES, "hand", {"table": turned}).turns["table"] is turned


@pytest.mark.parametrize("ticks", [[0], [1, 3], [3], [4, 5], [32]])
def test_rows_of_ticks_are_those_at_their_ends_and_the_first_goes_with_its_tick(ticks: list[int]) -> None:
    log = made()
    mask = np.isin(np.arange(len(log.t)), ticks)
    expected = {int(log.t[k]) + 1 for k in ticks}
    expected |= {int(log.t[k]) for k in ticks if log.t[k] in first(log)}
    assert set(np.flatnonzero(log.rows_of(mask)).tolist()) == expected


def test_arrays_over_rows_are_split_into_pieces() -> None:
    log = made()
    parts = log.split(np.arange(35))
    assert [len(p) for p in parts] == [len(p) for p in log.data.pieces]
    assert np.concatenate(parts).tolist() == list(range(35))
