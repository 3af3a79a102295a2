"""Whether what was saved is for what is here: each difference is refused by name, and what doesn't matter isn't."""

from dataclasses import replace
from typing import Any

import pytest

from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.learning.library.fit import check_fit, check_graph, check_space, check_time
from ichain_drake.learning.library.manifest import TIME_CONVENTION
from ichain_drake.state import Role, StateSpace, Variable
from ichain_drake.timing import TICK

HAND = StateSpace("hand", (Variable("x", "m", role=Role("position", "room", "x")), Variable("grip", kind="binary")))
CUP = StateSpace(
    "cup", (Variable("water", "l", 0.0, 1.0, role=Role("amount")), Variable("heat", role=Role("intensive", of="water")))
)
MANIFEST = {"period": TICK, "time": TIME_CONVENTION, "targets": ["water"]}


def with_variable(space: StateSpace, index: int, **more: Any) -> StateSpace:
    variables = list(space.variables)
    variables[index] = replace(variables[index], **more)
    return StateSpace(space.type, tuple(variables))


@pytest.mark.parametrize(
    ("here", "message"),
    [
        (StateSpace("mug", CUP.variables), "type: it is cup, here it is mug"),
        (StateSpace("cup", CUP.variables[:1]), "variable heat: the graph's object doesn't have it"),
        (StateSpace("cup", (*CUP.variables, Variable("lid"))), "variable lid: the library's link doesn't know it"),
        (StateSpace("cup", CUP.variables[::-1]), "variable water: heat stands in its place"),
        (with_variable(CUP, 0, unit="ml"), "variable water: its unit is l in the library, ml here"),
        (with_variable(CUP, 1, kind="integer"), "variable heat: its kind is real in the library, integer here"),
        (with_variable(CUP, 1, role=None), "its role is intensive of 'water' in the library, none here"),
    ],
)
def test_the_variable_that_differs_is_named(here: StateSpace, message: str) -> None:
    with pytest.raises(InputError, match=f"lib: cup.*{message}|lib: {message}"):
        check_space(CUP, here, "lib: cup" if "type" not in message else "lib")


def test_a_frame_and_an_axis_are_parts_of_a_role_and_bounds_are_no_matter() -> None:
    check_space(CUP, with_variable(CUP, 0, lower=-5.0, upper=9.0), "lib")
    check_space(HAND, HAND, "lib")
    other = with_variable(HAND, 0, role=Role("position", "table", "x"))
    with pytest.raises(
        InputError, match="role is position frame 'room' axis 'x' in the library, position frame 'table'"
    ):
        check_space(HAND, other, "lib")


def test_period_and_convention_of_time_are_the_same() -> None:
    check_time(MANIFEST, "lib")
    check_time(MANIFEST | {"period": TICK * (1 + 1e-12)}, "lib")
    for period in (0.5 * TICK, TICK * (1 + 1e-6), TICK * (1 - 1e-6)):
        with pytest.raises(InputError, match=f"lib: period: it was learned at {period:.6g} s"):
            check_time(MANIFEST | {"period": period}, "lib")
    with pytest.raises(InputError, match="lib: time: its convention is 'another'"):
        check_time(MANIFEST | {"time": "another"}, "lib")


def test_a_link_is_for_its_two_ends_and_what_is_wanted_of_it() -> None:
    check_fit(MANIFEST, (HAND, CUP), (HAND, CUP), ["water"], "lib")
    with pytest.raises(InputError, match="lib: parent hand: variable grip"):
        check_fit(MANIFEST, (HAND, CUP), (StateSpace("hand", HAND.variables[:1]), CUP), ["water"], "lib")
    with pytest.raises(InputError, match="lib: child: type: it is cup, here it is hand"):
        check_fit(MANIFEST, (HAND, CUP), (HAND, HAND), ["water"], "lib")
    with pytest.raises(InputError, match="targets: its inverse models bring about water of cup, here heat are wanted"):
        check_fit(MANIFEST, (HAND, CUP), (HAND, CUP), ["heat"], "lib")


def graph(*names: str, edges: tuple[str, ...] = ("hand->cup",)) -> InteractionGraph:
    return InteractionGraph({n: HAND if n == "hand" else replace(CUP, type=n) for n in names}, list(edges))


def test_a_graph_is_the_same_whatever_its_order() -> None:
    two = graph("hand", "cup", "mug", edges=("hand->cup", "hand->mug"))
    check_graph(MANIFEST, two, graph("mug", "hand", "cup", edges=("hand->mug", "hand->cup")), "lib")
    for saved, here, message in (
        (two, graph("hand", "cup"), "object mug: this graph doesn't have it"),
        (graph("hand", "cup"), two, "object mug: the library's graph doesn't know it"),
        (
            two,
            graph("hand", "cup", "mug", edges=("hand->cup", "cup->mug")),
            "interaction hand->mug: this graph doesn't",
        ),
    ):
        with pytest.raises(InputError, match=f"lib: {message}"):
            check_graph(MANIFEST, saved, here, "lib")
    wet = InteractionGraph({"hand": HAND, "cup": with_variable(CUP, 0, unit="ml")}, ["hand->cup"])
    with pytest.raises(InputError, match="lib: cup cup: variable water: its unit"):
        check_graph(MANIFEST, graph("hand", "cup"), wet, "lib")
    with pytest.raises(InputError, match="period"):
        check_graph(MANIFEST | {"period": 1.0}, two, two, "lib")
