"""One gated effect: what acts and when, found in turns; what is known of it counts; what is left out judges it."""

from dataclasses import replace

import numpy as np
import pytest

from ichain_drake.graph import Interaction
from ichain_drake.learning.discovery.log import RawPiece, make_log
from ichain_drake.learning.discovery.residual import Residual
from ichain_drake.learning.discovery.settings import DISCOVERY
from ichain_drake.learning.discovery.term_fit import fit_passive, fit_term, judged
from ichain_drake.state import FloatArray, Role, StateSpace, Variable

TICKS, NOISE = 160, 1e-5
PRESS = Interaction("hand", "box")


def residual(
    hand: FloatArray, box: FloatArray, known: FloatArray | None = None, role: str = "", window: int = 1
) -> Residual:
    """Of a box, with a hand and a lamp that does what it likes, all read with some noise."""
    rng = np.random.default_rng(7)
    pose = tuple(Variable(a, role=Role("position", "table", a)) for a in "xy") if role else (Variable("x"),)
    spaces = {
        "hand": StateSpace("hand", pose),
        "box": StateSpace("box", pose),
        "lamp": StateSpace("lamp", (Variable("z"),)),
    }
    states = {"hand": hand, "box": box, "lamp": rng.normal(size=(len(hand), 1))}
    states = {n: (s if s.ndim > 1 else s[:, None]) for n, s in states.items()}
    states = {n: s + NOISE / np.sqrt(2.0) * rng.normal(size=s.shape) for n, s in states.items()}
    log = make_log([RawPiece("p", states, {} if known is None else {PRESS: known})], spaces, "hand", {})
    for noise in log.noise.values():
        noise[:] = NOISE / np.sqrt(2.0)
    made = Residual(log, "box", dict.fromkeys(range(len(pose)), None))
    made.leave((), window)
    return made


def pressed(change: float | FloatArray = 0.1, seed: int = 0) -> tuple[FloatArray, FloatArray, FloatArray]:
    """A hand that jumps about; while it is beyond 0.5 at the end of a tick, the box changes."""
    hand = np.random.default_rng(seed).uniform(0.0, 1.0, TICKS + 1)
    hand += 0.2 * (hand > 0.5)  # it is never near the border
    on = hand[1:] > 0.5
    return hand, np.r_[0.0, np.cumsum(on * change)], on


def test_a_gate_and_what_it_adds_are_found_together() -> None:
    hand, box, on = pressed()
    made = residual(hand, box)
    term = fit_term(made, "hand")
    assert term is not None
    (effect,) = term.effects
    assert (term.parent, term.child, effect.columns, term.window) == ("hand", "box", (), 1)
    assert effect.coefficients == pytest.approx([0.1], abs=1e-3)
    np.testing.assert_array_equal(term.on, on)
    assert term.objects == {"hand"}
    assert term.gate.faces == 1
    np.testing.assert_allclose(term.evidence, np.where(on, DISCOVERY.clip, -DISCOVERY.clip))
    assert term.value == pytest.approx(DISCOVERY.clip * on.sum() - DISCOVERY.face - effect.price())
    np.testing.assert_allclose(term.predicted[:, 0], effect.coefficients[0])
    assert not term.left_out.any(), "not judged yet"
    found = judged(made, term)
    np.testing.assert_allclose(found.left_out, np.where(on, DISCOVERY.clip, 0.0))
    assert found.gain == pytest.approx(DISCOVERY.clip * on.sum())
    assert replace(found, left_out=term.left_out) == term or found.value == term.value


def test_who_does_nothing_has_no_effect_that_is_worth_anything() -> None:
    hand, box, _ = pressed()
    lamp = fit_term(residual(hand, box), "lamp")
    assert lamp is None or judged(residual(hand, box), lamp).gain < DISCOVERY.least
    assert fit_term(residual(hand, np.zeros(TICKS + 1)), "hand") is None


def test_a_search_may_begin_with_ticks_that_are_named() -> None:
    hand, box, on = pressed()
    made = residual(hand, box)
    term = fit_term(made, "hand", start=on)
    assert term is not None
    np.testing.assert_array_equal(term.on, on)
    assert fit_term(made, "hand", start=~on) is None, "in these nothing happens"


def test_a_gate_may_look_at_other_objects_where_it_is_let() -> None:
    rng = np.random.default_rng(1)
    hand, _, _ = pressed()
    made = residual(hand, np.zeros(TICKS + 1))
    lamp = made.log.states["lamp"][:, 0]
    box = np.r_[0.0, np.cumsum(0.1 * (lamp[1:] > 0.0) * (hand[1:] > 0.5))]
    made = residual(hand, box + NOISE * rng.normal(size=TICKS + 1))
    alone, both = fit_term(made, "hand"), fit_term(made, "hand", ["lamp"])
    assert alone is not None
    assert both is not None
    assert (alone.objects, both.objects) == ({"hand"}, {"hand", "lamp"})
    assert both.others == ("lamp",)
    assert both.value > alone.value
    assert judged(made, both).gain > 0.75 * DISCOVERY.clip * both.on.sum(), "borders differ a little without a part"


def test_what_others_switch_is_not_the_doing_of_an_object_that_nothing_looks_at() -> None:
    lamp = residual(np.zeros(TICKS + 1), np.zeros(TICKS + 1)).log.states["lamp"][:, 0]
    hand = pressed(seed=3)[0]
    made = residual(hand, np.r_[0.0, np.cumsum(0.1 * (lamp[1:] > 0.0))])
    mine = fit_term(made, "lamp")
    assert mine is not None
    assert judged(made, mine).gain > 0.9 * DISCOVERY.clip * mine.on.sum()
    term = fit_term(made, "hand", ["lamp"], start=mine.on)
    assert term is None or made.log.spaces["hand"].names[0] in " ".join(term.text(("x",)).split("while")[1:])


def test_left_out_ticks_are_judged_by_what_the_others_say() -> None:
    """Of two parts that show the one and two that show another, the rest always tells the wrong one."""
    hand, _, on = pressed()
    made = residual(hand, np.zeros(TICKS + 1))
    by_part = np.where(made.log.fold < 2, 0.1, 0.2)
    made = residual(hand, np.r_[0.0, np.cumsum(on * by_part)])
    term = fit_term(made, "hand", start=on & (made.log.fold < 2))
    assert term is not None
    assert term.value > 0.4 * DISCOVERY.clip * on.sum()
    assert judged(made, term).gain < 0.1 * term.value


@pytest.mark.parametrize("known", [1.0, 0.0])
def test_what_is_known_of_a_status_is_evidence_enough(known: float) -> None:
    hand, box, on = pressed()
    told = np.full(TICKS + 1, np.nan)
    told[40:60] = known
    term = fit_term(residual(hand, box, told), "hand")
    assert term is not None
    ends = np.zeros(TICKS + 1, dtype=bool)
    ends[40:60] = True
    sure = ends[1:]
    np.testing.assert_array_equal(term.evidence[sure], DISCOVERY.clip if known else -DISCOVERY.clip)
    np.testing.assert_array_equal(term.evidence[~sure], np.where(on, DISCOVERY.clip, -DISCOVERY.clip)[~sure])


def test_a_step_is_no_line() -> None:
    """Of an input that is here or there a line says the same; a gate and a constant do so with fewer parameters."""
    rng = np.random.default_rng(3)
    on = rng.uniform(size=TICKS + 1) > 0.6
    hand = np.where(on, 0.8, 0.2) + 0.02 * rng.uniform(-1.0, 1.0, TICKS + 1)
    made = residual(hand, np.r_[0.0, np.cumsum(20.0 * NOISE * on[1:])])
    term = fit_term(made, "hand", start=np.ones(TICKS, dtype=bool))
    assert term is not None
    assert [e.columns for e in term.effects] == [()]
    np.testing.assert_array_equal(term.on, on[1:])


def test_what_is_carried_moves_as_its_hand_does_along_a_turned_frame() -> None:
    rng = np.random.default_rng(2)
    step = rng.uniform(-0.05, 0.05, (TICKS, 2))
    on = np.arange(TICKS) % 40 >= 20
    hand = np.cumsum(np.r_[np.zeros((1, 2)), step], axis=0)
    start = np.array([0.02, -0.01])
    box = np.cumsum(np.r_[start[None], step * on[:, None]], axis=0)
    term = fit_term(residual(hand, box, role="position"), "hand")
    assert term is not None
    assert term.alignment is not None
    assert [e.declared for e in term.effects] == [True, True]
    assert (term.evidence > DISCOVERY.shows)[on].mean() > 0.9
    np.testing.assert_allclose(term.predicted[on], step[on], atol=5 * NOISE)


def test_what_an_object_does_by_itself_is_told_by_its_own_variables_at_all_times() -> None:
    rng = np.random.default_rng(4)
    box = [5.0]
    for _ in range(TICKS):
        box.append(box[-1] - 0.2 * (box[-1] - 1.0) + (2.0 if rng.uniform() < 0.03 else 0.0))
    made = residual(rng.uniform(0.0, 1.0, TICKS + 1), np.array(box))
    term = fit_passive(made)
    assert term is not None
    (effect,) = term.effects
    assert (term.parent, term.child, effect.columns) == ("box", "box", (0,))
    assert effect.coefficients[1] == pytest.approx(-0.2, abs=0.05)
    assert term.gate.faces == 0
    assert term.on.all()
    assert term.value == pytest.approx(float(term.evidence.sum()) - effect.price())
    assert term.gain == pytest.approx(float(term.evidence.sum()), rel=0.2)
    assert fit_passive(residual(*pressed()[:2])) is None, "what is done to it is not what it does"
    assert fit_passive(residual(rng.uniform(0, 1, TICKS + 1), np.zeros(TICKS + 1))) is None


def by_itself(share: FloatArray) -> FloatArray:
    """A place that an object goes back from by a share in each tick, and is thrown out of now and then."""
    rng = np.random.default_rng(4)
    out = [5.0]
    for k in range(TICKS):
        out.append(out[-1] - share[k] * (out[-1] - 1.0) + (2.0 if rng.uniform() < 0.03 else 0.0))
    return np.array(out)


def test_what_it_does_by_itself_is_judged_by_what_the_other_ticks_say() -> None:
    hand = np.random.default_rng(0).uniform(0.0, 1.0, TICKS + 1)
    fold = residual(hand, np.zeros(TICKS + 1)).log.fold
    term = fit_passive(residual(hand, by_itself(np.where(fold < 2, 0.1, 0.4))))
    assert term is None or term.gain < 0.5 * float(term.evidence.sum())
    same = fit_passive(residual(hand, by_itself(np.full(TICKS, 0.2))))
    assert same is not None
    assert same.gain > 0.9 * float(same.evidence.sum()) > 0.0


def test_what_one_variable_does_to_another_is_not_taken_for_what_it_does_by_itself() -> None:
    rng = np.random.default_rng(5)
    speed = rng.uniform(-1.0, 1.0, TICKS + 1)
    speed[1::2] = speed[::2][: len(speed[1::2])]  # as one reading before
    place = np.r_[0.0, np.cumsum(0.1 * np.r_[speed[0], speed[:-2]])]
    made = residual(np.zeros((TICKS + 1, 2)), np.column_stack([place, speed]), role="position")
    term = fit_passive(made)
    assert term is None or all(e.columns == (e.variable,) for e in term.effects)
