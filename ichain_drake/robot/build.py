"""One call for the robot of any physics."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from typing import Literal

from ichain_drake.errors import InputError, UnreachableError
from ichain_drake.robot.arm import ArmRobot
from ichain_drake.robot.displacing import Displacement
from ichain_drake.robot.hand import HAND
from ichain_drake.robot.ideal import IdealHand
from ichain_drake.robot.spec import BodySpec, RobotSpec
from ichain_drake.state import FloatArray

Physics = Literal["ideal", "arm", "contact", "environment"]
"""`environment`: a world that somebody else simulates, with a root of its own; see `EnvironmentScenario`."""

ROBOT_PHYSICS: tuple[Physics, ...] = ("ideal", "arm", "contact")
"""What a robot of this library can be built for."""


def build_robot(
    spec: RobotSpec,
    physics: Physics = "contact",
    bodies: Mapping[str, BodySpec] | None = None,
    seed: int = 0,
    object_id: int = 0,
    start: FloatArray | None = None,
    displacements: Mapping[str, tuple[Displacement, ...]] | None = None,
) -> IdealHand | ArmRobot:
    """Build the robot: the same ports and the same tick in every physics.

    Args:
        spec: the robot.
        physics: `ideal`: the hand is a point; `arm`: an arm carries it; `contact`: objects are bodies in the arm's
            plant.
        bodies: bodies of mechanical objects, by object name; used in `contact` only.
        seed: the run's seed.
        object_id: the robot object's number, which keys its noise.
        start: full hand state of the default context, shape (7,); the spec's home by default. In `contact` a closed
            hand holds what is between its fingers then.
        displacements: of free bodies, by object name, by somebody else; in `contact` only.

    Raises:
        InputError: on an unknown physics, or models, names or gains that don't fit.
        UnreachableError: if the arm can't reach the home hand state, or the start.
    """
    if physics not in ROBOT_PHYSICS:
        raise InputError(f"physics {physics!r}: choose {', '.join(ROBOT_PHYSICS)}")
    if physics == "ideal":
        _check_arm(spec)
        speeds = {"linear_speed": spec.linear_speed, "angular_speed": spec.angular_speed}
        home = spec.home_hand() if start is None else HAND.check(start, "hand state")
        return IdealHand(spec.hand, home, seed, object_id, **speeds)
    if physics == "arm":
        return ArmRobot(spec, {}, seed, object_id, start)
    return ArmRobot(spec, bodies or {}, seed, object_id, start, displacements)


_OF_A_POINT = ("hand", "home", "linear_speed", "angular_speed")


_arms_that_can_be: set[str] = set()
"""What they are made from: an evaluation makes thousands of worlds, and building an arm takes most of that time."""


def _check_arm(spec: RobotSpec) -> None:
    """Refuse an arm that can't be, where a point stands in for it: what is set wrongly is said in every physics."""
    told = repr(spec)
    if told in _arms_that_can_be:
        return
    if spec != replace(RobotSpec(), **{name: getattr(spec, name) for name in _OF_A_POINT}):
        with suppress(UnreachableError):  # a point can be where no arm can
            ArmRobot(spec, {})
    if " at 0x" not in told:  # something in it that does not say what it is
        _arms_that_can_be.add(told)
