"""`relearn`: what the factoring is for: one link is learned anew, the others are kept (paper sec. IV, its end)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits

from ichain_drake.control.chain import make_controller
from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction
from ichain_drake.learning.chain import LearnedChain, LearnedLink, learn_chain
from ichain_drake.learning.command import LearnedCommand
from ichain_drake.learning.library import load_command, load_links
from ichain_drake.scenarios.base import PathScenario, Progress
from ichain_drake.scenarios.path_evaluation import FULL, VARIANTS, learn_variant
from ichain_drake.scenarios.path_run import choose_paths, follow, versions


def relearn_link(
    scenario: PathScenario, original: PathScenario, link: str, library: Path, progress: Progress | None = None
) -> dict[str, Any]:
    """Compare ways to adapt to a changed scenario: nothing learned anew, one link, everything, and a monolithic model.

    Args:
        scenario: the scenario as it is now.
        original: as it was when the library was learned; the stale monolithic model is learned in it.
        link: `parent->child`, the link to learn anew.
        library: folder of the links learned before.
        progress: called with a line at each step.

    Returns:
        For the report: one row per way, with error per path, new samples and simulated robot time.

    Raises:
        InputError: if the chain has no such link, or the library lacks one of the others.
    """
    say = progress or (lambda line: None)
    with threadpool_limits(limits=1):
        names = scenario.graph.chain(scenario.target)
        edges = [Interaction(a, b).name for a, b in zip(names[:-1], names[1:], strict=True)]
        if link not in edges:
            raise InputError(f"--link {link!r}: the chain's links are {', '.join(edges)}")
        known = load_links(library, scenario.graph, names, scenario.target_variables)
        for edge in edges:
            if edge not in known:
                raise InputError(f"{library}: it has no link for {edge}; learn it first with `ichain learn`")
        command = load_command(library, scenario.graph, names)
        pieces = list(scenario.record_demonstrations(say))
        kept = {e: v for e, v in known.items() if e != link}
        root_kept = command if edges[0] != link else None
        ways = {
            "before": _chain(scenario, pieces, known, command),
            "one link": _chain(scenario, pieces, kept, root_kept),
            "all links": _chain(scenario, pieces, {}, None),
        }
        rows = [_row(scenario, way, chain, edges, say) for way, chain in ways.items()]
        rows += _monolithic(scenario, original, say)
    return {
        "scenario": scenario.name,
        "physics": scenario.physics,
        "seed": scenario.seed,
        "link": link,
        "versions": versions(),
        "given": scenario.given(),
        "rows": rows,
    }


def _chain(
    scenario: PathScenario,
    pieces: Sequence[Demonstration],
    known: Mapping[str, LearnedLink],
    command: LearnedCommand | None,
) -> LearnedChain:
    return learn_chain(
        pieces,
        scenario.graph,
        scenario.target,
        scenario.target_variables,
        scenario.config.learning.candidates(),
        scenario.robot_seconds(),
        known=known,
        known_command=command,
    )


def _row(scenario: PathScenario, way: str, chain: LearnedChain, edges: Sequence[str], say: Progress) -> dict[str, Any]:
    say(f"following the paths, learned anew: {way}")
    control = scenario.config.control
    controller = make_controller(chain, control.method, scenario.path_limits(), control.candidates())
    fresh = [x for x in chain.links if x.source == "demonstrations"]
    return {
        "way": way,
        "relearned": [x.interaction.name for x in fresh],
        "new_samples": sum(x.forward.samples for x in fresh),
        "robot_seconds": sum(x.robot_seconds for x in fresh),
        "paths": _errors(scenario, chain, controller),
    }


def _errors(scenario: PathScenario, chain: LearnedChain, controller: Any) -> dict[str, float | None]:
    errors: dict[str, float | None] = {}
    for number, (name, path) in enumerate(choose_paths(scenario).items()):
        result = follow(scenario, chain, controller, name, path, number)
        errors[name] = result.error if result.completed else None
    return errors


def _monolithic(scenario: PathScenario, original: PathScenario, say: Progress) -> list[dict[str, Any]]:
    """A model from the robot straight to the target: as learned before the change, and learned anew."""
    variant = next(v for v in VARIANTS if v.monolithic and v.control == "predictive")
    rows = []
    for way, source in (("monolithic, stale", original), ("monolithic, all anew", scenario)):
        say(f"following the paths, {way}")
        chain, controller = learn_variant(scenario, variant, [source.monolithic_demonstration(2 * FULL)])
        new = source is scenario
        rows.append(
            {
                "way": way,
                "relearned": [chain.links[0].interaction.name] if new else [],
                "new_samples": variant.samples if new else 0,
                "robot_seconds": variant.samples / 3.0 if new else 0.0,
                "paths": _errors(scenario, chain, controller),
            }
        )
    return rows
