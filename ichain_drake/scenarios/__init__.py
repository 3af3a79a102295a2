"""What a system is made from: base classes, configuration, scripts, drawings, faults; nothing here knows a system."""

from ichain_drake.scenarios.base import PathScenario, Scenario
from ichain_drake.scenarios.build import build_world
from ichain_drake.scenarios.graph_scenario import GraphScenario

__all__ = ["GraphScenario", "PathScenario", "Scenario", "build_world"]
