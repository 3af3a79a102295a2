"""Which experiment comes next."""

from typing import Any

import pytest

from ichain_drake.graph import Interaction
from ichain_drake.learning.discovery.edges import DiscoveredGraph
from ichain_drake.learning.discovery.experiments import Experiment, Question, bits, choose, questions
from ichain_drake.learning.discovery.search import FoundEdge
from ichain_drake.learning.discovery.structure import Rival

OBJECTS, REACHED = ("knob", "bulb", "pan"), ("knob", "bulb")
KNOB, BULB, BOTH = Experiment(("knob",)), Experiment(("bulb",)), Experiment(("knob", "bulb"))


def edge(name: str, confidence: float, **rivals: float) -> FoundEdge:
    """One that was found."""
    others = tuple(Rival(n, p) for n, p in rivals.items())
    return FoundEdge(Interaction.parse(name), 100.0, confidence, 20, (), others, {}, {}, gates=False)


def graph(*edges: FoundEdge) -> DiscoveredGraph:
    """With so many interactions."""
    spaces: dict[str, Any] = dict.fromkeys(("hand", *OBJECTS))
    return DiscoveredGraph(spaces, "hand", edges, (), ())


def asked(found: DiscoveredGraph | None, reached: tuple[str, ...] = REACHED) -> dict[str, Question]:
    """Questions by their text."""
    return {q.text: q for q in questions(found, OBJECTS, reached)}


def test_at_first_everything_is_asked_and_anything_may_tell() -> None:
    first = asked(None)
    assert list(first) == [f"what acts on {n}?" for n in OBJECTS]
    assert all(q.bits == 1.0 and q.answers == (KNOB, BULB, BOTH) for q in first.values())


def test_a_robot_that_can_touch_nothing_moves_freely() -> None:
    assert all(q.answers == (Experiment(),) for q in asked(None, ()).values())
    assert str(Experiment()) == "move freely"
    assert str(BOTH) == "touch knob, then bulb"


def test_of_two_rivals_each_is_moved_while_the_other_stays() -> None:
    q = asked(graph(edge("hand->knob", 1.0), edge("bulb->pan", 0.6, knob=0.4)))
    assert q["is it bulb or knob that acts on pan?"].answers == (BOTH,)
    assert q["is it bulb or knob that acts on pan?"].bits == pytest.approx(bits(0.4))


def test_the_robot_itself_is_told_apart_by_leaving() -> None:
    q = asked(graph(edge("hand->knob", 1.0), edge("knob->pan", 0.6, hand=0.4)))
    assert q["is it knob or hand that acts on pan?"].answers == (KNOB, BOTH)


def test_what_it_can_not_touch_it_moves_through_what_acts_on_it() -> None:
    found = graph(edge("hand->knob", 1.0), edge("knob->bulb", 1.0), edge("bulb->pan", 0.6))
    assert asked(found, ("knob",))["does bulb act on pan?"].answers == (KNOB,)


def test_the_experiment_that_answers_most_comes_next_and_loses_by_being_tried() -> None:
    open_questions = [Question("a", 1.0, (KNOB, BOTH)), Question("b", 0.5, (BOTH,)), Question("c", 0.9, (BULB,))]
    assert choose(open_questions, []) == (BOTH, "a")
    assert choose(open_questions, [BOTH]) == (KNOB, "a")  # 1 against .75 and .9
    assert choose(open_questions, [BOTH, KNOB]) == (BULB, "c")


def test_a_coin_is_worth_one_bit() -> None:
    assert bits(0.5) == pytest.approx(1.0)
    assert bits(1.0) == pytest.approx(0.0, abs=1e-6)
    assert bits(0.9) == pytest.approx(bits(0.1))
