"""Names under which `gymnasium.make` finds the systems."""

from __future__ import annotations

from ichain_drake.objects.gymnasium.extra import require_gymnasium

SYSTEMS = (
    "car_game",
    "car_racing",
    "driving",
    "hover_game",
    "kettle",
    "lidded_pot",
    "microwave",
    "ship",
    "two_dispensers",
    "water_dispenser",
)
"""Those of `ichain list`, written out so that registering them loads none."""

_VERSION = 0  # counts up when an environment's actions, observations or rewards change


def environment_id(system: str) -> str:
    """The id of a system's environment: `ichain/CarGame-v0` for `car_game`."""
    return f"ichain/{system.title().replace('_', '')}-v{_VERSION}"


def register() -> None:
    """Register every system with Gymnasium, once.

    Raises:
        InputError: if Gymnasium is not installed.
    """
    gymnasium = require_gymnasium()
    for system in SYSTEMS:
        if environment_id(system) not in gymnasium.registry:
            gymnasium.register(environment_id(system), "ichain_drake.environments:make_env", kwargs={"system": system})
