"""Control one object through another: chains and graphs of learned object interactions, for Drake.

The names below are the public interface, in the order in which data flows through them. Each is imported at its first
use, so that `import ichain_drake` is instant and loads neither plants nor estimators.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ichain_drake.control.tracking.chain import ChainController, ControlCandidates, make_controller
    from ichain_drake.control.tracking.move_to import MoveTo
    from ichain_drake.control.tracking.path import PathLimits, TimedPath, paper_path_error, path_error, read_path
    from ichain_drake.control.tracking.systems import Controller, PathFollower
    from ichain_drake.demonstrations import (
        Demonstration,
        read_demonstration,
        read_demonstrations,
        resample,
        write_demonstration,
        write_demonstrations,
    )
    from ichain_drake.environments import make_env
    from ichain_drake.errors import IchainError, InputError, UnreachableError
    from ichain_drake.graph import Interaction, InteractionGraph, Origin
    from ichain_drake.learned_graph import LearnedGraph, build_learned_graph
    from ichain_drake.learning.chain.chain import LearnedChain, LearnedLink, LinkCandidates, learn_chain, learn_link
    from ichain_drake.learning.chain.link import EstimatorSpec
    from ichain_drake.learning.chain.models import ForwardModel, InverseModel
    from ichain_drake.learning.library import check_library, list_library, load_command, load_links, save_chain
    from ichain_drake.objects import (
        Car,
        ContractError,
        Joystick,
        JoystickMount,
        ObjectSettings,
        WorldObject,
        check_object,
    )
    from ichain_drake.objects.gymnasium import (
        ActionTerm,
        AttributeSnapshot,
        GameEnvironment,
        GameSpec,
        GymnasiumGame,
    )
    from ichain_drake.robot import BodySpec, HandSpec, RobotSpec, SphereSurface, build_robot
    from ichain_drake.robot.models import model_visualizer
    from ichain_drake.runs.goals.knowledge import Knowledge, learn_graph
    from ichain_drake.runs.goals.library import load_knowledge, load_what_fits, save_knowledge
    from ichain_drake.runs.goals.run import GraphRun, run_graph
    from ichain_drake.runs.paths.following import follow
    from ichain_drake.runs.paths.result import PathResult, PathRun
    from ichain_drake.runs.provenance import data_hash
    from ichain_drake.runs.showing import PlaybackPage, show
    from ichain_drake.scenarios import GraphScenario, PathScenario, Scenario
    from ichain_drake.scenarios.build import build_world
    from ichain_drake.scenarios.config import ScenarioConfig
    from ichain_drake.scenarios.environment_scenario import EnvironmentScenario
    from ichain_drake.scenarios.faults import Faults, GoalFaultConfig
    from ichain_drake.scenarios.graph_scenario import GraphConfig
    from ichain_drake.scenarios.hand_commands import HandCommands
    from ichain_drake.scenarios.object_maker import ObjectMaker
    from ichain_drake.scenarios.scripted_piece import ScriptedPiece
    from ichain_drake.simulation.commands import Commands
    from ichain_drake.simulation.recorder import record
    from ichain_drake.state import Role, StateSpace, Variable
    from ichain_drake.systems import load_scenario
    from ichain_drake.timing import FRAME, FRAMES_PER_TICK, TICK
    from ichain_drake.visualization import Camera, Recording, load_recording, write_playback
    from ichain_drake.world import World
    from ichain_drake.world.environment_spec import EnvironmentSpec, RootTerm

_MODULES = {
    "errors": ("IchainError", "InputError", "UnreachableError"),
    "timing": ("FRAME", "FRAMES_PER_TICK", "TICK"),
    "state": ("Role", "StateSpace", "Variable"),
    "graph": ("Interaction", "InteractionGraph", "Origin"),
    "objects": ("Car", "ContractError", "Joystick", "JoystickMount", "ObjectSettings", "WorldObject", "check_object"),
    "objects.gymnasium": ("ActionTerm", "AttributeSnapshot", "GameEnvironment", "GameSpec", "GymnasiumGame"),
    "robot": ("BodySpec", "HandSpec", "RobotSpec", "SphereSurface", "build_robot"),
    "robot.models": ("model_visualizer",),
    "world": ("World",),
    "demonstrations": (
        "Demonstration",
        "read_demonstration",
        "read_demonstrations",
        "resample",
        "write_demonstration",
        "write_demonstrations",
    ),
    "learning.chain.models": ("ForwardModel", "InverseModel"),
    "learning.chain.link": ("EstimatorSpec",),
    "learning.chain.chain": ("LearnedChain", "LearnedLink", "LinkCandidates", "learn_chain", "learn_link"),
    "learning.library": ("check_library", "list_library", "load_command", "load_links", "save_chain"),
    "learned_graph": ("LearnedGraph", "build_learned_graph"),
    "control.tracking.path": ("PathLimits", "TimedPath", "paper_path_error", "path_error", "read_path"),
    "control.tracking.move_to": ("MoveTo",),
    "control.tracking.chain": ("ChainController", "ControlCandidates", "make_controller"),
    "control.tracking.systems": ("Controller", "PathFollower"),
    "scenarios": ("GraphScenario", "PathScenario", "Scenario"),
    "systems": ("load_scenario",),
    "environments": ("make_env",),
    "scenarios.build": ("build_world",),
    "simulation.commands": ("Commands",),
    "scenarios.config": ("ScenarioConfig",),
    "runs.goals.library": ("load_knowledge", "load_what_fits", "save_knowledge"),
    "runs.goals.run": ("GraphRun", "run_graph"),
    "scenarios.graph_scenario": ("GraphConfig",),
    "scenarios.hand_commands": ("HandCommands",),
    "runs.goals.knowledge": ("Knowledge", "learn_graph"),
    "scenarios.environment_scenario": ("EnvironmentScenario",),
    "world.environment_spec": ("EnvironmentSpec", "RootTerm"),
    "scenarios.faults": ("Faults", "GoalFaultConfig"),
    "scenarios.object_maker": ("ObjectMaker",),
    "scenarios.scripted_piece": ("ScriptedPiece",),
    "simulation.recorder": ("record",),
    "runs.paths.following": ("follow",),
    "runs.paths.result": ("PathResult", "PathRun"),
    "runs.provenance": ("data_hash",),
    "runs.showing": ("PlaybackPage", "show"),
    "visualization": ("Camera", "Recording", "load_recording", "write_playback"),
}
_HOME = {name: module for module, names in _MODULES.items() for name in names}

__all__ = [
    "FRAME",
    "FRAMES_PER_TICK",
    "TICK",
    "ActionTerm",
    "AttributeSnapshot",
    "BodySpec",
    "Camera",
    "Car",
    "ChainController",
    "Commands",
    "ContractError",
    "ControlCandidates",
    "Controller",
    "Demonstration",
    "EnvironmentScenario",
    "EnvironmentSpec",
    "EstimatorSpec",
    "ForwardModel",
    "GameEnvironment",
    "GameSpec",
    "GraphConfig",
    "GraphRun",
    "GraphScenario",
    "GymnasiumGame",
    "HandCommands",
    "HandSpec",
    "IchainError",
    "InputError",
    "Interaction",
    "InteractionGraph",
    "InverseModel",
    "Joystick",
    "JoystickMount",
    "Knowledge",
    "LearnedChain",
    "LearnedGraph",
    "LearnedLink",
    "LinkCandidates",
    "Faults",
    "GoalFaultConfig",
    "MoveTo",
    "ObjectMaker",
    "ObjectSettings",
    "Origin",
    "PathFollower",
    "PathLimits",
    "PathResult",
    "PathRun",
    "PathScenario",
    "PlaybackPage",
    "Recording",
    "RobotSpec",
    "Role",
    "RootTerm",
    "Scenario",
    "ScenarioConfig",
    "ScriptedPiece",
    "SphereSurface",
    "StateSpace",
    "TimedPath",
    "UnreachableError",
    "Variable",
    "World",
    "WorldObject",
    "build_learned_graph",
    "build_robot",
    "build_world",
    "check_library",
    "check_object",
    "data_hash",
    "follow",
    "learn_chain",
    "learn_graph",
    "learn_link",
    "list_library",
    "load_command",
    "load_knowledge",
    "load_what_fits",
    "load_links",
    "load_recording",
    "load_scenario",
    "make_controller",
    "make_env",
    "model_visualizer",
    "paper_path_error",
    "path_error",
    "read_demonstration",
    "read_demonstrations",
    "read_path",
    "record",
    "resample",
    "run_graph",
    "save_chain",
    "save_knowledge",
    "show",
    "write_demonstration",
    "write_demonstrations",
    "write_playback",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
    globals()[name] = value  # the next access does not come here
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
