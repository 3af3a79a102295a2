"""Parts that are known before: what is left of them, and examples of theirs beside those that are shown here."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.known import KnownParts, joined_examples, typical_row
from ichain_drake.learning.settings import LEARNING
from ichain_drake.learning.status.events import EdgeExamples, Switching
from ichain_drake.state import StateSpace, Variable

TAKE, LIFT, PRESS = (Interaction(*e) for e in (("hand", "cup"), ("cup", "lid"), ("hand", "tap")))
ITEM: Any = SimpleNamespace()


def known() -> KnownParts:
    passive = {n: SimpleNamespace(passive=None if n == "hand" else ITEM) for n in ("hand", "cup", "lid", "tap")}
    per_edge: Any = dict.fromkeys((TAKE, LIFT, PRESS), ITEM)
    return KnownParts(
        per_edge, passive, (TAKE, PRESS), per_edge, per_edge,
        dict.fromkeys(per_edge, "lib"), dict.fromkeys(per_edge, 5.0),
        {Interaction("a", "b"): "too few"}, {TAKE.name: ITEM, LIFT.name: ITEM}, ITEM,
    )  # type: ignore[arg-type] # fmt: skip


def test_without_an_interaction_all_about_it_is_gone() -> None:
    rest = known().without({LIFT: "another lid"})
    for part in (rest.edges, rest.activations, rest.deactivations, rest.sources, rest.robot_seconds):
        assert set(part) == {TAKE, PRESS}
    assert set(rest.objects) == {"hand", "cup", "tap"}
    assert rest.elsewhere == (TAKE, PRESS)
    assert rest.reasons == {Interaction("a", "b"): "too few", LIFT: "another lid"}
    assert (set(rest.links), rest.command) == ({TAKE.name}, ITEM)
    first = known().without({TAKE: "another cup", PRESS: "stiff"})
    assert (set(first.edges), first.elsewhere, first.command) == ({LIFT}, (), None), "the hand is learned anew with it"
    assert set(first.objects) == {"hand", "lid"}
    assert known().names == (TAKE.name, LIFT.name, PRESS.name, TAKE.name, LIFT.name)


def test_an_object_stays_known_while_something_known_acts_on_it() -> None:
    other = Interaction("tap", "cup")
    parts = KnownParts({TAKE: ITEM, other: ITEM}, {"hand": ITEM, "cup": ITEM})
    assert set(parts.without({other: "wet"}).objects) == {"hand", "cup"}


def test_it_is_whole_where_nothing_is_left_to_be_learned() -> None:
    spaces = {n: StateSpace(n, (Variable("x"),)) for n in ("hand", "cup", "lid", "tap")}
    graph = InteractionGraph(spaces, [TAKE, LIFT, PRESS])
    assert known().is_whole(graph)
    assert not known().without({LIFT: ""}).is_whole(graph)
    assert not KnownParts(known().edges, {n: v for n, v in known().objects.items() if n != "hand"}).is_whole(graph)
    nothing = {n: SimpleNamespace(passive=None) for n in spaces}
    assert not KnownParts(known().edges, nothing).is_whole(graph)  # type: ignore[arg-type]


def test_a_typical_state_is_the_nearest_to_the_middle_of_each_variable_in_its_range() -> None:
    states = np.array([[0.0, 0.0], [5.0, 100.0], [4.0, 55.0], [10.0, 50.0], [6.0, 45.0]])
    assert typical_row(states).tolist() == [4.0, 55.0]
    assert typical_row(np.array([[1.0, 3.0], [2.0, 3.0], [9.0, 3.0]])).tolist() == [2.0, 3.0]


def switching(*rows: float, piece: str = "p", lid: bool = True) -> Switching:
    def states(shift: float) -> dict[str, np.ndarray]:
        out = {"cup": np.array(rows)[:, None] + shift}
        return out | ({"lid": 10.0 + np.array(rows)[:, None]} if lid else {})

    return Switching(states(0.0), states(0.5), (piece,) * len(rows), tuple(int(r) for r in rows))


def examples(*rows: float, piece: str = "p", lid: bool = True) -> EdgeExamples:
    part = switching(*rows, piece=piece, lid=lid)
    return EdgeExamples(part, part, dict(part.after), dict(part.before))


TYPICAL = {"cup": np.array([7.0]), "lid": np.array([9.0])}


def test_what_was_not_there_before_stands_where_it_usually_does() -> None:
    alone = joined_examples(examples(1.0, 2.0, lid=False), None, TYPICAL, elsewhere=False)
    for part in (alone.activations.before, alone.activations.after, alone.deactivations.before, alone.active):
        assert part["lid"].tolist() == [[9.0], [9.0]]
    assert alone.activations.before["cup"].tolist() == [[1.0], [2.0]]
    assert alone.activations.rows == (1, 2)


@pytest.mark.parametrize("elsewhere", [False, True])
def test_what_is_shown_here_comes_first_and_events_of_another_scene_count_only_where_none_are(elsewhere: bool) -> None:
    both = joined_examples(examples(1.0, lid=False), examples(5.0, 6.0, piece="q"), TYPICAL, elsewhere=elsewhere)
    rows = [[5.0], [6.0]] + ([] if elsewhere else [[1.0]])
    assert both.activations.before["cup"].tolist() == rows
    assert both.deactivations.after["cup"].tolist() == [[r[0] + 0.5] for r in rows]
    assert both.activations.pieces == ("q", "q") + (() if elsewhere else ("p",))
    assert both.activations.rows == (5, 6) + (() if elsewhere else (1,))
    assert both.active["cup"].tolist() == [[5.5], [6.5], [1.5]], "states of either status are of use anywhere"
    assert both.inactive["lid"].tolist() == [[15.0], [16.0], [9.0]]
    none = joined_examples(examples(1.0), examples(), TYPICAL, elsewhere=elsewhere)
    assert none.activations.rows == (1,)


def test_of_many_examples_some_are_drawn_evenly() -> None:
    many = LEARNING.examples
    both = joined_examples(
        examples(*np.arange(many, 2.0 * many)), examples(*np.arange(1.0 * many)), TYPICAL, elsewhere=False
    )
    drawn = both.inactive["cup"][:, 0]
    assert len(drawn) == many
    assert (drawn[0], drawn[-1]) == (0.0, 2.0 * many - 1.0)
    assert set(np.diff(drawn)) <= {2.0, 3.0}
    np.testing.assert_allclose(both.inactive["lid"][:, 0], drawn + 10.0)
    exact = joined_examples(examples(1.0), examples(*np.arange(many - 1.0)), TYPICAL, elsewhere=False)
    assert len(exact.active["cup"]) == many
