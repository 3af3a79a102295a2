"""Everything that can be done with a learned graph: what a search chooses from."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

from ichain_drake.control.planning.borders import Border, find_borders
from ichain_drake.control.planning.carries import CarryOption, find_carries
from ichain_drake.control.planning.drive_option import DriveOption
from ichain_drake.control.planning.enabling import Enabling, find_enabling
from ichain_drake.control.planning.keeping import KeepOption, find_keeps
from ichain_drake.control.planning.motion_drives import find_motion_drives
from ichain_drake.control.planning.options import find_drives
from ichain_drake.control.planning.plan import Goal
from ichain_drake.graph import Interaction
from ichain_drake.learning.model import InteractionModel
from ichain_drake.state import FloatArray


@dataclass(frozen=True, eq=False)
class Repertoire:
    """What can be done.

    Attributes:
        carries: objects that the robot can bring somewhere.
        drives: variables that can be driven through chains.
        borders: values at which a drive may stop.
        enabling: by the interaction that an object is carried by, where it makes which interaction possible.
        names: of each object's variables.
        keeps: what the robot can keep hold of while another one acts.
    """

    carries: tuple[CarryOption, ...]
    drives: tuple[DriveOption, ...]
    borders: tuple[Border, ...]
    enabling: Mapping[Interaction, tuple[Enabling, ...]]
    names: Mapping[str, tuple[str, ...]]
    keeps: tuple[KeepOption, ...] = ()

    @property
    def holds(self) -> frozenset[Interaction]:
        """Interactions by which the robot holds something."""
        return frozenset((*(c.edge for c in self.carries), *(k.edge for k in self.keeps)))

    def about(self, objects: Collection[str], goal: Goal) -> Repertoire:
        """What concerns some objects only; turning an object on and on only where the goal is about that.

        Args:
            objects: names.
            goal: what is wanted.
        """
        wanted = {(c.object, c.variable) for c in goal.conditions}
        return replace(
            self,
            carries=tuple(c for c in self.carries if c.edge.child in objects),
            drives=tuple(d for d in self.drives if self._is_among(d, objects) and self._serves(d, wanted)),
            borders=tuple(b for b in self.borders if b.object in objects),
            keeps=tuple(k for k in self.keeps if k.edge.child in objects),
        )

    def having_stood(self, stood: Mapping[str, Sequence[FloatArray]]) -> Repertoire:
        """With places where objects were seen to stand.

        Args:
            stood: measured states then, shape (n_variables,) each, by object.
        """
        carries = (replace(c, stood=tuple(s[c.follow] for s in stood.get(c.edge.child, ()))) for c in self.carries)
        return replace(self, carries=tuple(carries))

    def _is_among(self, drive: DriveOption, objects: Collection[str]) -> bool:
        """Whether what is driven, and what is carried for it, are some of the objects."""
        carried = drive.carry is None or drive.carry.edge.child in objects
        return carried and drive.chain[-1].child in objects

    def _serves(self, drive: DriveOption, wanted: Collection[tuple[str, str]]) -> bool:
        name = self.names[drive.chain[-1].child][drive.variable]
        return drive.motion is None or len(drive.chain) > 1 or (drive.chain[-1].child, name) in wanted

    def movable(self, wanted: Collection[str]) -> tuple[CarryOption, ...]:
        """What may be carried: not what drives something else by its motion, unless its own place is wanted."""
        moving = {d.chain[0] for d in self.drives if d.motion is not None and len(d.chain) > 1}
        return tuple(c for c in self.carries if c.edge not in moving or c.edge.child in wanted)


def find_repertoire(model: InteractionModel) -> Repertoire:
    """All that can be done, from the learned models and demonstrated samples alone."""
    carries = find_carries(model)
    still = find_drives(model, carries)
    drives = (*still, *find_motion_drives(model, carries, still))
    enabling = {c.edge: find_enabling(model, c) for c in carries}
    names = {n: s.observable.names for n, s in model.graph.objects.items()}
    return Repertoire(carries, drives, find_borders(model, carries), enabling, names, find_keeps(model))
