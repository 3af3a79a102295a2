"""`relearn`: what the factoring is for: one link is learned anew, the others are kept (paper sec. IV, its end)."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from ichain_drake.control.tracking.chain import ChainController, make_controller
from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.errors import IchainError, InputError
from ichain_drake.graph import Interaction
from ichain_drake.learning import KnownParts
from ichain_drake.learning.chain.chain import LearnedChain
from ichain_drake.runs.learn import learn
from ichain_drake.runs.library import load
from ichain_drake.runs.paths.choice import choose_paths
from ichain_drake.runs.paths.evaluation import VARIANTS, learn_variant
from ichain_drake.runs.paths.following import follow
from ichain_drake.runs.provenance import given_of, versions
from ichain_drake.scenarios.base import PathScenario, Progress
from ichain_drake.timing import TICK

ORIGINAL = "original"
NOTHING = "changed, nothing relearned"
ONE_LINK = "one link"
ALL_LINKS = "all links"
STALE = "monolithic, stale"
ANEW = "monolithic, all anew"
WAYS = (ORIGINAL, NOTHING, ONE_LINK, ALL_LINKS, STALE, ANEW)
"""Rows of the table: as it was; then the changed scenario with what was learned before, and with more and more of it
learned anew; and one model from robot to target, learned before the change and after."""

Row = dict[str, Any]


def relearn_link(
    scenario: PathScenario,
    original: PathScenario,
    link: str,
    library: Path,
    progress: Progress | None = None,
    ways: Collection[str] = WAYS,
) -> dict[str, Any]:
    """Compare ways to adapt to a changed scenario: nothing learned anew, one link, everything, and a monolithic model.

    The link that is learned anew need not be in the library: what the chain ends at may be new. What was learned before
    can't be applied then, and says so.

    Args:
        scenario: the scenario as it is now.
        original: as it was when the library was learned; the stale monolithic model is learned in it.
        link: `parent->child`, the link to learn anew.
        library: folder of the links learned before.
        progress: called with a line at each step.
        ways: only these; the others have no row.

    Returns:
        For the report: `unit` of errors; `rows`, one per way (see `WAYS`), with error per path (None where its end was
        not reached), their mean ratio to the original's, new samples, simulated robot time, whether it could be applied
        at all, and the reason of a failure.

    Raises:
        InputError: if the chain has no such link, or the library lacks one of the others.
    """
    say = progress or (lambda line: None)
    with threadpool_limits(limits=1):
        edges = chain_edges(scenario, link)
        saved = _known(library, scenario)
        for edge in edges:
            if edge not in saved.links and edge != link:
                raise InputError(f"{library}: it has no link for {edge}; learn it first with `ichain learn`")
        gone = _factored(scenario, original, link, library, saved, say)
        gone |= _monolithic(scenario, original, saved, link, say)
        rows = [gone[way]() for way in WAYS if way in ways]
    before: dict[str, float | None] = next((row["paths"] for row in rows if row["way"] == ORIGINAL), {})
    for row in rows:
        row["ratio"] = _ratio(row["paths"], before)
        row["seed"] = scenario.seed
    return {
        "scenario": scenario.name,
        "physics": scenario.physics,
        "seed": scenario.seed,
        "link": link,
        "versions": versions(),
        "given": given_of(scenario),
        "unit": scenario.unit,
        "rows": rows,
    }


def chain_edges(scenario: PathScenario, link: str) -> list[str]:
    """Names of the chain's interactions, robot first.

    Raises:
        InputError: if `link` is none of them.
    """
    names = scenario.graph.chain(scenario.target)
    edges = [Interaction(a, b).name for a, b in zip(names[:-1], names[1:], strict=True)]
    if link not in edges:
        raise InputError(f"--link {link!r}: the chain's links are {', '.join(edges)}")
    return edges


def _factored(
    scenario: PathScenario, original: PathScenario, link: str, library: Path, saved: KnownParts, say: Progress
) -> dict[str, Callable[[], Row]]:
    """The chain with what the library has, and with less of it."""
    edges = chain_edges(scenario, link)
    lacking = "" if link in saved.links else f"the library has no link for {link}"
    pieces = cache(lambda: list(scenario.record_demonstrations(say)))
    one = saved.without({Interaction.parse(link): "asked for"})

    def before() -> tuple[LearnedChain, ChainController]:
        seen = list(original.record_demonstrations(say, set(edges)))  # for validation
        return _learn(original, seen, _known(library, original))

    return {
        ORIGINAL: lambda: _failed(original, ORIGINAL, lacking) if lacking else _row(original, ORIGINAL, before, say),
        NOTHING: lambda: (
            _failed(scenario, NOTHING, lacking)
            if lacking
            else _row(scenario, NOTHING, lambda: _learn(scenario, pieces(), saved), say)
        ),
        ONE_LINK: lambda: _row(scenario, ONE_LINK, lambda: _learn(scenario, pieces(), one), say),
        ALL_LINKS: lambda: _row(scenario, ALL_LINKS, lambda: _learn(scenario, pieces(), KnownParts()), say),
    }


def _known(library: Path, scenario: PathScenario) -> KnownParts:
    known = load(library, scenario)
    assert isinstance(known, KnownParts)  # a chain's links
    return known


def _learn(
    scenario: PathScenario, pieces: Sequence[Demonstration], saved: KnownParts
) -> tuple[LearnedChain, ChainController]:
    chain = learn(scenario, pieces, known=saved).for_paths()
    control = scenario.config.control
    return chain, make_controller(chain, control.method, scenario.path_limits(), control.candidates())


def _monolithic(
    scenario: PathScenario, original: PathScenario, saved: KnownParts, link: str, say: Progress
) -> dict[str, Callable[[], Row]]:
    """A model from the robot straight to the target, from as many samples as all links together: before and after."""
    config = scenario.config
    variant = next(v for v in VARIANTS if v.monolithic and v.control == config.control.method)
    variant = replace(variant, samples=len(chain_edges(scenario, link)) * config.learning.samples)

    def learn(source: PathScenario) -> tuple[LearnedChain, ChainController]:
        return learn_variant(scenario, variant, [source.monolithic_demonstration(variant.samples)])

    def anew() -> Row:
        row = _row(scenario, ANEW, lambda: learn(scenario), say)
        return row | {"robot_seconds": row["new_samples"] * TICK}

    new = link == chain_edges(scenario, link)[-1] and link not in saved.links
    reason = f"what it was learned to move is not there: {scenario.target} is new"
    return {
        STALE: lambda: (
            _failed(scenario, STALE, reason) if new else _row(scenario, STALE, lambda: learn(original), say, new=False)
        ),
        ANEW: anew,
    }


def _row(
    scenario: PathScenario,
    way: str,
    learn: Callable[[], tuple[LearnedChain, ChainController]],
    say: Progress,
    *,
    new: bool = True,
) -> Row:
    """Learn and follow every path.

    Args:
        scenario: in which paths are followed.
        way: of `WAYS`.
        learn: gives what follows.
        say: called with a line.
        new: whether samples that it learns from count as new.
    """
    say(f"following the paths: {way}")
    try:
        chain, controller = learn()
        results = {
            name: follow(scenario, chain, controller, name, path, number)
            for number, (name, path) in enumerate(choose_paths(scenario).items())
        }
    except IchainError as error:
        return _failed(scenario, way, str(error))
    lost = [name for name, result in results.items() if not result.completed]
    fresh = [x for x in chain.links if x.source == "demonstrations"] if new else []
    return {
        "way": way,
        "applied": True,
        "relearned": [x.interaction.name for x in fresh],
        "new_samples": sum(x.forward.samples for x in fresh),
        "robot_seconds": sum(x.robot_seconds for x in fresh),
        "paths": {name: result.error if result.completed else None for name, result in results.items()},
        "reason": f"the end was not reached on: {', '.join(lost)}" if lost else "",
    }


def _failed(scenario: PathScenario, way: str, reason: str) -> Row:
    """The row of a way that could not be gone at all."""
    return {
        "way": way,
        "applied": False,
        "relearned": [],
        "new_samples": 0,
        "robot_seconds": 0.0,
        "paths": dict.fromkeys(scenario.reference_paths()),
        "reason": reason,
    }


def _ratio(paths: Mapping[str, float | None], reference: Mapping[str, float | None]) -> float | None:
    """Mean over the paths of the error over the reference's; None where one of either was lost."""
    if set(paths) != set(reference):
        return None
    pairs = [(paths[name], reference[name]) for name in paths]
    ratios = [a / b for a, b in pairs if a is not None and b is not None]
    return float(np.mean(ratios)) if ratios and len(ratios) == len(pairs) else None


def summarise_ways(rows: Sequence[Row]) -> list[Row]:
    """One line per way over several seeds.

    Args:
        rows: of `relearn_link`, of one seed or several.

    Returns:
        `way`, `seeds`, `applied` (in any), `new_samples`, `robot_seconds`, `reason`; for `ratio` and each of `paths` a
        mapping of `mean`, `std` (over the seeds that have one) and `lost` (how many have not).
    """
    table = []
    for way in dict.fromkeys(row["way"] for row in rows):
        group = [row for row in rows if row["way"] == way]
        table.append(
            {
                "way": way,
                "seeds": len(group),
                "applied": any(row["applied"] for row in group),
                "paths": {name: _spread([row["paths"][name] for row in group]) for name in group[0]["paths"]},
                "ratio": _spread([row["ratio"] for row in group]),
                "new_samples": group[0]["new_samples"],
                "robot_seconds": group[0]["robot_seconds"],
                "reason": next((row["reason"] for row in group if row["reason"]), ""),
            }
        )
    return table


def _spread(values: Sequence[float | None]) -> dict[str, Any]:
    found = [v for v in values if v is not None]
    return {
        "mean": float(np.mean(found)) if found else None,
        "std": float(np.std(found)) if found else None,
        "lost": len(values) - len(found),
    }
