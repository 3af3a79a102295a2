"""The systems that come with the library, one folder each, and loading them by name."""

from __future__ import annotations

import difflib
from collections.abc import Sequence

from ichain_drake.errors import InputError
from ichain_drake.robot import Physics
from ichain_drake.scenarios.base import Scenario
from ichain_drake.systems.car_game.scenario import CarGame
from ichain_drake.systems.car_racing.scenario import CarRacing
from ichain_drake.systems.driving.scenario import Driving
from ichain_drake.systems.hover_game.scenario import HoverGame
from ichain_drake.systems.kettle.scenario import KettleScenario
from ichain_drake.systems.kinder.stick_button import STICK_BUTTONS
from ichain_drake.systems.lidded_pot.scenario import LiddedPot
from ichain_drake.systems.microwave.scenario import Microwave
from ichain_drake.systems.own import is_own, own_scenario
from ichain_drake.systems.ship.scenario import ShipVoyage
from ichain_drake.systems.two_dispensers.scenario import TwoDispensers
from ichain_drake.systems.water_dispenser.scenario import WaterDispenser

# A new system: one folder, its YAML under models/scenarios, and one line here.
SCENARIOS: dict[str, type[Scenario]] = {
    CarGame.name: CarGame,
    CarRacing.name: CarRacing,
    Driving.name: Driving,
    HoverGame.name: HoverGame,
    KettleScenario.name: KettleScenario,
    LiddedPot.name: LiddedPot,
    Microwave.name: Microwave,
    ShipVoyage.name: ShipVoyage,
    TwoDispensers.name: TwoDispensers,
    WaterDispenser.name: WaterDispenser,
}

OPTIONAL: dict[str, type[Scenario]] = {**STICK_BUTTONS}
"""Worlds of others: each needs an extra, and says so where it is opened. They are in no scoreboard."""


def load_scenario(
    name: str, overrides: str | Sequence[str] = (), physics: Physics = "contact", seed: int = 0
) -> Scenario:
    """A scenario by name.

    Args:
        name: see `ichain list`; or a scenario of the user's own, by file (`path/to/file.py`, `file.py:Class`) or module
            (`package.module:Class`), which is imported: this runs its code.
        overrides: settings such as `noise.scale=2`; one, or several in order.
        physics: `ideal`, `arm` or `contact`.
        seed: seed of the run.

    Raises:
        InputError: on an unknown name, with close ones, on a file or module without a scenario, or bad settings.
    """
    return scenario_class(name)(overrides, physics, seed)


def scenario_class(name: str) -> type[Scenario]:
    """The class of a scenario, by name; see `load_scenario`.

    Raises:
        InputError: on an unknown name, with close ones, or on a file or module without a scenario.
    """
    if is_own(name):
        return own_scenario(name)
    every = SCENARIOS | OPTIONAL
    if name not in every:
        close = difflib.get_close_matches(name, every, n=1)
        hint = f"did you mean {close[0]}?" if close else f"there are {', '.join(every)}"
        raise InputError(f"there is no scenario {name[:80]!r}; {hint}")
    return every[name]


__all__ = ["OPTIONAL", "SCENARIOS", "load_scenario", "scenario_class"]
