"""Interaction graphs against examples worked out by hand; their drawings."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction, InteractionGraph, write_drawing
from ichain_drake.state import StateSpace, Variable

SPACE = StateSpace("thing", (Variable("a", "m"), Variable("b", "px", hidden=True)))


def graph(names: str, *edges: str) -> InteractionGraph:
    return InteractionGraph(dict.fromkeys(names.split(), SPACE), edges)


# r acts on a and c; a and b act on each other; b and c act on d.
CYCLIC = graph("r a b c d", "r->a", "a->b", "b->a", "r->c", "c->d", "b->d")


def test_neighbours_in_declared_order() -> None:
    assert CYCLIC.root == "r"
    assert CYCLIC.parents("a") == ("r", "b")
    assert CYCLIC.parents("d") == ("c", "b")
    assert CYCLIC.children("b") == ("a", "d")
    assert [e.name for e in CYCLIC.incoming("d")] == ["c->d", "b->d"]


def test_components_hold_cycles_together_and_parents_first() -> None:
    components = CYCLIC.components
    assert sorted(components) == [("a", "b"), ("c",), ("d",), ("r",)]
    assert components[0] == ("r",)
    assert components[-1] == ("d",)


def test_members_of_a_component_keep_the_declared_order() -> None:
    assert ("b", "a") in graph("r b a", "r->a", "a->b", "b->a").components


def test_chains_from_the_robot() -> None:
    assert CYCLIC.chain("d") == ("r", "c", "d")
    assert CYCLIC.chains("d") == (("r", "c", "d"), ("r", "a", "b", "d"))
    assert CYCLIC.chain("r") == ("r",)
    assert CYCLIC.chains("r") == (("r",),)


def test_edges_in_all_three_forms_are_the_same() -> None:
    edges = [Interaction("r", "a"), ("r", "a"), " r -> a "]
    assert {InteractionGraph({"r": SPACE, "a": SPACE}, [e]).interactions for e in edges} == {(Interaction("r", "a"),)}


@pytest.mark.parametrize(
    ("names", "edges", "message"),
    [
        ("r a", ["r->x"], "r->x: there is no object 'x'; objects are r, a"),
        ("r a", ["r->a", "r->a"], "r->a is declared twice"),
        ("r a", ["r->a", "a->a"], "an object can't act on itself"),
        ("r a b", ["r->a"], "exactly one object without parents .* it has 2: r, b; declare several as robots"),
        ("a b", ["a->b", "b->a"], "it has 0: none"),
        ("r a b c", ["r->a", "b->c", "c->b"], "no interaction leads from r to b, c"),
        ("r a", ["r=>a"], "'r=>a': write it as parent->child"),
        ("r a", ["r->a->r"], "write it as parent->child"),
        ("r a->b", ["r->a"], "object name 'a->b'"),
    ],
)
def test_a_graph_that_can_not_work_is_refused(names: str, edges: list[str], message: str) -> None:
    with pytest.raises(InputError, match=message):
        graph(names, *edges)


@pytest.mark.parametrize("ask", [CYCLIC.chain, CYCLIC.chains])
def test_an_unknown_target_is_named(ask: object) -> None:
    with pytest.raises(InputError, match="there is no object 'z'; objects are r, a"):
        ask("z")  # type: ignore[operator]


def test_drawing_shows_objects_edges_and_only_what_is_measured() -> None:
    dot = graph("r a", "r->a").dot()
    assert '"a" [label="a\\na [m]"]' in dot
    assert '"r" -> "a";' in dot
    assert "px" not in dot
    assert graph("r a", "r->a").text() == "r -> a\na -> (nothing)"


def test_dot_file_is_written_as_it_is(tmp_path: Path) -> None:
    write_drawing("digraph {}", tmp_path / "g.dot")
    assert (tmp_path / "g.dot").read_text() == "digraph {}"


def test_rendered_drawing_names_every_object(tmp_path: Path) -> None:
    if shutil.which("dot") is None:
        pytest.skip("Graphviz (`dot`) is not installed")
    write_drawing(CYCLIC.dot(), tmp_path / "g.svg")
    svg = (tmp_path / "g.svg").read_text()
    assert all(f"<title>{name}</title>" in svg for name in "rabcd")


def test_drawing_errors(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InputError, match=r"g\.txt: a drawing ends in"):
        write_drawing("digraph {}", tmp_path / "g.txt")
    with pytest.raises(InputError, match="can't write"):
        write_drawing("digraph {}", tmp_path / "nowhere" / "g.dot")
    if shutil.which("dot"):
        with pytest.raises(InputError, match="can't write"):
            write_drawing("digraph {}", tmp_path / "nowhere" / "g.svg")
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(InputError, match="Graphviz is not installed"):
        write_drawing("digraph {}", tmp_path / "g.svg")


TWO = InteractionGraph(
    {"left": SPACE, "right": SPACE, "a": SPACE, "b": SPACE}, ["left->a", "right->a", "a->b"], robots=("right", "left")
)


def test_several_robots_are_roots_in_the_order_in_which_they_are_declared() -> None:
    assert TWO.roots == ("right", "left")
    assert TWO.root == "right"
    assert [e.name for e in TWO.interactions if TWO.by_robot(e)] == ["left->a", "right->a"]
    assert TWO.chain("b") == ("right", "a", "b")
    one = graph("r a", "r->a")
    assert (one.roots, one.root) == (("r",), "r")
    assert one.acting("r") is one


def test_each_robot_sees_the_graph_as_its_own() -> None:
    seen = TWO.acting("left")
    assert seen.root == "left"
    assert seen.roots == TWO.roots
    assert seen.chains("b") == (("left", "a", "b"),)
    assert TWO.root == "right"
    assert TWO.acting("right") is TWO
    with pytest.raises(InputError, match="'a' is no robot of the graph; they are right, left"):
        TWO.acting("a")
    with pytest.raises(InputError, match="no interaction leads from left to right"):
        seen.chain("right")


def test_what_takes_one_robot_refuses_several() -> None:
    assert graph("r a", "r->a").only_root("this") == "r"
    with pytest.raises(InputError, match="finding edges takes one robot; the graph has right, left"):
        TWO.only_root("finding edges")


def test_commands_of_several_robots_are_joined_and_split_again() -> None:
    names = SPACE.observable.names
    assert TWO.command.names == tuple(f"{r}:{n}" for r in ("right", "left") for n in names)
    parts = {"left": np.zeros((2, len(names))), "right": np.ones((2, len(names)))}
    joined = TWO.join_command(parts)
    assert joined.shape == (2, 2 * len(names))
    assert (joined[:, : len(names)] == 1.0).all()
    split = TWO.split_command(joined)
    assert list(split) == ["right", "left"]
    for name, part in parts.items():
        np.testing.assert_array_equal(split[name], part)
    one = graph("r a", "r->a")
    assert one.command is one.objects["r"].observable
    np.testing.assert_array_equal(one.join_command(one.split_command(np.arange(3.0))), np.arange(3.0))


@pytest.mark.parametrize("robots", [("left",), ("left", "a"), ("left", "right", "left"), ("left", "right", "b")])
def test_robots_that_are_not_the_roots_are_refused(robots: tuple[str, ...]) -> None:
    with pytest.raises(InputError, match="but the objects without parents are left, right; declare each"):
        InteractionGraph(TWO.objects, TWO.interactions, robots=robots)


def test_what_no_robot_reaches_is_refused() -> None:
    with pytest.raises(InputError, match="no interaction leads from left or right to c, d"):
        InteractionGraph(
            {**TWO.objects, "c": SPACE, "d": SPACE}, [*TWO.interactions, "c->d", "d->c"], robots=("left", "right")
        )
