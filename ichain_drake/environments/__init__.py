"""Scenarios as Gymnasium environments, so that what others built can be tried on them (extra `games`).

Importing this package registers every system that comes with the library, if Gymnasium is installed.
"""

from __future__ import annotations

from collections.abc import Sequence
from importlib.util import find_spec
from typing import TYPE_CHECKING

from ichain_drake.environments.registration import SYSTEMS, environment_id, register
from ichain_drake.objects.gymnasium.extra import require_gymnasium

if TYPE_CHECKING:
    from ichain_drake.environments.environment import SystemEnvironment
    from ichain_drake.robot import Physics
    from ichain_drake.scenarios.base import Scenario

if find_spec("gymnasium") is not None:
    register()


def make_env(
    system: str | Scenario,
    physics: Physics = "ideal",
    *,
    settings: str | Sequence[str] = (),
    path: str = "",
    goal: str | Sequence[str] = (),
    lookahead: int = 1,
) -> SystemEnvironment:
    """A scenario as a Gymnasium environment; see `SystemEnvironment` for actions, observations and rewards.

    Args:
        system: its name as in `ichain list`, a file or module of your own (see `load_scenario`), or a scenario, whose
            physics is its own.
        physics: `ideal`, `arm` or `contact`; ideal steps fastest.
        settings: such as `noise.scale=2`; one, or several in order.
        path: name of the reference path to follow; default: the first.
        goal: expressions in place of the scenario's goal.
        lookahead: of a path, the ticks of wanted positions in an observation.

    Raises:
        InputError: if Gymnasium is not installed, or a name, setting, path or goal is bad.
    """
    require_gymnasium()
    from ichain_drake.environments.environment import SystemEnvironment  # noqa: PLC0415 - an extra
    from ichain_drake.systems import load_scenario  # noqa: PLC0415 - registering must not load Drake

    scenario = load_scenario(system, settings, physics) if isinstance(system, str) else system
    return SystemEnvironment(scenario, path=path, goal=goal, lookahead=lookahead)


__all__ = ["SYSTEMS", "environment_id", "make_env", "register"]
