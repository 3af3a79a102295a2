"""What was learned, on what evidence, and where the demonstrations don't pin it down."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.passive import PassiveDynamics
from ichain_drake.learning.settings import LEARNING
from ichain_drake.learning.tick import LearnedInteraction


class Reported(Protocol):
    """What is reported of a model; see `InteractionModel`."""

    @property
    def graph(self) -> InteractionGraph: ...  # noqa: D102

    @property
    def edges(self) -> Mapping[Interaction, LearnedInteraction]: ...  # noqa: D102

    @property
    def passive(self) -> Mapping[str, PassiveDynamics]: ...  # noqa: D102

    @property
    def pieces(self) -> Sequence[str]: ...  # noqa: D102

    @property
    def findings(self) -> Sequence[str]: ...  # noqa: D102


def report(model: Reported) -> dict[str, Any]:
    """Figures of every model as plain numbers and texts, ready for JSON.

    Returns:
        `pieces`, `passive` per object and variable, `interactions` per edge with `status`, `effects`, `events` and
        `warnings`, `findings` about the pieces, and these with all `warnings` in one list.
    """
    edges = {e.name: _edge(model, e, model.edges[e]) for e in model.graph.interactions}
    passive = {
        obj: {
            name: {"kind": v.kind, "std": float(v.std), "samples": v.samples, **_passive_detail(p, v)}
            for name, v in zip(p.space.names, p.variables, strict=True)
        }
        for obj, p in model.passive.items()
    }
    return {
        "pieces": list(model.pieces),
        "passive": passive,
        "interactions": edges,
        "findings": list(model.findings),
        "warnings": [*model.findings, *(w for e in edges.values() for w in e["warnings"])],
    }


def _passive_detail(dynamics: Any, variable: Any) -> dict[str, Any]:
    if variable.kind == "constant":
        return {"value": float(variable.value)}
    if variable.drift is not None:
        inputs = [dynamics.space.names[i] for i in variable.inputs]
        return {"columns": inputs, "estimator": variable.drift.estimator, "score": variable.drift.explained}
    return {}


def _edge(model: Reported, edge: Interaction, learned: LearnedInteraction) -> dict[str, Any]:
    names = model.graph.objects[edge.child].observable.names
    status = learned.status
    effects = {
        names[e.variable]: {
            "samples": e.regression.samples,
            "pieces": e.regression.pieces,
            "columns": [c.label for c in e.columns],
            "estimator": e.regression.estimator,
            "score": e.regression.explained,
            "std": e.regression.std,
            "drift_std": e.regression.drift,
            "dead_band": e.regression.dead_band,
        }
        for e in learned.effects
    }
    return {
        "status": {
            "samples": status.samples,
            "positives": status.positives,
            "columns": [i.label for i in status.inputs],
            "customary": list(learned.customary.labels),
            "estimator": status.estimator,
            "margin": status.margin,
            "f1": status.score,
            "event_f1": status.event_score,
            "likelihood": status.likelihood,
            "calibration_error": status.calibration_error,
            "spread": status.spread,
            "slip": status.slip,
        },
        "effects": effects,
        "events": {
            "activations": len(learned.examples.activations),
            "deactivations": len(learned.examples.deactivations),
        },
        "warnings": _warnings(model, edge, learned),
    }


def _warnings(model: Reported, edge: Interaction, learned: LearnedInteraction) -> list[str]:
    out = []
    status, examples = learned.status, learned.examples
    for what, events, remedy in (
        ("activated", examples.activations, f"a piece in which {edge.parent} starts to act on {edge.child}"),
        ("deactivated", examples.deactivations, f"a piece in which {edge.parent} stops to act on {edge.child}"),
    ):
        if len(events) < LEARNING.few:
            out.append(f"{edge.name}: {what} only {len(events)} times in all pieces; add {remedy}")
    if status.score < LEARNING.well or status.event_score < LEARNING.events:
        out.append(
            f"{edge.name}: when it is active is not predicted well on pieces that were left out (F1 "
            f"{status.score:.2f}; {status.event_score:.2f} for the moments at which it switches); add pieces in which "
            f"{edge.parent} starts and stops to act on {edge.child}, slowly if it can, and under other conditions"
        )
    if not learned.effects:
        out.append(
            f"{edge.name}: active without any visible effect on {edge.child}; add a piece in which {edge.parent} "
            f"clearly changes {edge.child} while active, or remove the edge"
        )
    names = model.graph.objects[edge.child].observable.names
    for effect in learned.effects:
        if effect.regression.pieces < LEARNING.few:
            out.append(
                f"{edge.name}: its effect on {edge.child}.{names[effect.variable]} shows in "
                f"{effect.regression.pieces} piece(s); add one from another start so that there are {LEARNING.few}"
            )
    return out
