"""A saved link as it was read from its folder, and the models that are built from it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction, Origin
from ichain_drake.learning.chain.chain import LearnedLink
from ichain_drake.learning.chain.command import LearnedCommand
from ichain_drake.learning.chain.link import EstimatorSpec, ForwardSpec, InverseSpec, Scored
from ichain_drake.learning.chain.models import ForwardModel, InverseModel
from ichain_drake.learning.features import planar_poses
from ichain_drake.learning.frozen import FrozenModel
from ichain_drake.learning.library.files import link_name
from ichain_drake.learning.library.fit import check_fit
from ichain_drake.learning.library.manifest import LINK, ManifestForm, space_from
from ichain_drake.learning.library.saved_item import SavedItem
from ichain_drake.learning.library.weights import unpack
from ichain_drake.state import FloatArray, StateSpace


@dataclass(frozen=True)
class SavedLink(SavedItem):
    """A link; see `SavedItem`."""

    what: ClassVar[str] = "link"
    form: ClassVar[ManifestForm] = LINK

    @staticmethod
    def folder_name(manifest: Mapping[str, Any]) -> str:
        """`<parent type>-<child type>`."""
        return link_name(manifest["parent"]["type"], manifest["child"]["type"])

    def verify(self) -> None:
        """See `SavedItem`."""
        self.described()

    def described(self) -> tuple[LearnedLink, LearnedCommand | None]:
        """Its models for objects as the manifest describes them, and where they were then.

        Raises:
            InputError: as `link`.
        """
        parent, child = self._spaces()
        self.check_fit(parent, child, self.manifest["targets"])
        origin = self._origin(parent)
        return self.link(Interaction("parent", "child"), parent, child, origin), self.command(parent, origin)

    def check_fit(self, parent: StateSpace, child: StateSpace, targets: Sequence[str]) -> None:
        """Refuse a link that is not for these state spaces and targets; see `ichain_drake.learning.library.fit`.

        Raises:
            InputError: names the variable or field that differs.
        """
        check_fit(self.manifest, self._spaces(), (parent, child), targets, str(self.folder))

    def _spaces(self) -> tuple[StateSpace, StateSpace]:
        try:
            parent, child = (space_from(self.manifest[end]) for end in ("parent", "child"))
            targets = child.indices(self.manifest["targets"])
        except InputError as error:
            raise self._refusal("parent, child", str(error)) from None
        if len(set(targets.tolist())) != len(targets) or not len(targets):
            raise self._refusal("targets", "each needs to be named once")
        return parent, child

    def check_origin(self, edge: Interaction, origin: Origin | None) -> None:
        """Refuse a link of relative positions for a child without a declared origin, and the other way round.

        Args:
            edge: the interaction here; named in errors.
            origin: what the parent's positions are relative to here, if anything.

        Raises:
            InputError: if it doesn't fit; names the field.
        """
        saved = self._origin(self._spaces()[0])
        here, then = (None if o is None else o.frame for o in (origin, saved))
        if here != then:
            was, now = ("none is declared" if f is None else f"it is in frame {f!r}" for f in (then, here))
            raise InputError(
                f"{self.folder}: origin: {edge.parent}'s positions are relative to {edge.child}'s declared origin: "
                f"in the library {was}, here {now}; learn this link anew"
            )

    def _origin(self, parent: StateSpace) -> Origin | None:
        """Where the child was."""
        fields = self.manifest["origin"]
        if fields is None:
            return None
        try:
            origin = Origin(fields["frame"], tuple(fields["position"]))
        except InputError as error:
            raise self._refusal("origin", str(error)) from None
        if origin.offset(parent) is None:
            raise self._refusal("origin.frame", f"{parent.type} has no position in frame {origin.frame!r}")
        return origin

    def _shift(self, parent: StateSpace, origin: Origin | None) -> FloatArray:
        """How far the child was moved since; exactly zero where it was not, shape (n_parent,)."""
        before, now = (None if o is None else o.offset(parent) for o in (self._origin(parent), origin))
        return np.zeros(len(parent)) if before is None or now is None else now - before

    def link(self, edge: Interaction, parent: StateSpace, child: StateSpace, origin: Origin | None) -> LearnedLink:
        """The learned link between two objects whose state spaces fit.

        Args:
            edge: the interaction.
            parent, child: state spaces, observable variables only.
            origin: what the parent's positions are relative to here; see `check_origin`.

        Raises:
            InputError: if weights or limits don't belong to such a link; names the file or field.
        """
        saved, n_child, n_parent = self.manifest, len(child), len(parent)
        shift = self._shift(parent, origin)
        targets = tuple(int(i) for i in child.indices(saved["targets"]))
        if not saved["inverses"]:
            raise self._refusal("inverses", "there is none")
        return LearnedLink(
            edge,
            self._forward(parent, child, origin),
            tuple(self._inverse(i, parent, child, targets, origin) for i in range(len(saved["inverses"]))),
            self._vector("child_limit", saved, n_child),
            self._vector("child_scale", saved, n_child),
            self._vector("parent_lower", saved, n_parent) + shift,
            self._vector("parent_upper", saved, n_parent) + shift,
            self._vector("parent_scale", saved, n_parent),
            float(saved["robot_seconds"]),
            str(self.folder.parent),
        )

    def _forward(
        self, parent: StateSpace, child: StateSpace, origin: Origin | None
    ) -> Scored[ForwardModel, ForwardSpec]:
        fields = self.manifest["forward"]
        spec = ForwardSpec(self._estimator("forward", fields, child), fields["features"], fields["action"])
        model = ForwardModel(child, parent, spec.features, spec.action, self._model(fields), origin)
        state, action = np.zeros(len(child)), np.zeros(len(parent))
        self._check_sizes(fields, model.frozen, len(model.inputs(state, action, action)), len(child))
        std = self._vector("residual_std", fields, len(child), "forward.")
        return Scored(model, spec, float(fields["score"]), std, fields["samples"])

    def _inverse(
        self, number: int, parent: StateSpace, child: StateSpace, targets: tuple[int, ...], origin: Origin | None
    ) -> Scored[InverseModel, InverseSpec]:
        fields, path = self.manifest["inverses"][number], f"inverses[{number}]"
        spec = InverseSpec(self._estimator(path, fields, child), fields["features"], fields["aim"], fields["action"])
        if spec.aim < 1:
            raise self._refusal(f"{path}.aim", f"{spec.aim} ticks ahead is not ahead")
        lower, upper, std = (
            self._vector(name, fields, len(parent), f"{path}.")
            for name in ("parent_lower", "parent_upper", "residual_std")
        )
        shift, frozen = self._shift(parent, origin), self._model(fields)
        model = InverseModel(
            child, parent, targets, spec.features, spec.aim, frozen, lower + shift, upper + shift, origin
        )
        state = np.zeros(len(child))
        self._check_sizes(fields, model.frozen, len(model.inputs(state, state[list(targets)])), len(parent))
        return Scored(model, spec, float(fields["score"]), std, fields["samples"])

    def command(self, parent: StateSpace, origin: Origin | None) -> LearnedCommand | None:
        """What was learned about commanding the hand; None where the link has nothing of it.

        Args:
            parent: the hand's state space.
            origin: as `link`.

        Raises:
            InputError: as `link`.
        """
        fields = self.manifest["command"]
        if fields is None:
            return None
        n, frozen = len(parent), None
        if fields["map"] is not None:
            frozen = self._model(fields["map"])
            self._check_sizes(fields["map"], frozen, n, n)
        lower, upper, limit = (self._vector(name, fields, n, "command.") for name in ("lower", "upper", "hand_limit"))
        shift = self._shift(parent, origin)
        return LearnedCommand(frozen, lower + shift, upper + shift, limit, origin)

    def _vector(self, name: str, fields: Mapping[str, Any], n: int, path: str = "") -> FloatArray:
        values = np.array(fields[name], dtype=float)
        if len(values) != n:
            raise self._refusal(f"{path}{name}", f"{len(values)} numbers for {n} variables")
        return values

    def _estimator(self, path: str, fields: Mapping[str, Any], child: StateSpace) -> EstimatorSpec:
        if fields["features"] == "body" and not planar_poses(child):
            raise self._refusal(f"{path}.features", f"{child.type} has no position x, y with an orientation about z")
        try:
            return EstimatorSpec.parse(fields["estimator"])
        except InputError as error:
            raise self._refusal(f"{path}.estimator", f"{error!s:.200}") from None

    def _model(self, fields: Mapping[str, Any]) -> FrozenModel:
        return unpack(self.files[fields["file"]], fields["kind"], str(self.folder / fields["file"]))

    def _check_sizes(self, fields: Mapping[str, Any], model: FrozenModel, n_in: int, n_out: int) -> None:
        if (model.n_in, model.n_out) != (n_in, n_out):
            raise InputError(
                f"{self.folder / fields['file']}: its model has {model.n_in} inputs and {model.n_out} outputs, "
                f"the manifest's has {n_in} and {n_out}; save the link anew"
            )
