"""Terms beside each other: which are taken back, which gates look further, and whose motion turns a frame."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

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
