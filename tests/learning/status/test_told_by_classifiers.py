"""A region that is no box: what boxes leave open, the classifiers that are tried decide."""

from types import SimpleNamespace

import numpy as np
import pytest

from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning import InteractionSpec
from ichain_drake.learning.chain.link import EstimatorSpec
from ichain_drake.learning.data import GraphData, Piece
from ichain_drake.learning.noise import measurement_std
from ichain_drake.learning.status import status
from ichain_drake.learning.status.candidates import status_candidates
from ichain_drake.learning.status.status import input_choice, learn_status
from ichain_drake.state import StateSpace, Variable

REACH, NOISE = 0.08, 0.004
EDGE = Interaction("hand", "ball")
SPACES = {
    "hand": StateSpace("hand", (Variable("x", "m"), Variable("y", "m"), Variable("grip", kind="binary"))),
    "ball": StateSpace("ball", (Variable("x", "m"), Variable("y", "m"))),
}
GRAPH = InteractionGraph(SPACES, ["hand->ball"])


def grasps(number: int, rng: np.random.Generator) -> Piece:
    """A hand that closes here and there around a ball, and holds it where it is no farther off than REACH."""
    aims = np.repeat(rng.uniform(-0.09, 0.09, (8, 2)), 9, axis=0)
    grip = np.tile([0, 0, 0, 1, 1, 1, 1, 0, 0], 8)
    flag = (grip > 0) & (np.hypot(*aims.T) < REACH)
    hand = np.column_stack([aims + NOISE * rng.normal(size=aims.shape), grip])
    ball = NOISE * rng.normal(size=aims.shape)
    return Piece(f"piece_{number}", {"hand": hand, "ball": ball}, {EDGE: flag})


def test_an_input_that_a_box_can_not_tell_is_told_by_the_classifiers() -> None:
    rng = np.random.default_rng(4)
    variables = {n: tuple(range(len(s))) for n, s in SPACES.items()}
    data = GraphData(GRAPH, SPACES, tuple(grasps(k, rng) for k in range(8)), (EDGE,), variables)
    noise = {n: measurement_std(data, n) for n in SPACES}
    choice, candidates = input_choice(data, EDGE), status_candidates(data, EDGE, {EDGE: None}, noise)
    by_boxes = choice.choose(candidates)
    assert {c.item.label for c in by_boxes} == {"hand.grip", "hand.y"}
    assert [c.item.label for c in choice.open(by_boxes, candidates)] == ["hand.x"]
    spec = InteractionSpec(status_estimators=(EstimatorSpec.parse("SVC(C=30.0, gamma=1.0, class_weight='balanced')"),))
    model = learn_status(data, EDGE, {EDGE: None}, spec, noise)
    assert {i.label for i in model.inputs} == {"hand.grip", "hand.x", "hand.y"}
    assert model.score > 0.9


def test_of_many_inputs_one_that_seems_to_tell_a_little_is_chance(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two pieces are a little likelier with it: more than one standard error, less than the best of ten by chance."""
    piece = np.repeat(np.arange(4), 5)
    many = [SimpleNamespace(caused=False, item=k) for k in range(10)]
    likelihood = {1: np.zeros(20), 2: 0.9 * (np.arange(20) == 3) + 0.8 * (np.arange(20) == 8)}
    monkeypatch.setattr(
        status._Trial,
        "of",
        lambda data, edge, chosen, spec: status._Trial(chosen, *[None] * 6, likelihood[len(chosen)]),  # type: ignore[arg-type]
    )
    data = SimpleNamespace(piece_index=lambda: piece)
    choice = SimpleNamespace(open=lambda chosen, free: free[:1])
    first = status._Trial.of(data, EDGE, many[:1], None)  # type: ignore[arg-type]
    for gain, more in ((1.0, False), (4.0, True)):
        likelihood[2] *= gain
        told = status._told_by_classifiers(first, choice, many, data, EDGE, None)  # type: ignore[arg-type]
        assert (told is not first) is more


def test_what_another_input_makes_idle_is_left_out_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """The new input tells all, so that the old one adds nothing to it."""
    piece = np.repeat(np.arange(4), 5)
    old, new = (SimpleNamespace(caused=False, item=k) for k in range(2))
    monkeypatch.setattr(
        status._Trial,
        "of",
        lambda data, edge, chosen, spec: status._Trial(chosen, *[None] * 6, np.full(20, float(new in chosen))),  # type: ignore[arg-type]
    )
    data = SimpleNamespace(piece_index=lambda: piece)
    choice = SimpleNamespace(open=lambda chosen, free: free)
    first = status._Trial.of(data, EDGE, [old], None)  # type: ignore[arg-type]
    told = status._told_by_classifiers(first, choice, [old, new], data, EDGE, None)  # type: ignore[arg-type]
    assert list(told.chosen) == [new]


@pytest.mark.parametrize(("after", "taken"), [(-0.1, "place"), (2.0, "heat")])
def test_what_the_interaction_itself_changes_is_for_what_all_others_leave_to_be_told(
    after: float, taken: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    piece = np.repeat(np.arange(4), 5)
    switch, heat, place = (SimpleNamespace(caused=k == 1, item=k) for k in range(3))
    told = {"switch": 0.0, "heat": 1.0 + after, "place": 1.0}

    def of(data: object, edge: object, chosen: list[SimpleNamespace], spec: object) -> status._Trial:
        name = "heat" if heat in chosen else "place" if place in chosen else "switch"
        return status._Trial(chosen, *[None] * 6, np.full(20, told[name]))  # type: ignore[arg-type]

    monkeypatch.setattr(status._Trial, "of", of)
    data = SimpleNamespace(piece_index=lambda: piece)
    choice = SimpleNamespace(open=lambda chosen, free: [c for c in free if c is place])
    first = of(data, EDGE, [switch, heat], None)
    found = status._told_by_classifiers(first, choice, [switch, heat, place], data, EDGE, None)  # type: ignore[arg-type]
    assert ({"heat": heat, "place": place}[taken]) in found.chosen
    assert (heat in found.chosen) is (taken == "heat")
