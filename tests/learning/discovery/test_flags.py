"""Statuses of rows: by the gate, closed to where something was seen to act; by what was seen where it is clear."""

import numpy as np
import pytest

from ichain_drake.graph import Interaction
from ichain_drake.learning.discovery.flags import EdgeFlags, edge_flags, open_stretches
from ichain_drake.learning.discovery.gate import Gate
from ichain_drake.learning.discovery.inputs import gate_inputs
from ichain_drake.learning.discovery.log import Log, RawPiece, make_log
from ichain_drake.learning.discovery.residual import Residual
from ichain_drake.learning.discovery.structure import Explained
from ichain_drake.learning.discovery.term import Term, VariableEffect
from ichain_drake.state import Role, StateSpace, Variable

X = Variable("x", "m", role=Role("position", "table", "x"))
SPACES = {
    "hand": StateSpace("hand", (X, Variable("grip", kind="binary", lower=0, upper=1))),
    "box": StateSpace("box", (X, Variable("heat"))),
    "lid": StateSpace("lid", (Variable("open"),)),
}
ROWS = 201
AT = np.linspace(-1.0, 1.0, ROWS)  # of the hand; the box stands at 0
HAND, LID = Interaction("hand", "box"), Interaction("lid", "box")


def log(grip: np.ndarray | None = None, known: np.ndarray | None = None) -> Log:
    states = {
        "hand": np.c_[AT, np.zeros(ROWS) if grip is None else grip],
        "box": np.zeros((ROWS, 2)),
        "lid": np.linspace(0.0, 1.0, ROWS)[:, None],
    }
    made = make_log([RawPiece("p", states, {} if known is None else {HAND: known})], SPACES, "hand", {})
    for noise in made.noise.values():
        noise[:] = 0.0
    return made


def term(
    made: Log,
    evidence: np.ndarray,
    faces: dict[str, tuple[float, float]] | None = None,
    parent: str = "hand",
    window: int = 1,
) -> Term:
    """What heats the box, with evidence for every tick and faces by the inputs' labels."""
    inputs = gate_inputs(made, parent, "box", None, ("lid",))
    low, high = np.full(len(inputs.items), -np.inf), np.full(len(inputs.items), np.inf)
    for k, item in enumerate(inputs.items):
        low[k], high[k] = (faces or {}).get(item.label, (-np.inf, np.inf))
    gate, predicted = Gate(low, high), np.zeros((len(evidence), 2))
    effect = VariableEffect(1, False, (), np.ones(1), 1.0)
    return Term(
        parent, "box", (effect,), gate, inputs.items, (), None, ("lid",), window, gate.holds(inputs.values),
        predicted, evidence, 1.0, evidence,
    )  # fmt: skip


def flags(made: Log, *terms: Term) -> dict[Interaction, EdgeFlags]:
    return edge_flags(made, Explained(Residual(made, "box", {0: None, 1: None}), terms, ((),) * len(terms)))


def closed(at: np.ndarray, low: float = -0.145, high: float = 0.105) -> np.ndarray:
    """What is left of an open gate where it acts within 0.1.

    98 % of that, and further on both sides by .15 of the width of 90 % of it: up to 0.123; a place counts a reading
    before the tick starts, two rows before its end.
    """
    return (at > low) & (at < high)


def at_ends(near: float, said: float, elsewhere: float = 0.0) -> np.ndarray:
    """Evidence of ticks at whose ends the hand is so near the box."""
    return np.where(np.abs(AT[1:]) < near + 1e-9, said, elsewhere)


@pytest.mark.parametrize("said", [8.0, 2.0])
def test_a_gate_that_nothing_speaks_against_is_closed_around_where_it_was_seen_to_act(said: float) -> None:
    made = log()
    found = flags(made, term(made, at_ends(0.1, said)))
    assert set(found) == {HAND}
    np.testing.assert_array_equal(found[HAND].on[1:], closed(AT[1:]))
    np.testing.assert_array_equal(found[HAND].open[1:], np.abs(AT[1:]) > 0.105)


def test_a_gate_is_left_open_where_it_was_hardly_seen_to_act_or_was_seen_almost_everywhere() -> None:
    made = log()
    assert flags(made, term(made, at_ends(0.01, 8.0)))[HAND].on.all()
    assert flags(made, term(made, at_ends(0.9, 8.0)))[HAND].on.all()


def test_a_face_that_evidence_put_near_stays() -> None:
    made = log()
    faces = {"box relative to hand, x": (-0.2, np.inf)}
    on = flags(made, term(made, at_ends(0.1, 8.0), faces))[HAND].on
    np.testing.assert_array_equal(on[1:], closed(AT[1:], high=0.205))


def test_what_was_clearly_seen_in_a_tick_is_its_status_whatever_the_gate_says() -> None:
    made = log()
    evidence = at_ends(0.1, 8.0)
    evidence[[97, 150]] = -7.0
    evidence[160] = 7.0
    evidence[170] = 5.0  # not so sure
    faces = {"hand at table x": (-np.inf, 0.5)}
    expected = closed(AT[1:])
    expected[[97, 160]] = False, True
    np.testing.assert_array_equal(flags(made, term(made, evidence, faces))[HAND].on[1:], expected)


def test_evidence_that_is_smeared_over_a_window_tells_no_single_tick() -> None:
    made = log()
    evidence = at_ends(0.1, 8.0)
    evidence[97] = -7.0
    on = flags(made, term(made, evidence, window=6))[HAND].on
    np.testing.assert_array_equal(on[1:], closed(AT[1:]))


def test_between_switchings_the_status_of_a_grip_is_one() -> None:
    grip = ((np.arange(ROWS) // 40) % 2).astype(float)
    made = log(grip)
    said = np.zeros(ROWS - 1)
    said[45:50], said[125:127] = 2.0, -5.0  # in the first stretch in which it is closed, and in the second
    on = flags(made, term(made, said, {"hand.grip": (0.5, np.inf), "hand at table x": (-0.5, np.inf)}))[HAND].on
    np.testing.assert_array_equal(on[:200], (np.arange(200) >= 40) & (np.arange(200) < 80))


def test_without_evidence_a_stretch_goes_with_most_of_its_rows() -> None:
    grip = ((np.arange(ROWS) // 40) % 2).astype(float)
    made, quiet = log(grip), np.zeros(ROWS - 1)
    for least, expected in ((AT[50], True), (AT[70], False)):
        faces = {"hand.grip": (0.5, np.inf), "hand at table x": (float(least), float(AT[100]))}
        on = flags(made, term(made, quiet, faces))[HAND].on
        np.testing.assert_array_equal(on, expected & (np.arange(ROWS) >= 40) & (np.arange(ROWS) < 80))


def test_an_object_that_only_a_gate_looks_at_shares_the_status_and_so_does_the_cause_of_what_a_child_does_alone() -> (
    None
):
    made = log()
    said, faces = np.full(ROWS - 1, 2.0), {"lid.open": (0.5025, np.inf)}
    found = flags(made, term(made, said, faces))
    assert set(found) == {HAND, LID}
    for edge in (HAND, LID):
        np.testing.assert_array_equal(found[edge].on[1:], np.arange(1, ROWS) > 100)
    alone = flags(made, term(made, said, faces, parent="box"))
    assert set(alone) == {LID}
    assert flags(made, term(made, said, parent="box")) == {}
    both = flags(made, term(made, said, faces, parent="box"), term(made, at_ends(0.1, 8.0), parent="lid"))
    assert set(both) == {LID}
    np.testing.assert_array_equal(both[LID].open[1:], np.abs(AT[1:]) > 0.105)


def test_what_is_known_is_kept_and_not_open() -> None:
    known = np.full(ROWS, np.nan)
    known[20:30], known[99:103] = 1.0, 0.0
    made = log(known=known)
    found = flags(made, term(made, at_ends(0.1, 8.0)))[HAND]
    expected = closed(AT)
    expected[20:30], expected[99:103] = True, False
    np.testing.assert_array_equal(found.on, expected)
    np.testing.assert_array_equal(found.open[1:], (np.abs(AT[1:]) > 0.105) & np.isnan(known[1:]))


def test_the_longest_open_stretches_come_first() -> None:
    rows = np.array([1, 1, 0, 1, 0, 1, 1, 1, 0, 1, 1, 1, 1], dtype=bool)
    assert open_stretches(rows, 3) == [(9, 13), (5, 8), (0, 2)]
    assert open_stretches(~rows, 1) == [(2, 3)]


def test_the_first_stretch_of_a_grip_is_one_like_any_other() -> None:
    grip = ((np.arange(ROWS) // 40) % 2 == 0).astype(float)
    said = np.zeros(ROWS - 1)
    said[5:10] = 2.0  # together it is clear
    on = flags(log(grip), term(log(grip), said, {"hand.grip": (0.5, np.inf), "hand at table x": (-0.5, np.inf)}))
    assert on[HAND].on[:40].all()
    assert not on[HAND].on[40:80].any()
