"""Terms beside each other: which are taken back, which gates look further, and whose motion turns a frame."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.stats import norm

from ichain_drake.learning.discovery import structure
from ichain_drake.learning.discovery.settings import DISCOVERY


class Still:
    """A residual that notes nothing: terms are judged by what is said of them."""

    log = SimpleNamespace(block=np.repeat(np.arange(4), 5))
    child = "box"

    def leave(self, terms: object, window: int) -> None:
        pass


def term(gain: float, value: float = 0.0, parent: str = "hand", objects: tuple[str, ...] = ()) -> Any:
    return SimpleNamespace(
        parent=parent, gate=SimpleNamespace(faces=1), window=1, on=None, value=value, gain=gain,
        left_out=np.full(20, gain / 20), objects={parent, *objects}, price=lambda: 0.0,
    )  # fmt: skip


@pytest.fixture
def judged_as_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(structure, "judged", lambda residual, term: term)
    monkeypatch.setattr(structure, "_refitted", lambda residual, terms, k: terms[k])


@pytest.mark.usefixtures("judged_as_said")
@pytest.mark.parametrize(
    ("gains", "left"), [([0.0], [0.0]), ([0.0, 0.0], [0.0]), ([90.0, 0.0, 80.0], [90.0, 80.0]), ([0.0, 90.0], [90.0])]
)
def test_what_gains_nothing_is_taken_back_but_for_the_last(gains: list[float], left: list[float]) -> None:
    terms: list[Any] = [term(gain) for gain in gains]
    rivals: list[tuple[structure.Rival, ...]] = [() for _ in gains]
    structure._take_back(Still(), terms, rivals, ())  # type: ignore[arg-type]
    assert [t.gain for t in terms] == left
    assert len(rivals) == len(left)


@pytest.mark.usefixtures("judged_as_said")
@pytest.mark.parametrize(
    ("parents", "value", "gain", "looks"),
    [
        (("hand", "lid"), 100.0, 300.0, True),
        (("hand", "lid"), DISCOVERY.other_object, 300.0, False),  # of itself it is worth no more than an object costs
        (("hand", "lid"), 100.0, 200.0 + 0.9 * DISCOVERY.pays_share * 200.0, False),
        (("hand", "lid"), 100.0, 200.0 + 1.1 * max(DISCOVERY.pays, DISCOVERY.pays_share * 200.0), True),
        (("hand",), 100.0, 300.0, False),
    ],
)
def test_a_gate_looks_at_another_object_only_where_that_pays_a_lot(
    parents: tuple[str, ...], value: float, gain: float, looks: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    near, wide = term(200.0), term(gain, value, objects=("lid",))
    monkeypatch.setattr(structure, "fit_term", lambda residual, parent, parents, start: wide)
    found = structure._looking_around(Still(), [], near, parents)  # type: ignore[arg-type]
    assert (found is wide) is looks
    assert found in (near, wide)


@pytest.mark.parametrize("parent", ["arm", "hand", "tray"])
def test_a_frame_is_turned_by_what_moves_with_the_robot_alone(parent: str) -> None:
    turn, before = np.array([[0.0, -1.0], [1.0, 0.0]]), np.array([[-1.0, 0.0], [0.0, -1.0]])
    log = SimpleNamespace(root="hand", turns={"table": before})
    frames = {"parent": SimpleNamespace(frame="table"), "child": SimpleNamespace(frame="camera")}
    moved = SimpleNamespace(
        parent=parent, alignment=SimpleNamespace(**frames, turn=turn), effects=[SimpleNamespace(declared=True)]
    )
    structure._learn_turn(log, moved)  # type: ignore[arg-type]
    assert ("camera" in log.turns) is (parent == "hand")
    if parent == "hand":
        np.testing.assert_array_equal(log.turns["camera"], turn @ before)


@pytest.mark.parametrize(("shared", "same"), [(0, False), (6, False), (8, True), (10, True)])
def test_two_terms_are_of_the_same_ticks_where_most_of_them_are_shared(shared: int, same: bool) -> None:
    ticks = np.arange(30)
    first: Any = SimpleNamespace(on=ticks < 10, evidence=np.full(30, 5.0))
    other: Any = SimpleNamespace(on=(ticks >= 10 - shared) & (ticks < 20 - shared), evidence=np.full(30, 5.0))
    assert structure._same(first, other) is same


LOG: Any = SimpleNamespace(block=np.repeat(np.arange(4), 5), root="hand")


def told(
    gain: float, parent: str = "hand", *, price: float = 0.0, spread: tuple[float, ...] = (1, 1, 1, 1), **more: Any
) -> Any:
    """A term that gains so much on left-out ticks, by so large shares in each of four blocks."""
    shares = np.repeat(np.array(spread, dtype=float) / sum(spread), 5) / 5
    made: dict[str, Any] = {
        "parent": parent, "child": "box", "gain": gain, "left_out": gain * shares, "price": lambda: price,
        "value": gain, "window": 1, "on": np.ones(20, dtype=bool), "evidence": np.full(20, 5.0), "objects": {parent},
        "gate": SimpleNamespace(faces=1), "others": (),
    }  # fmt: skip
    return SimpleNamespace(**made | more)


def test_how_sure_a_gain_is_follows_from_how_blocks_agree() -> None:
    assert structure.certainty(told(40.0).left_out, LOG) == pytest.approx(norm.cdf(40.0 / np.sqrt(4 * 10.0**2)))
    assert structure.certainty(told(40.0, spread=(1, 0, 0, 0)).left_out, LOG) == pytest.approx(norm.cdf(1.0))
    assert structure.certainty(np.zeros(20), LOG) == 0.5
    assert structure.certainty(-told(40.0).left_out, LOG) < 0.05
    assert structure.score(told(40.0, price=15.0), LOG) == 25.0


@pytest.mark.parametrize(("gain", "spread", "pays"), [
    (1.1 * DISCOVERY.least, (1, 1, 1, 1), True),
    (0.9 * DISCOVERY.least, (1, 1, 1, 1), False),
    (90.0, (1, 0, 0, 0), False),
])  # fmt: skip
def test_a_term_pays_where_it_gains_enough_in_more_than_one_block(
    gain: float, spread: tuple[float, ...], *, pays: bool
) -> None:
    assert structure._pays(told(gain, spread=spread), LOG, 1) is pays


def test_what_an_object_is_said_to_do_all_the_time_hardly_a_tick_speaks_against() -> None:
    for against, goes_on in ((1, True), (2, False)):  # of twenty, a twentieth
        evidence = np.where(np.arange(20) < against, -1.1 * DISCOVERY.shows, 3.0)
        assert structure._goes_on(told(9.0, evidence=evidence), LOG) is goes_on
    for evidence, goes_on in ((-0.9 * DISCOVERY.seen / 5, True), (-1.1 * DISCOVERY.seen / 5, False)):  # five ticks each
        stretch = np.where(LOG.block == 2, evidence, 3.0)
        assert (np.abs(stretch[LOG.block == 2]) < DISCOVERY.shows).all()
        assert structure._goes_on(told(9.0, evidence=stretch), LOG) is goes_on


def test_of_terms_of_the_same_ticks_the_nearer_cause_is_taken_before_the_robot() -> None:
    robot, near, nearer = told(100.0, "hand"), told(95.0, "lid"), told(97.0, "lever")
    own, elsewhere = told(99.0, "box"), told(98.0, "fan", on=np.zeros(20, dtype=bool))
    every = [robot, near, nearer, own, elsewhere]
    assert structure._most_direct(robot, every, LOG) is robot, "a little in every block is clear"
    unclear = told(97.0, "lever", spread=(3, 1, 1, 1))
    assert structure._most_direct(robot, [robot, unclear, own, elsewhere], LOG) is unclear
    assert structure._most_direct(robot, [robot, own, elsewhere], LOG) is robot
    assert structure._most_direct(near, [robot, near, unclear], LOG) is near, "what is no robot stays"


@pytest.fixture
def fits(monkeypatch: pytest.MonkeyPatch) -> dict[tuple[str, int], Any]:
    """What is found of each parent in each window."""
    found: dict[tuple[str, int], Any] = {}
    window = [1]
    monkeypatch.setattr(Still, "leave", lambda self, terms, w: window.__setitem__(0, w))
    monkeypatch.setattr(structure, "fit_term", lambda residual, parent, *rest: found.get((parent, window[0])))
    monkeypatch.setattr(structure, "fit_passive", lambda residual: found.get(("passive", window[0])))
    monkeypatch.setattr(structure, "judged", lambda residual, term: term)
    monkeypatch.setattr(structure, "_looking_around", lambda residual, terms, term, parents: term)
    return found


def chosen(
    parents: tuple[str, ...], required: tuple[str, ...] = (), terms: tuple[Any, ...] = ()
) -> tuple[Any, list[str]]:
    residual: Any = Still()
    residual.log = LOG
    best, rivals = structure._next(residual, terms, parents, required)
    return best, [r.parent for r in rivals]


def test_the_term_that_pays_most_comes_next_with_those_that_explain_about_as_much(
    fits: dict[tuple[str, int], Any],
) -> None:
    parents = ("lid", "lever", "fan")
    assert chosen(parents) == (None, [])
    fits[("lid", 1)] = told(100.0, "lid", price=5.0)
    fits[("lever", DISCOVERY.window)] = told(90.0, "lever", window=DISCOVERY.window)
    fits[("fan", 1)] = told(0.5 * DISCOVERY.close * 95.0, "fan", value=100.0)
    fits[("box", 1)] = told(60.0, "box")
    best, rivals = chosen(parents)
    assert (best, rivals) == (fits[("lid", 1)], ["lever"]), "neither what it does itself nor what explains much less"
    fits[("lever", DISCOVERY.window)].on = np.zeros(20, dtype=bool)
    assert chosen(parents)[1] == [], "nor what explains other ticks"


def test_what_is_required_may_gain_little_and_nothing_else_may(fits: dict[tuple[str, int], Any]) -> None:
    fits[("lid", 1)] = told(0.5 * DISCOVERY.least, "lid", value=0.1)
    assert chosen(("lid",)) == (None, [])
    assert chosen(("lid",), ("lid",))[0] is fits[("lid", 1)]
    assert chosen(("lid",), ("lid",), (told(50.0, "lid"),)) == (None, []), "once it is there it is not missing"
    fits[("lid", 1)] = told(-1.0, "lid", value=5.0)
    assert chosen(("lid",), ("lid",)) == (None, []), "but against the evidence it is not"
    fits[("fan", 1)] = told(200.0, "fan")
    fits[("lid", 1)] = told(40.0, "lid", value=0.9 * DISCOVERY.worth * 200.0)
    assert chosen(("lid", "fan"))[0] is fits[("fan", 1)]


def test_what_it_does_by_itself_is_looked_for_tick_by_tick_first(fits: dict[tuple[str, int], Any]) -> None:
    residual: Any = Still()
    residual.log = LOG
    assert structure._passive_motion(residual) is None
    fits[("passive", DISCOVERY.window)] = told(50.0)
    assert structure._passive_motion(residual) is fits[("passive", DISCOVERY.window)]
    fits[("passive", 1)] = told(40.0)
    assert structure._passive_motion(residual) is fits[("passive", 1)]
    fits[("passive", 1)] = told(40.0, evidence=np.full(20, -5.0))
    assert structure._passive_motion(residual) is fits[("passive", DISCOVERY.window)]
