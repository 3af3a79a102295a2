"""Edges out of states: distractors, rivals, priors; the graph's file; spaces guessed from columns."""

from pathlib import Path

import bath_log
import numpy as np
import pytest
import yaml

from ichain_drake.demonstrations import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction
from ichain_drake.learning.discovery.edges import DiscoveredGraph, Prior, discover_graph
from ichain_drake.learning.discovery.graph_file import read_edges, read_spaces, write_graph
from ichain_drake.learning.discovery.guess import guess_spaces
from ichain_drake.learning.discovery.log import RawPiece
from ichain_drake.state import StateSpace, Variable

SPACES = {**bath_log.GRAPH.objects, "fly": bath_log.FLY, "rock": bath_log.ROCK}
LAMP = StateSpace("lamp", (Variable("lit", kind="binary", lower=0, upper=1),))


def raw(pieces: list[Demonstration], spaces: dict[str, StateSpace] = SPACES) -> list[RawPiece]:
    return [RawPiece(p.name, {n: p.states(n, s) for n, s in spaces.items()}) for p in pieces]


@pytest.fixture(scope="module")
def pieces() -> list[Demonstration]:
    return bath_log.pieces(objects=tuple(SPACES))


@pytest.fixture(scope="module")
def found(pieces: list[Demonstration]) -> DiscoveredGraph:
    return discover_graph(raw(pieces), SPACES, "hand")


def test_the_graph_is_found_and_no_distractor_acts(found: DiscoveredGraph) -> None:
    assert {f.edge.name for f in found.found} == {"hand->lever", "lever->tank"}
    assert found.free == ("fly",)
    assert found.still == ("rock",)
    assert set(found.graph().objects) == {"hand", "lever", "tank"}
    assert all(0.5 < f.confidence <= 1 and f.ticks > 10 for f in found.found)


def test_what_stands_still_does_so_with_noisy_readings_too(pieces: list[Demonstration]) -> None:
    rng = np.random.default_rng(0)
    noisy = [RawPiece(p.name, {**p.states, "rock": p.states["rock"] + 1e-3 * rng.standard_normal((len(p), 2))})
             for p in raw(pieces)]  # fmt: skip
    assert discover_graph(noisy, SPACES, "hand").still == ("rock",)
    shoved = [RawPiece(p.name, {**p.states, "rock": p.states["rock"] + (k > 2) * 0.05}) for k, p in enumerate(noisy)]
    assert discover_graph(shoved, SPACES, "hand").still == ()  # who is elsewhere in other pieces may matter
    switch = {**SPACES, "lamp": LAMP}
    lit = [RawPiece(p.name, {**p.states, "lamp": (np.arange(len(p)) == 9).astype(float)[:, None]}) for p in noisy]
    assert discover_graph(lit, switch, "hand").still == ("rock",)


def test_what_the_data_cannot_tell_apart_is_a_rival() -> None:
    """A lamp that is lit while the heater is on: of the two one is taken, and the other is named."""
    rng = np.random.default_rng(0)
    switch = StateSpace("switch", (Variable("on", kind="binary", lower=0, upper=1),))
    spaces = {"hand": switch, "heater": switch, "lamp": LAMP, "pot": StateSpace("pot", (Variable("heat"),))}
    logs = []
    for k in range(4):
        on = (np.arange(80) // 8 % 2 == k % 2).astype(float)[:, None]
        heat = np.cumsum(0.1 * on, axis=0) + 0.01 * rng.standard_normal((80, 1))
        other = (rng.random((80, 1)) > 0.5).astype(float)  # the hand does other things
        logs.append(RawPiece(str(k), {"hand": other, "heater": on, "lamp": on, "pot": heat}))
    both = frozenset({Interaction("lamp", "heater"), Interaction("heater", "lamp")})
    (edge,) = [f for f in discover_graph(logs, spaces, "hand", Prior(both)).found if f.edge.child == "pot"]
    assert {edge.edge.parent, *(r.parent for r in edge.rivals)} >= {"heater", "lamp"}
    assert edge.confidence < 0.6
    result = discover_graph(logs, spaces, "hand", Prior(both, no_cause=frozenset({"lamp"})))
    (edge,) = [f for f in result.found if f.edge.child == "pot"]
    assert edge.edge.parent == "heater"
    assert "lamp" not in {r.parent for r in edge.rivals}


def test_what_is_ruled_out_is_not_found(pieces: list[Demonstration]) -> None:
    prior = Prior(forbidden=frozenset({Interaction("lever", "tank"), Interaction("hand", "tank")}))
    result = discover_graph(raw(pieces, bath_log.GRAPH.objects), bath_log.GRAPH.objects, "hand", prior)
    assert [f.edge.name for f in result.found] == ["hand->lever"]
    assert result.free == ("tank",)


@pytest.mark.parametrize(
    ("prior", "message"),
    [
        (Prior(no_cause=frozenset({"spoon"})), "there is no object 'spoon'"),
        (Prior(frozenset({Interaction("hand", "fly")}), frozenset({Interaction("hand", "fly")})), "ruled out"),
        (Prior(required=frozenset({Interaction("fly", "hand")})), "nothing acts on the robot"),
        (Prior(required=frozenset({Interaction("hand", "rock")})), "never changes"),
    ],
)
def test_a_prior_that_cannot_be_is_refused(prior: Prior, message: str, pieces: list[Demonstration]) -> None:
    with pytest.raises(InputError, match=message):
        discover_graph(raw(pieces), SPACES, "hand", prior)


def test_copied_columns_are_named(pieces: list[Demonstration]) -> None:
    spaces = {"hand": bath_log.HAND, "copy": bath_log.HAND}
    logs = [RawPiece(p.name, {"hand": p.states["hand"], "copy": p.states["hand"]}) for p in raw(pieces)]
    assert "copy.x repeats hand.x to the last digit" in discover_graph(logs, spaces, "hand").notes[0]


def test_a_graph_goes_through_its_file(found: DiscoveredGraph, tmp_path: Path) -> None:
    file = tmp_path / "graph.yaml"
    write_graph(found, file, ("hand.x: guessed",))
    written = yaml.safe_load(file.read_text())
    assert written["edges"]["hand->lever"]["confidence"] > 0.9
    assert written["never_changes"] == ["rock"]
    assert read_edges(file, bath_log.GRAPH).interactions == tuple(f.edge for f in found.found)
    spaces, robot = read_spaces(file)
    assert robot == "hand"
    assert {n: s.variables for n, s in spaces.items()} == {n: s.variables for n, s in SPACES.items()}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("robot: hand", "is no graph: it needs a list `edges`"),
        ("edges: [hand->spoon]", "there is no object 'spoon'"),
        ("edges: [a", "can't be read as YAML"),
    ],
)
def test_a_file_that_is_no_graph_is_refused(text: str, message: str, tmp_path: Path) -> None:
    file = tmp_path / "graph.yaml"
    file.write_text(text)
    with pytest.raises(InputError, match=message):
        read_edges(file, bath_log.GRAPH)


def test_spaces_are_guessed_from_columns(pieces: list[Demonstration]) -> None:
    units = {"hand.x": "m", "hand.y": "m", "lever.x": "m", "lever.y": "m", "tank.level": "l"}
    logs = [Demonstration(p.table.assign(**{"command.x": 0.0}), units, p.name) for p in pieces]
    guess = guess_spaces(logs, "hand")
    kinds = {f"{o}.{v.name}": (v.kind, v.role and v.role.kind) for o, s in guess.spaces.items() for v in s.variables}
    assert kinds["hand.x"] == ("real", "position")
    assert kinds["hand.grip"] == ("binary", None)
    assert kinds["tank.level"] == ("real", "amount")
    assert "fly.x: no unit given" in " ".join(guess.notes)
    with pytest.raises(InputError, match="name it with --robot"):
        guess_spaces([Demonstration(p.table, units, p.name) for p in pieces])


def test_names_do_not_matter(pieces: list[Demonstration], found: DiscoveredGraph) -> None:
    names = {"hand": "q", "lever": "b", "tank": "z", "fly": "a", "rock": "k"}
    spaces = {names[n]: SPACES[n] for n in ("rock", "tank", "fly", "hand", "lever")}
    logs = [RawPiece(p.name, {names[n]: s for n, s in p.states.items()}) for p in reversed(raw(pieces))]
    gain = {f"{names[f.edge.parent]}->{names[f.edge.child]}": f.gain for f in found.found}
    renamed = {f.edge.name: f.gain for f in discover_graph(logs, spaces, "q").found}
    assert renamed.keys() == gain.keys() == {"q->b", "b->z"}
    assert np.allclose([renamed[e] for e in gain], list(gain.values()))
