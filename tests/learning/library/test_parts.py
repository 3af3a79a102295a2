"""Which objects here stand for those of a saved graph."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.library import parts
from ichain_drake.state import StateSpace, Variable

SPACES = {n: StateSpace(n, (Variable(n[0]),)) for n in ("hand", "box", "lamp")}
THERE = InteractionGraph(SPACES, ["hand->box", "hand->lamp"])
EDGE = Interaction("hand", "box")


@pytest.mark.parametrize("looks", [False, True])
def test_an_object_without_a_counterpart_is_missed_only_where_the_status_looks_at_it(
    looks: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    here = InteractionGraph({n: SPACES[n] for n in ("hand", "box")}, ["hand->box"])
    monkeypatch.setattr(parts, "_same_space", lambda theirs, old, graph, new: old == new)
    monkeypatch.setattr(parts, "seen_by", lambda learned: {"hand", "lamp"} if looks else {"hand"})
    model: Any = SimpleNamespace(graph=THERE, edges={EDGE: None})
    if looks:
        with pytest.raises(InputError, match="its status also looks at lamp, which doesn't act on box here"):
            parts._names(EDGE, EDGE, model, here, Path("graph.job"))
    else:
        assert parts._names(EDGE, EDGE, model, here, Path("graph.job")) == {"hand": "hand", "box": "box"}


def graph(types: dict[str, str], *edges: str) -> InteractionGraph:
    """Objects of these types; all of a type have the same variable."""
    return InteractionGraph({n: StateSpace(t, (Variable(t[0]),)) for n, t in types.items()}, list(edges))


OLD = graph({"arm": "hand", "mug": "cup", "pot": "pan"}, "arm->mug", "arm->pot")
FOLDER = Path("graph.kitchen")


def counterpart(here: InteractionGraph, name: str, old: InteractionGraph = OLD, *, lift: bool = False) -> str | None:
    found = parts._counterpart(Interaction.parse(name), here, old, FOLDER, lift=lift)
    return None if found is None else found.name


def test_an_interaction_is_known_by_its_name_or_by_its_types_where_these_leave_no_choice() -> None:
    assert counterpart(OLD, "arm->mug") == "arm->mug"
    other = graph({"hand": "hand", "cup": "cup", "lid": "lid"}, "hand->cup", "hand->lid")
    assert counterpart(other, "hand->cup") == "arm->mug"
    assert counterpart(other, "hand->lid") is None, "nothing between such types is known"
    two_here = graph({"hand": "hand", "a": "cup", "b": "cup"}, "hand->a", "hand->b")
    with pytest.raises(
        InputError, match=r"graph.kitchen: arm->mug may be any of hand->a, hand->b, which have the same"
    ):
        counterpart(two_here, "hand->b")
    assert counterpart(two_here, "hand->b", lift=True) == "arm->mug"
    two_there = graph({"arm": "hand", "mug": "cup", "jar": "cup"}, "arm->mug", "arm->jar")
    with pytest.raises(InputError, match="arm->mug, arm->jar may be any of hand->cup"):
        counterpart(other, "hand->cup", two_there)
    assert counterpart(other, "hand->cup", two_there, lift=True) == "arm->mug", "the first of them"
    changed = graph({"arm": "hand", "mug": "jug"}, "arm->mug")
    with pytest.raises(InputError, match="graph.kitchen: mug: type: it is cup, here it is jug"):
        counterpart(changed, "arm->mug")


def names(
    here: InteractionGraph, edge: str, match: str, looks: set[str], monkeypatch: pytest.MonkeyPatch
) -> dict[str, str]:
    monkeypatch.setattr(parts, "seen_by", lambda learned: looks)
    there = graph(
        {"arm": "hand", "mug": "cup", "pot": "pan", "fan": "fan"}, "arm->mug", "arm->fan", "fan->mug", "arm->pot"
    )
    model: Any = SimpleNamespace(graph=there, edges={Interaction.parse(match): None})
    return parts._names(Interaction.parse(edge), Interaction.parse(match), model, here, FOLDER)


def test_what_else_a_status_looks_at_must_act_on_the_child_here_too(monkeypatch: pytest.MonkeyPatch) -> None:
    near = graph({"hand": "hand", "cup": "cup", "vent": "fan"}, "hand->cup", "hand->vent", "vent->cup")
    found = names(near, "hand->cup", "arm->mug", {"arm", "mug", "fan"}, monkeypatch)
    assert found == {"arm": "hand", "mug": "cup", "fan": "vent"}
    far = graph({"hand": "hand", "cup": "cup", "vent": "fan"}, "hand->cup", "hand->vent")
    with pytest.raises(InputError, match="arm->mug: its status also looks at fan, which doesn't act on cup here"):
        names(far, "hand->cup", "arm->mug", {"arm", "mug", "fan"}, monkeypatch)
    assert names(far, "hand->cup", "arm->mug", {"arm", "mug"}, monkeypatch)["fan"] == "vent"
    two = graph({"hand": "hand", "cup": "cup", "a": "fan", "b": "fan"}, "hand->cup", "hand->a", "hand->b")
    assert "fan" not in names(two, "hand->cup", "arm->mug", {"arm"}, monkeypatch), "of two none is guessed"
    same = graph({"hand": "hand", "cup": "cup", "fan": "fan", "b": "fan"}, "hand->cup", "hand->fan", "hand->b")
    assert names(same, "hand->cup", "arm->mug", {"arm"}, monkeypatch)["fan"] == "fan", "but of the same name"
    elsewhere = graph({"hand": "hand", "cup": "cup", "fan": "pan", "b": "fan"}, "hand->cup", "hand->fan", "hand->b")
    found = names(elsewhere, "hand->cup", "arm->mug", {"arm"}, monkeypatch)
    assert "fan" not in found, "what has its name here is another thing"
    assert found["pot"] == "fan"


def test_a_demonstrated_event_goes_with_its_interaction() -> None:
    saved: Any = {EDGE: ("window",)}
    other = Interaction("arm", "mug")
    assert parts._windows(saved, EDGE, other) == {other: ("window",)}
    assert parts._windows(saved, other, EDGE) == {}
