"""What a report warns of: an interaction that was rarely seen to switch, is told badly, or does nothing."""

from dataclasses import replace
from types import SimpleNamespace

import pytest
import small_job

from ichain_drake.graph import Interaction
from ichain_drake.learning.report import _passive_detail
from ichain_drake.learning.settings import LEARNING

EDGE = Interaction.parse("tap->box")


def warnings(score: float = 1.0, events: float = 1.0, *, effects: bool = True) -> str:
    model, _, _ = small_job.learned()
    learned = model.edges[EDGE]
    learned = replace(learned, status=replace(learned.status, score=score, event_score=events))
    learned = learned if effects else replace(learned, effects=())
    return " ".join(replace(model, edges={**model.edges, EDGE: learned}).report()["warnings"])


@pytest.mark.parametrize(
    ("score", "events", "told"),
    [(1.0, 1.0, True), (LEARNING.well - 0.01, 1.0, False), (1.0, LEARNING.events - 0.01, False), (0.0, 0.0, False)],
)
def test_a_status_that_is_told_badly_in_rows_or_at_switches_is_warned_of(
    score: float, events: float, told: bool
) -> None:
    said = warnings(score, events)
    assert (f"{EDGE.name}: when it is active is not predicted well" in said) != told
    if not told:
        assert f"(F1 {score:.2f}; {events:.2f} for the moments" in said


def test_an_interaction_without_effects_is_warned_of() -> None:
    assert f"{EDGE.name}: active without any visible effect on box" in warnings(effects=False)
    assert f"{EDGE.name}: active without" not in warnings()


def test_a_rest_value_is_told_and_of_what_drifts_by_what_it_does() -> None:
    space = SimpleNamespace(names=("x", "y"))
    rests, keeps = (SimpleNamespace(kind=k, value=0.5, drift=None, inputs=()) for k in ("constant", "hold"))
    drift = SimpleNamespace(estimator="line", explained=0.75)
    drifts = SimpleNamespace(kind="hold", value=0.0, drift=drift, inputs=(1,))
    assert _passive_detail(SimpleNamespace(space=space), rests) == {"value": 0.5}
    assert _passive_detail(SimpleNamespace(space=space), keeps) == {}
    assert _passive_detail(SimpleNamespace(space=space), drifts) == {
        "columns": ["y"], "estimator": "line", "score": 0.75,
    }  # fmt: skip
