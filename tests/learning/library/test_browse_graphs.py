"""What a list of learned graphs says of each."""

from types import SimpleNamespace

import pytest

from ichain_drake.learning.library import browse_graphs


def test_an_interaction_is_told_with_the_score_of_each_effect_or_that_it_has_none(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(browse_graphs, "common", lambda saved, name: {})
    monkeypatch.setattr(browse_graphs, "GraphSummary", SimpleNamespace)
    scores = {"f1": 0.5, "event_f1": 1.0, "calibration_error": 0.25, "samples": 7}
    edges = {"a->b": {**scores, "effects": {"x": 0.9, "y": 0.75}}, "b->c": {**scores, "f1": 1.0, "effects": {}}}
    manifest = {"graph": "g", "objects": {}, "interactions": edges}
    found = browse_graphs._summary(SimpleNamespace(manifest=manifest))  # type: ignore[arg-type]
    start = "events 1.0000, calibration 0.2500"
    assert found.interactions == {
        "a->b": f"f1 0.5000, {start}; x 0.9000, y 0.7500",
        "b->c": f"f1 1.0000, {start}; no effects",
    }
    assert (found.score, found.samples) == (0.75, 7)
