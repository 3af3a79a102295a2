"""A saved graph as it was read from its folder, and the model that is built from it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.library.encoding import Decoder
from ichain_drake.learning.library.files import MANIFEST, graph_name, is_weights_name
from ichain_drake.learning.library.fit import check_graph
from ichain_drake.learning.library.form import Free, Keyed
from ichain_drake.learning.library.manifest import SHA256, SPACE, ManifestForm, space_from
from ichain_drake.learning.library.saved_item import SavedItem
from ichain_drake.learning.library.weights import unpack_arrays
from ichain_drake.learning.model import InteractionModel
from ichain_drake.learning.passive import PassiveDynamics, PassiveVariable
from ichain_drake.learning.status.events import Switching, SwitchingWindow
from ichain_drake.learning.tick import LearnedInteraction
from ichain_drake.state import FloatArray

WEIGHTS = "model.npz"

_FORM = {
    "format": int,
    "graph": str,
    "period": float,
    "time": str,
    "objects": Keyed(str, SPACE),
    "interactions": Keyed(
        str, {"samples": int, "f1": float, "event_f1": float, "calibration_error": float, "effects": Keyed(str, float)}
    ),
    "model": Free(),
    "robot_seconds": float,
    "versions": Keyed(str, str),
    "demonstrations_sha256": SHA256,
    "files": Keyed(is_weights_name, SHA256),
    "checksums": Keyed(str, SHA256),
}
GRAPH = ManifestForm(_FORM, 4, lambda content: [WEIGHTS])


@dataclass(frozen=True)
class Contents:
    """What the field `model` of a manifest stands for; attributes as those of `InteractionModel`."""

    edges: dict[Interaction, LearnedInteraction]
    passive: dict[str, tuple[PassiveVariable, ...]]
    low: dict[str, FloatArray]
    high: dict[str, FloatArray]
    step_limit: dict[str, FloatArray]
    order: tuple[Interaction, ...]
    noise: dict[str, FloatArray]
    pieces: tuple[str, ...]
    findings: tuple[str, ...]
    activations: dict[Interaction, tuple[SwitchingWindow, ...]]
    deactivations: dict[Interaction, tuple[SwitchingWindow, ...]]


@dataclass(frozen=True)
class SavedGraph(SavedItem):
    """A whole graph; see `SavedItem`."""

    what: ClassVar[str] = "graph"
    form: ClassVar[ManifestForm] = GRAPH

    @staticmethod
    def folder_name(manifest: Mapping[str, Any]) -> str:
        """`graph.<name>`."""
        return graph_name(manifest["graph"])

    def verify(self) -> None:
        """See `SavedItem`."""
        self.known(self.graph())

    def graph(self) -> InteractionGraph:
        """The graph as the manifest describes it.

        Raises:
            InputError: if it can't be one.
        """
        try:
            spaces = {name: space_from(fields) for name, fields in self.manifest["objects"].items()}
            edges = [Interaction.parse(text) for text in self.manifest["interactions"]]
            driven = {e.child for e in edges}
            robots = [name for name in spaces if name not in driven]
            return InteractionGraph(spaces, edges, robots=robots if len(robots) > 1 else ())
        except InputError as error:
            raise self._refusal("objects, interactions", str(error)) from None

    def known(self, graph: InteractionGraph) -> InteractionModel:
        """What was learned, for a graph that fits.

        Raises:
            InputError: if it doesn't fit, or the contents make no model; names the object, variable or field.
        """
        check_graph(self.manifest, self.graph(), graph, str(self.folder))
        where = str(self.folder / MANIFEST)
        decoder = Decoder(
            unpack_arrays(self.files[WEIGHTS], str(self.folder / WEIGHTS)), tuple(graph.interactions), where
        )
        found: Contents = decoder.decode(Contents, self.manifest["model"], "model")
        decoder.finish()
        self._check_complete(found, graph)
        model = InteractionModel(
            graph=graph,
            edges=found.edges,
            passive={n: PassiveDynamics(graph.objects[n].observable, v) for n, v in found.passive.items()},
            low=found.low,
            high=found.high,
            step_limit=found.step_limit,
            order=found.order,
            noise=found.noise,
            pieces=found.pieces,
            findings=found.findings,
            activations=found.activations,
            deactivations=found.deactivations,
            robot_seconds=float(self.manifest["robot_seconds"]),
            demonstrations_sha256=self.manifest["demonstrations_sha256"],
            source=str(self.folder.parent),
        )
        self._check_use(model)
        return model

    def _check_complete(self, found: Contents, graph: InteractionGraph) -> None:
        """Refuse contents that are not about all of the graph, or have arrays of another shape than its states."""
        every = set(graph.interactions)
        children = set(graph.objects).difference(graph.roots)
        sizes = {n: len(space.observable) for n, space in graph.objects.items()}
        mine = {e for e in every if graph.by_robot(e)}
        for name, keys, wanted in (
            ("edges", set(found.edges), every),
            ("order", set(found.order), every),
            ("passive", set(found.passive), children),
            ("activations", set(found.activations), mine),
            ("deactivations", set(found.deactivations), mine),
        ):
            if keys != wanted:
                raise self._refusal(f"model.{name}", "it is not about exactly what the graph has")
        for name, group in {n: getattr(found, n) for n in ("low", "high", "step_limit", "noise")}.items():
            self._check_shapes(f"model.{name}", group, {n: (size,) for n, size in sizes.items()})
        for obj, variables in found.passive.items():
            if len(variables) != sizes[obj]:
                raise self._refusal("model.passive", f"{len(variables)} variables for the {sizes[obj]} of {obj}")
        for edge, learned in found.edges.items():
            path, examples = f"model.edges, {edge.name}", learned.examples
            for part in ("activations", "deactivations"):
                events: Switching = getattr(examples, part)
                for side in (events.before, events.after):
                    self._check_shapes(f"{path}, {part}", side, {n: (len(events), k) for n, k in sizes.items()})
            for states in (examples.active, examples.inactive):
                rows = len(next(iter(states.values()), ()))
                self._check_shapes(path, states, {n: (rows, k) for n, k in sizes.items()})
            limits = {n: getattr(learned, n) for n in ("active_low", "active_high", "active_step")}
            self._check_shapes(path, limits, dict.fromkeys(limits, (sizes[edge.parent],)))
        for edge, window in (
            (e, w) for part in (found.activations, found.deactivations) for e, ws in part.items() for w in ws
        ):
            seen = {"root": window.root, "child": window.child}
            shapes = {"root": (len(window.root), sizes[edge.parent]), "child": (sizes[edge.child],)}
            self._check_shapes(f"model.activations, {edge.name}", seen, shapes)
            if not 0 <= window.event <= len(window.root) or not len(window.root):
                raise self._refusal(f"model.activations, {edge.name}", f"row {window.event} is not in its window")

    def _check_shapes(self, path: str, arrays: Mapping[str, FloatArray], wanted: Mapping[str, tuple[int, ...]]) -> None:
        for name in {**wanted, **arrays}:
            if name not in arrays or name not in wanted or arrays[name].shape != wanted[name]:
                raise self._refusal(path, f"{name}: an array of another shape or object than the graph's")

    def _check_use(self, model: InteractionModel) -> None:
        """Use every part once: what doesn't fit together must not be found out in the middle of a run."""
        states = {n: np.stack([model.low[n], 0.5 * (model.low[n] + model.high[n])]) for n in model.graph.objects}
        for edge in model.graph.interactions:
            try:
                shown = model.edges[edge].customary.fits(states)
                with np.errstate(all="ignore"):  # what overflows is refused below
                    value = model.decide(edge, states)
                    change = model.effect(edge, states, states[edge.parent])
                    ahead, _ = model.step(states, states[model.graph.root], {edge: True}, strict=False)
                    spread = model.spread(edge.child, [edge])
                good = all(np.isfinite(a).all() for a in (value, change, spread, *ahead.values()))
            except (ArithmeticError, LookupError, TypeError, ValueError) as error:  # InputError is one
                raise self._refusal(f"model.edges, {edge.name}", " ".join(str(error).split())[:200]) from None
            if not good:
                raise self._refusal(f"model.edges, {edge.name}", "it predicts no finite numbers within its own data")
            if not shown:
                raise self._refusal(f"model.edges, {edge.name}, customary", "low and high are no ranges of its inputs")
