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
