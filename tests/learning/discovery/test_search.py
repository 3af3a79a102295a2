"""What is searched in which order and in which pieces, and what is told of an edge that was found."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ichain_drake.graph import Interaction
from ichain_drake.learning.discovery import search as searching
from ichain_drake.learning.discovery.log import RawPiece
from ichain_drake.learning.discovery.search import _edges, _in_order, _log, _telling, search
from ichain_drake.learning.discovery.settings import DISCOVERY
from ichain_drake.learning.discovery.structure import Rival
from ichain_drake.state import Role, StateSpace, Variable

PLACE = (Variable("x", role=Role("position", "room", "x")),)
SPACES = {
    "hand": StateSpace("hand", PLACE), "lamp": StateSpace("lamp", (Variable("on"),)), "box": StateSpace("box", PLACE),
    "tank": StateSpace("tank", (Variable("level"),)),
}  # fmt: skip


def piece(name: str, *objects: str, seed: int = 0) -> RawPiece:
    rng = np.random.default_rng([seed, len(name)])
    return RawPiece(name, {n: rng.normal(size=(30, len(SPACES[n]))) for n in objects})


PIECES = [piece("a", "hand", "lamp", "box", "tank"), piece("bb", "hand", "lamp"), piece("ccc", "lamp", "tank")]


def every(*names: str) -> list[Interaction]:
    return [Interaction(a, b) for a in names for b in names if b not in (a, "hand")]


def test_what_has_a_place_is_looked_at_first_and_names_are_no_matter() -> None:
    order = _in_order(PIECES, SPACES, "hand", every(*SPACES))
    assert order[0] == "box"
    assert sorted(order) == ["box", "lamp", "tank"]
    renamed = [RawPiece(p.name, {f"z{n}": s for n, s in p.states.items()}) for p in PIECES]
    spaces = {f"z{n}": s for n, s in reversed(SPACES.items())}
    candidates = [Interaction(f"z{e.parent}", f"z{e.child}") for e in every(*SPACES)]
    assert _in_order(renamed, spaces, "zhand", candidates) == [f"z{n}" for n in order]
    assert _in_order(PIECES, SPACES, "hand", [Interaction("hand", "tank")]) == ["tank"], "on which something may act"
    assert _in_order(PIECES[1:2], SPACES, "hand", every(*SPACES)) == ["lamp"], "that was seen at all"


def test_pieces_that_hold_the_robot_tell_what_it_did_and_others_only_where_none_does() -> None:
    assert _telling(PIECES, "lamp", "hand") == (0, 1)
    assert _telling(PIECES, "tank", "hand") == (0,)
    assert _telling(PIECES[2:], "tank", "hand") == (0,)
    assert _telling([piece("d", "lamp")], "lamp", "hand") == (), "alone it tells nothing"


def test_a_log_has_the_objects_that_all_of_its_pieces_hold() -> None:
    log = _log(PIECES, (0, 1), "lamp", SPACES, "hand", {})
    assert (set(log.spaces), log.root) == ({"hand", "lamp"}, "hand")
    alone = _log(PIECES, (2,), "tank", SPACES, "hand", {})
    assert (set(alone.spaces), alone.root) == ({"lamp", "tank"}, "lamp"), "another stands for the robot"
    assert _log(PIECES, (2,), "lamp", SPACES, "hand", {}).root == "tank"


def test_each_object_is_explained_by_its_candidates_in_the_log_that_tells_of_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked: list[tuple[str, list[str], list[str], Any]] = []
    said: list[str] = []

    def explain(log: Any, child: str, parents: list[str], needed: list[str]) -> Any:
        asked.append((child, sorted(parents), needed, log))
        return SimpleNamespace()

    monkeypatch.setattr(searching, "explain", explain)
    monkeypatch.setattr(searching, "_edges", lambda log, found: [len(log.spaces)])
    candidates = [Interaction(a, b) for a, b in (("hand", "lamp"), ("box", "lamp"), ("hand", "box"), ("lamp", "tank"))]
    required = [Interaction("hand", "lamp"), Interaction("tank", "lamp")]
    out = search(PIECES, SPACES, "hand", candidates, required, said.append)
    told = {child: (parents, needed) for child, parents, needed, _ in asked}
    assert told == {"box": (["hand"], []), "lamp": (["hand"], ["hand"]), "tank": (["lamp"], [])}
    assert sorted(said) == [f"what acts on {n}" for n in ("box", "lamp", "tank")]
    logs = {child: log for child, _, _, log in asked}
    assert logs["box"] is logs["tank"] and logs["lamp"] is not logs["box"]
    assert sorted(out) == [2, 4, 4]


def test_what_is_told_of_an_edge_is_that_of_its_terms() -> None:
    log: Any = SimpleNamespace(
        data=SimpleNamespace(pieces=[SimpleNamespace(name="p"), SimpleNamespace(name="q")]),
        split=lambda rows: [rows[:3], rows[3:]], block=np.arange(4),
    )  # fmt: skip

    def term(parent: str, gain: float, shows: list[int], objects: tuple[str, ...] = ()) -> Any:
        evidence = np.where(np.isin(np.arange(4), shows), 2.0 * DISCOVERY.shows, 0.5 * DISCOVERY.shows)
        return SimpleNamespace(
            parent=parent, gain=gain, on=np.array([True, True, True, False]), evidence=evidence,
            left_out=np.full(4, gain / 4), objects={parent, *objects}, text=lambda names: f"{parent} by {names[0]}",
        )  # fmt: skip

    edges = {Interaction(n, "box"): np.array([True] * 5) for n in ("hand", "lid")}
    flags = {e: SimpleNamespace(on=on, open=~on) for e, on in edges.items()}
    found: Any = SimpleNamespace(
        residual=SimpleNamespace(child="box", space=SimpleNamespace(names=("x",))),
        terms=(term("hand", 30.0, [0, 3], ("lid",)), term("hand", 10.0, [2]), term("box", 50.0, [1])),
        rivals=((Rival("fan", 0.25), Rival("box", 0.9)), (Rival("tap", 0.1),), ()),
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(searching, "edge_flags", lambda log, found: flags)
        hand, lid = _edges(log, found)
    assert (hand.edge.parent, hand.gain, hand.gates, hand.ticks) == ("hand", 40.0, False, 2)
    assert hand.text == ("hand by x", "hand by x")
    assert [r.parent for r in hand.rivals] == ["fan", "tap"], "what it does alone is no rival"
    sure = searching.certainty(np.full(4, 7.5), log)
    assert hand.confidence == pytest.approx(sure * 0.75)
    assert {n: on.tolist() for n, on in hand.on.items()} == {"p": [True] * 3, "q": [True] * 2}
    assert not any(rows.any() for rows in hand.open.values())
    assert (lid.edge.parent, lid.gain, lid.gates, lid.ticks, lid.rivals) == ("lid", 30.0, True, 1, ())
    assert lid.confidence == pytest.approx(sure)
