"""Control one object through another: chains and graphs of learned object interactions, for Drake.

The names in `__all__` are the public interface, in the order of the data: describe, show, learn, ask, run, look.
Each is imported at its first use, so that `import ichain_drake` is instant and loads neither plants nor estimators.
What else was once public can still be had from here; its modules say what it is.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ichain_drake.control.planning.plan import Goal, Plan
    from ichain_drake.control.tracking.path import TimedPath
    from ichain_drake.demonstrations import Demonstration, read_demonstrations, write_demonstrations
    from ichain_drake.errors import InputError
    from ichain_drake.graph import InteractionGraph
    from ichain_drake.learned_graph import LearnedGraph
    from ichain_drake.learning import InteractionModel
    from ichain_drake.objects import ObjectSettings, WorldObject, check_object
    from ichain_drake.robot import HandSpec, RobotSpec, build_robot
    from ichain_drake.runs.learn import learn
    from ichain_drake.runs.library import load, save
    from ichain_drake.runs.run import run
    from ichain_drake.runs.showing import show
    from ichain_drake.scenarios import GraphScenario
    from ichain_drake.scenarios.build import AddWorld
    from ichain_drake.scenarios.graph_scenario import GraphConfig
    from ichain_drake.scenarios.scripted_piece import ScriptedPiece
    from ichain_drake.simulation.wiring import AddController
    from ichain_drake.state import Role, StateSpace, Variable
    from ichain_drake.systems import load_scenario
    from ichain_drake.timing import FRAME, TICK
    from ichain_drake.visualization import Camera, write_playback
    from ichain_drake.world import World

_PUBLIC = {
    # describe
    "Variable": "state",
    "Role": "state",
    "StateSpace": "state",
    "InteractionGraph": "graph",
    "WorldObject": "objects",
    "ObjectSettings": "objects",
    "check_object": "objects",
    "World": "world",
    "RobotSpec": "robot",
    "HandSpec": "robot",
    "build_robot": "robot",
    "GraphConfig": "scenarios.graph_scenario",
    "GraphScenario": "scenarios",
    "ScriptedPiece": "scenarios.scripted_piece",
    "Camera": "visualization",
    "load_scenario": "systems",
    # show
    "Demonstration": "demonstrations",
    "read_demonstrations": "demonstrations",
    "write_demonstrations": "demonstrations",
    # learn
    "learn": "runs.learn",
    "InteractionModel": "learning",
    "LearnedGraph": "learned_graph",
    "save": "runs.library",
    "load": "runs.library",
    # ask
    "Goal": "control.planning.plan",
    "Plan": "control.planning.plan",
    "TimedPath": "control.tracking.path",
    # run
    "AddWorld": "scenarios.build",
    "AddController": "simulation.wiring",
    "run": "runs.run",
    # look
    "show": "runs.showing",
    "write_playback": "visualization",
    # all along
    "InputError": "errors",
    "FRAME": "timing",
    "TICK": "timing",
}
_MORE = {
    "control.execution.executor": ("Planner",),
    "control.planning.experience": ("Experience",),
    "control.planning.plan": ("NoPlan", "PlanStep"),
    "control.tracking.chain": ("ChainController", "ControlCandidates", "make_controller"),
    "control.tracking.move_to": ("MoveTo",),
    "control.tracking.path": ("PathLimits", "paper_path_error", "path_error", "read_path"),
    "control.tracking.systems": ("Controller", "PathFollower"),
    "demonstrations": ("data_hash", "read_demonstration", "resample", "write_demonstration"),
    "environments": ("make_env",),
    "errors": ("IchainError", "UnreachableError"),
    "graph": ("Interaction", "Origin"),
    "learned_graph": ("build_learned_graph",),
    "learning.chain.chain": ("LearnedChain", "LearnedLink", "LinkCandidates", "learn_chain", "learn_link"),
    "learning.chain.link": ("EstimatorSpec",),
    "learning.chain.models": ("ForwardModel", "InverseModel"),
    "learning.library": ("check_library", "list_library", "load_command", "load_links", "save_chain"),
    "objects": ("Car", "ContractError", "Joystick", "JoystickMount"),
    "objects.gymnasium": ("ActionTerm", "AttributeSnapshot", "GameEnvironment", "GameSpec", "GymnasiumGame"),
    "robot": ("BodySpec", "SphereSurface"),
    "robot.models": ("model_visualizer",),
    "runs.goals.run": ("GraphRun", "run_graph"),
    "runs.paths.following": ("follow",),
    "runs.paths.result": ("PathResult", "PathRun"),
    "runs.showing": ("PlaybackPage",),
    "scenarios": ("PathScenario", "Scenario"),
    "scenarios.build": ("build_world",),
    "scenarios.config": ("ScenarioConfig",),
    "scenarios.environment_scenario": ("EnvironmentScenario",),
    "scenarios.faults": ("Faults", "GoalFaultConfig"),
    "scenarios.hand_commands": ("HandCommands",),
    "scenarios.object_maker": ("ObjectMaker",),
    "simulation.commands": ("Commands",),
    "simulation.recorder": ("record",),
    "timing": ("FRAMES_PER_TICK",),
    "visualization": ("Recording", "load_recording"),
    "world.environment_spec": ("EnvironmentSpec", "RootTerm"),
}
_HOME = {**{name: module for module, names in _MORE.items() for name in names}, **_PUBLIC}
_GONE = {
    "Knowledge": "InteractionModel",
    "learn_graph": "learn(graph, demonstrations)",
    "save_knowledge": "save(model, library, name)",
    "load_knowledge": "load(library, scenario)",
    "load_what_fits": "load(library, scenario)",
}

__all__ = [
    "Variable",
    "Role",
    "StateSpace",
    "InteractionGraph",
    "WorldObject",
    "ObjectSettings",
    "check_object",
    "World",
    "RobotSpec",
    "HandSpec",
    "build_robot",
    "GraphConfig",
    "GraphScenario",
    "ScriptedPiece",
    "Camera",
    "load_scenario",
    "Demonstration",
    "read_demonstrations",
    "write_demonstrations",
    "learn",
    "InteractionModel",
    "LearnedGraph",
    "save",
    "load",
    "Goal",
    "Plan",
    "TimedPath",
    "AddWorld",
    "AddController",
    "run",
    "show",
    "write_playback",
    "InputError",
    "FRAME",
    "TICK",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        now = f"; it is {_GONE[name]} now" if name in _GONE else ""
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}{now}")
    value = getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
    globals()[name] = value  # the next access does not come here
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
