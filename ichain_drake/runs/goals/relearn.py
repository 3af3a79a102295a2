"""`relearn` for a goal: one interaction of a graph is learned anew, the others are kept (paper sec. IV, its end)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ichain_drake.errors import IchainError, InputError
from ichain_drake.graph import Interaction
from ichain_drake.learning import KnownParts
from ichain_drake.learning.library import load_parts
from ichain_drake.runs.goals.run import GraphRun, run_graph
from ichain_drake.runs.provenance import given_of, versions
from ichain_drake.scenarios.base import Progress
from ichain_drake.scenarios.goal_scenario import GoalScenario
from ichain_drake.timing import TICK

ORIGINAL = "original"
NOTHING = "changed, nothing relearned"
ONE_LINK = "one link"
ALL_LINKS = "all links"

Row = dict[str, Any]


def relearn_interaction(
    scenario: GoalScenario,
    original: GoalScenario,
    goal: Sequence[str],
    link: str,
    library: Path,
    progress: Progress | None = None,
) -> dict[str, Any]:
    """Compare ways to adapt to a changed scenario: nothing learned anew, one interaction, everything.

    Args:
        scenario: the scenario as it is now.
        original: as it was when the library was learned.
        goal: what both are asked for.
        link: `parent->child`, the interaction to learn anew.
        library: folder of graphs learned before; see `load_parts` for what of them fits.
        progress: called with a line at each step.

    Returns:
        For the report: `rows`, one per way, with whether the goal was reached, control steps, new plans, rows of new
        demonstrations and the robot's time for them [s], and the reason of a failure.

    Raises:
        InputError: if the graph has no such interaction, or the library lacks one of the others.
    """
    say = progress or (lambda line: None)
    edge = Interaction.parse(link)
    edges = scenario.graph.interactions
    if edge not in edges:
        raise InputError(f"--link {link!r}: the graph's interactions are {', '.join(e.name for e in edges)}")
    parts = load_parts(library, scenario.name, scenario.graph)
    for other, why in parts.reasons.items():
        if other != edge:
            raise InputError(f"{library}: it has nothing that fits {other.name} ({why}); learn it with `ichain learn`")
    lacking = parts.reasons.get(edge, "")
    rows = [
        _run(ORIGINAL, original, goal, parts, say) if not lacking else _not_applied(ORIGINAL, lacking),
        _run(NOTHING, scenario, goal, parts, say) if not lacking else _not_applied(NOTHING, lacking),
        _run(ONE_LINK, scenario, goal, parts.without({edge: "asked for"}), say),
        _run(ALL_LINKS, scenario, goal, KnownParts(), say),
    ]
    return {
        "scenario": scenario.name,
        "physics": scenario.physics,
        "seed": scenario.seed,
        "link": link,
        "goal": list(goal),
        "versions": versions(),
        "given": given_of(scenario),
        "rows": [row | {"seed": scenario.seed} for row in rows],
    }


def _not_applied(way: str, why: str) -> Row:
    return {
        "way": way,
        "applied": False,
        "success": False,
        "control_steps": 0,
        "replans": 0,
        "new_samples": 0,
        "robot_seconds": 0.0,
        "relearned": [],
        "reason": why,
    }


def _run(way: str, scenario: GoalScenario, goal: Sequence[str], parts: KnownParts, say: Progress) -> Row:
    say(f"{way}: {scenario.name}")
    run = GraphRun(scenario, tuple(goal))
    row = _not_applied(way, "") | {"applied": True}
    try:
        run_graph(run, known=parts, progress=say)
    except IchainError as error:
        return row | {"reason": str(error)}
    assert run.model is not None
    assert run.memory is not None
    learned = [e.name for e in scenario.graph.interactions if e not in run.model.known.edges]
    return row | {
        "success": run.goal_reached,
        "control_steps": run.memory.tick,
        "replans": run.memory.replans,
        "new_samples": sum(len(p) for p in run.pieces),
        "robot_seconds": sum((len(p) - 1) * TICK for p in run.pieces),
        "relearned": learned,
        "reason": "" if run.goal_reached else run.reason,
    }


def summarise_relearned(rows: Sequence[Mapping[str, Any]]) -> list[Row]:
    """One line per way over several seeds: runs, how many reached the goal, and means over the runs.

    Args:
        rows: of one or more calls of `relearn_interaction`.
    """
    lines = []
    for way in dict.fromkeys(row["way"] for row in rows):
        group = [row for row in rows if row["way"] == way]
        done = [row for row in group if row["success"]]
        lines.append(
            {
                "way": way,
                "applied": any(row["applied"] for row in group),
                "runs": len(group),
                "reached": len(done),
                "control_steps": float(np.median([row["control_steps"] for row in done])) if done else None,
                "replans": float(np.mean([row["replans"] for row in group])),
                "new_samples": round(float(np.mean([row["new_samples"] for row in group]))),
                "robot_seconds": float(np.mean([row["robot_seconds"] for row in group])),
                "reason": next((row["reason"] for row in group if row["reason"]), ""),
            }
        )
    return lines
