"""Which inputs a gate must not use."""

from types import SimpleNamespace
from typing import Any

import pytest

from ichain_drake.learning.discovery.inputs import caused
from ichain_drake.state import Role, StateSpace, Variable


@pytest.mark.parametrize(
    ("changed", "barred"), [([0], [True, True, False]), ([1], [True, True, False]), ([2], [False, False, True])]
)
def test_an_amount_and_what_is_dissolved_in_it_change_together(changed: list[int], barred: list[bool]) -> None:
    """An effect on either of them is seen in both, so that neither can tell when it acts."""
    water, heat = Variable("water", role=Role("amount")), Variable("heat", role=Role("intensive", of="water"))
    space = StateSpace("cup", (water, heat, Variable("c")))
    items = [SimpleNamespace(relative=False, place=False, owner="cup", variables=(i,)) for i in range(3)]
    inputs: Any = SimpleNamespace(items=items)
    assert caused(inputs, space, "cup", "hand", changed).tolist() == barred
    assert not caused(inputs, space, "cup", "cup", changed).any(), "what it does alone may depend on itself"
