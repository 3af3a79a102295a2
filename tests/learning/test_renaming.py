"""What was learned of objects, under other names."""

from ichain_drake.graph import InteractionGraph
from ichain_drake.learning.renaming import _input
from ichain_drake.learning.status.inputs import DifferenceInput
from ichain_drake.state import StateSpace, Variable


def test_a_difference_is_named_by_the_variables_that_it_is_of() -> None:
    spaces = {n: StateSpace(n, (Variable("a"), Variable("b"), Variable("c"))) for n in ("hand", "box")}
    graph = InteractionGraph(spaces, ["hand->box"])
    old = DifferenceInput("arm", "crate", (0, 2), False, "crate.c - arm.a")
    found = _input(old, {"arm": "hand", "crate": "box"}, graph)
    assert isinstance(found, DifferenceInput)
    assert (found.parent, found.child, found.index, found.label) == ("hand", "box", (0, 2), "box.c - hand.a")
