"""Interaction graphs against examples worked out by hand; their drawings."""

import shutil
from pathlib import Path

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
        ("r a b", ["r->a"], "exactly one object without parents .* it has 2: r, b"),
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
