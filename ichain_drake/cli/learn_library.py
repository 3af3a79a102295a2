"""The command `learn`."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from ichain_drake.cli.console import Reporter
from ichain_drake.cli.run import taught_by
from ichain_drake.learning import InteractionModel
from ichain_drake.runs.goals.settings import graph_spec
from ichain_drake.runs.goals.unlabelled import Taught
from ichain_drake.runs.learn import learn
from ichain_drake.runs.library import save
from ichain_drake.runs.paths.output import prepare_folder
from ichain_drake.runs.pieces import check_settings, read_for
from ichain_drake.scenarios import Scenario


def learn_library(
    scenario: Scenario, demos: Path, library: Path, *, resampled: bool = False, taught: Taught | None = None
) -> None:
    """`ichain learn`: learn all of a scenario's graph from demonstrations and save it.

    Raises:
        InputError: on bad demonstrations, or a library that can't be written.
    """
    check_settings(scenario)
    taught = taught_by(scenario, taught or Taught())
    graph = taught.graph(scenario.graph)
    with Reporter() as say:
        unlabelled = taught.unlabelled
        pieces = read_for(scenario, demos, graph=graph, resampled=resampled, unlabelled=unlabelled, say=say.note)
        prepare_folder(library)
        if unlabelled:
            labels = taught.labelled(pieces, graph, say.note)
            pieces, graph = list(labels.pieces), labels.graph
        say(f"learning from {len(pieces)} pieces")
        same = graph is scenario.graph
        model = (
            learn(scenario, pieces, progress=say) if same else learn(graph, pieces, spec=graph_spec(scenario.config))
        )
    save(model, library, scenario.name)
    for line in _learned(model):
        print(line)


def _learned(model: InteractionModel) -> Iterator[str]:
    """A line on each interaction."""
    for link in () if model.chain is None else model.chain.links:
        forward = link.forward
        yield f"{link.interaction.name}: {forward.samples} samples, score {forward.score:.4f}, {forward.spec}"
    for edge, learned in model.edges.items():
        names = model.graph.objects[edge.child].observable.names
        changed = ", ".join(names[e.variable] for e in learned.effects) or "nothing seen"
        status = learned.status
        line = f"{edge.name}: {status.samples} samples, F1 {status.score:.4f}, {status.estimator}; changes {changed}"
        customary = f"; customary: {', '.join(learned.customary.labels)}" if learned.customary.labels else ""
        yield line + customary
