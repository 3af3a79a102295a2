"""Learning from more rows than it looks at."""

from dataclasses import replace

import numpy as np
import pytest
import small_world

from ichain_drake.learning import InteractionModel, learn_interactions
from ichain_drake.learning import enough as module
from ichain_drake.learning.enough import enough, thinning_told
from ichain_drake.learning.settings import LEARNING


def test_what_is_left_out_is_said_and_enough_is_learned(
    demonstrations: list, model: InteractionModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    rows = sum(map(len, demonstrations))
    monkeypatch.setattr(module, "LEARNING", replace(LEARNING, most_learned=rows))
    assert thinning_told(demonstrations, enough(demonstrations, small_world.GRAPH)) == []
    whole = learn_interactions(demonstrations, small_world.GRAPH)
    assert whole.demonstrations_sha256 == model.demonstrations_sha256
    more = [*demonstrations, *(replace(p, name=f"{p.name} again") for p in small_world.pieces(1))]
    thin = learn_interactions(more, small_world.GRAPH)
    assert thin.findings[0].startswith(f"{sum(len(p) for p in enough(more, small_world.GRAPH))} of ")
    assert "rows are learned from" in thin.findings[0]
    assert thin.robot_seconds > 1.5 * whole.robot_seconds  # of all that was recorded
    assert set(thin.edges) == set(whole.edges)
    for edge, learned in thin.edges.items():
        assert learned.status.samples <= rows
        assert {e.variable for e in learned.effects} == {e.variable for e in whole.edges[edge].effects}
    assert np.mean([k.status.score for k in thin.edges.values()]) > LEARNING.well
