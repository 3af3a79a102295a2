"""What a scenario gives about a cup or another vessel that a hand moves: geometry, what it meets, what goes wrong."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from ichain_drake.objects.camera import CameraFrame
from ichain_drake.objects.placement import Placement
from ichain_drake.objects.region import Region
from ichain_drake.state import BoolArray, FloatArray


@dataclass(frozen=True)
class Surface:
    """A level surface that a cup can stand on: a rectangle of the robot's frame.

    Attributes:
        x, y: from, to [m].
        height: [m].
        moved: how it is moved and turned from where these say; None for not at all.
    """

    x: tuple[float, float]
    y: tuple[float, float]
    height: float
    moved: Placement | None = None

    def reaches(self, x: FloatArray, y: FloatArray) -> BoolArray:
        """Whether it is above or below a place of the robot's frame [m], shape (...) each."""
        if self.moved is not None:
            x, y = self.moved.back(x, y)
        return (self.x[0] <= x) & (x <= self.x[1]) & (self.y[0] <= y) & (y <= self.y[1])


@dataclass(frozen=True)
class CupFaults:
    """Faults that an evaluation asks for.

    Attributes:
        slips: times [s]; a grasp is lost at each, or as soon after as the cup is held in the air. The hand must open
            and close anew.
        knocks: (time [s], dx, dy [m, robot frame]); the cup is displaced then, or as soon after as it stands.
        away: how far the hand must be from it for that, at least [m].
    """

    slips: tuple[float, ...] = ()
    knocks: tuple[tuple[float, float, float], ...] = ()
    away: float = 0.0


@dataclass(frozen=True)
class CupSettings:
    """What a scenario gives about a cup.

    Attributes:
        height, radius: of the mouth above the bottom, and of the body [m].
        mouth: from the middle of the bottom to below the mouth of an upright one, along x and y [m]; 0 for a cup, whose
            mouth is the middle of its rim.
        grasp: where the hand must be, relative to the mouth of an upright one, when it closes around it.
        outlets: by name of a parent that dispenses: where the mouth must be to catch the water, robot frame.
        inlets: by name of a parent that is moved and poured from: where its mouth must be relative to this one's, along
            the robot's axes, while this one is upright.
        holds_to: tilt at which a full one begins to pour [rad].
        emptying: how much more until nothing stays in [rad].
        surfaces: what it can stand on beside the table at height 0.
        camera: frame in which its pose is seen.
        faults: see `CupFaults`.
    """

    height: float = 0.10
    radius: float = 0.03
    mouth: tuple[float, float] = (0.0, 0.0)
    grasp: Region = field(default_factory=lambda: Region((0.0, 0.0, -0.04), (0.015, 0.015, 0.025)))
    outlets: Mapping[str, Region] = field(
        default_factory=lambda: {"tank": Region((0.68, 0.06, 0.11), (0.02, 0.02, 0.015))}
    )
    inlets: Mapping[str, Region] = field(default_factory=dict)
    holds_to: float = 0.3
    emptying: float = 1.5
    surfaces: tuple[Surface, ...] = ()
    camera: CameraFrame = field(default_factory=CameraFrame)
    faults: CupFaults = field(default_factory=CupFaults)
