"""What a status may depend on, with the noise of its readings; what follows from a status is read a row earlier."""

import numpy as np
import pytest

from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.data import GraphData, Piece
from ichain_drake.learning.effects.alignment import Alignment, PositionGroup
from ichain_drake.learning.status.candidates import input_noise, states_around, status_candidates
from ichain_drake.learning.status.inputs import DifferenceInput, PlaceInput, RelativeInput, ValueInput
from ichain_drake.learning.status.relative import rested
from ichain_drake.state import Role, StateSpace, Variable

EDGE = Interaction("hand", "box")
PLACE = tuple(Variable(a, "m", role=Role("position", "room", a)) for a in "xy")
SPACES = {
    "hand": StateSpace("hand", PLACE),
    "box": StateSpace("box", (*PLACE, Variable("level"))),
    "lamp": StateSpace("lamp", (Variable("light"),)),
    "far": StateSpace("far", (Variable("x"),)),
}
NOISE = {"hand": np.array([0.3, 0.5]), "box": np.array([0.1, 0.3, 0.7]), "lamp": np.array([0.9]), "far": np.ones(1)}
FLAGS = ("01100", "1001")


def data() -> GraphData:
    """Two pieces, of five rows and of four, all of whose numbers differ."""
    graph = InteractionGraph(
        SPACES, [EDGE, Interaction("lamp", "box"), Interaction("hand", "lamp"), Interaction("hand", "far")]
    )
    pieces = []
    for at, (name, text) in enumerate(zip("ab", FLAGS, strict=True)):
        states = {
            n: (100.0 * at + np.arange(len(text) * len(s), dtype=float)).reshape(-1, len(s)) for n, s in SPACES.items()
        }
        on = np.array([c == "1" for c in text])
        pieces.append(Piece(name, states, {e: on if e == EDGE else ~on for e in graph.interactions}))
    return GraphData(
        graph, SPACES, tuple(pieces), graph.interactions, {n: tuple(range(len(s))) for n, s in SPACES.items()}
    )


def candidates(*affected: int, alignment: Alignment | None = None) -> dict[str, tuple[np.ndarray, bool, np.ndarray]]:
    made = data()
    alignments = {e: alignment if e == EDGE else None for e in made.edges}
    found = status_candidates(made, EDGE, alignments, NOISE, affected)
    return {c.item.label: (c.values, c.caused, c.noise) for c in found}


def test_all_that_acts_on_the_child_is_looked_at_and_nothing_else() -> None:
    found = candidates()
    assert list(found) == [
        "position of box relative to hand", "position of hand", "position of box", "box.level", "lamp.light",
    ]  # fmt: skip
    assert list(states_around(data(), EDGE)) == ["box", *data().graph.parents("box")]
    assert not any(caused for _, caused, _ in found.values())
    np.testing.assert_array_equal(found["lamp.light"][0], data().stacked("lamp"))
    np.testing.assert_array_equal(found["box.level"][0], data().stacked("box")[:, 2:])


def test_what_the_interaction_changes_is_read_a_row_before_it_became_active() -> None:
    """Not where it was active in the row before already, nor across the beginning of a piece."""
    level, place = data().stacked("box")[:, 2], data().stacked("box")[:, :2]
    rows = [0, 0, 2, 3, 3, 5, 6, 6, 7]
    found = candidates(2)
    np.testing.assert_array_equal(found["box.level"][0][:, 0], level[rows])
    assert [label for label, (_, caused, _) in found.items() if caused] == ["box.level"]
    found = candidates(1)
    np.testing.assert_array_equal(found["position of box"][0], place[rows])
    assert [label for label, (_, caused, _) in found.items() if caused] == ["position of box"]
    np.testing.assert_array_equal(found["position of hand"][0], data().stacked("hand"))


@pytest.mark.parametrize("rows", [0, 20])
def test_beside_what_it_does_not_go_along_with_the_noise_of_what_stands_is_averaged_out(rows: int) -> None:
    """With noise so large that all of it may be standing."""
    group = PositionGroup("room", ("x", "y"), (0, 1))
    two = Alignment(group, group, (), np.eye(2), np.zeros((2, 0)), np.zeros(2), rows, 0.0)
    made = data()
    alignments = {e: two if e == EDGE else None for e in made.edges}
    found = status_candidates(made, EDGE, alignments, {n: 1000.0 * v for n, v in NOISE.items()})
    values, states = found[0].values, {n: made.stacked(n) for n in ("hand", "box")}
    if not rows:
        states = {n: rested(v, made.piece_index(), 1000.0 * NOISE[n]) for n, v in states.items()}
        assert np.abs(states["box"] - made.stacked("box")).max() > 0.5
    np.testing.assert_array_equal(values, states["box"][:, :2] - states["hand"])


def test_noise_of_inputs_is_that_of_what_they_are_made_of() -> None:
    group = PositionGroup("room", ("x", "y"), (0, 1))
    two = Alignment(group, group, (), np.eye(2), np.zeros((2, 0)), np.zeros(2), 20, 0.0)
    np.testing.assert_allclose(input_noise(ValueInput("box", 2, ""), NOISE), [0.7])
    np.testing.assert_allclose(
        input_noise(DifferenceInput("hand", "box", (1, 2), False, ""), NOISE), [np.hypot(0.5, 0.7)]
    )
    np.testing.assert_allclose(input_noise(PlaceInput("box", group, np.eye(2), ""), NOISE), [0.2, 0.2])
    np.testing.assert_allclose(input_noise(RelativeInput(EDGE, two, ""), NOISE), [np.hypot(0.4, 0.2)] * 2)
