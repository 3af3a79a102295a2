"""The whole job of the water dispenser on `ideal`, and how it is refused and reported."""

import json
from dataclasses import replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from lamp import LampScenario

from ichain_drake.control.execution.controller import GraphController
from ichain_drake.control.execution.memory import ExecutorSettings, Memory
from ichain_drake.control.execution.tasks import Mode
from ichain_drake.control.planning.experience import Experience
from ichain_drake.control.planning.goals import parse_goal
from ichain_drake.control.planning.plan import Condition, Goal, NoPlan, Plan, PlanStep
from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction
from ichain_drake.learning import InteractionModel
from ichain_drake.runs.goals import run as running
from ichain_drake.runs.goals.output import classified, flags_of, make_graph_recording, write_graph_pictures
from ichain_drake.runs.goals.plan import make_plan
from ichain_drake.runs.goals.run import GraphRun, _wrong, describe, run_graph
from ichain_drake.simulation.commands import Commands
from ichain_drake.simulation.episode import Episode, EpisodeLog
from ichain_drake.simulation.goal_episode import GraphEpisode
from ichain_drake.simulation.wiring import goal_executor, look, start_command
from ichain_drake.systems.water_dispenser.scenario import WaterDispenser

HOT = ["cup.temperature >= 0.5", "cup.water >= 0.3", "not hand->cup"]


@cache
def scenario() -> WaterDispenser:
    return WaterDispenser((), "ideal")


def test_a_cup_of_warm_water_from_demonstrations_alone(dispenser_model: InteractionModel, tmp_path: Path) -> None:
    run = GraphRun(scenario(), tuple(HOT))
    run_graph(run, known=dispenser_model)
    report = run.report()
    assert report["goal_reached"], run.memory and (run.reason, run.memory.log)
    assert run.log is not None
    cup = run.log.states["cup"][-1]
    assert cup[4] >= 0.3
    assert cup[5] >= 0.5
    assert report["metrics"]["goal"] == HOT
    assert report["metrics"]["failure_cause"] == ""
    assert report["metrics"]["cautious"] == {}
    used = {e for step in report["metrics"]["plan"] for e in step["chain"]}
    assert used >= {"hand->power", "power->tank", "tank->cup"}
    assert report["control_steps"] == pytest.approx(report["sim_seconds"] * 3, abs=2)
    assert set(report["models"]) >= {"hand->cup", "cup->tank"}
    json.dumps(report, allow_nan=False)
    written = write_graph_pictures(run, tmp_path)
    assert [p.name for p in written] == ["timeline.png"]
    assert written[0].stat().st_size > 20_000
    assert run.model is not None
    said, truth = classified(run.model, run.log), flags_of(run.log, scenario().graph)
    for name, flags in said.items():  # one row a tick; now and then it is a tick late
        assert np.mean(flags != truth[name][::10]) < 0.1, name
    recording = make_graph_recording(run)
    assert recording.interactions == scenario().graph.interactions
    shown = recording.episodes[0].readouts
    assert (shown["goal"].values[-1], shown["error"].values[-1]) == (f"{len(HOT)} of {len(HOT)} met", "none")
    assert shown["tank temperature"].values[-1] == run.log.states["tank"][-1, 1]
    assert shown["skill"].values.count("activate") > 0
    assert set(np.unique(run.doing["mode"])) >= {Mode.ACTIVATE, Mode.CARRY, Mode.DRIVE}


def test_no_wire_leads_from_the_truth_to_the_controller(dispenser_model: InteractionModel) -> None:
    world = scenario().make_world(0)
    goal = parse_goal(HOT, dispenser_model, look(world))
    controller = GraphController(goal_executor(dispenser_model, goal), start_command(world))
    episode = GraphEpisode(world, controller)
    sources = {}
    for (system, port), (source, out) in episode.diagram.connection_map().items():
        if system is controller:
            sources[controller.get_input_port(port).get_name()] = source.get_output_port(out).get_name()
    assert sources == {
        **{n: f"{n}.measured" for n in world.graph.objects},
        **{f"{n}.valid": f"{n}.valid" for n in world.graph.objects},
    }


def test_a_plan_is_made_without_executing_it_and_refused_with_the_reason(dispenser_model: InteractionModel) -> None:
    start = look(scenario().make_world(0))
    goal, plan = make_plan(dispenser_model, HOT, start)
    assert isinstance(plan, Plan)
    assert len(goal.conditions) == 2
    _, none = make_plan(dispenser_model, ["cup.temperature >= 1.5"], start)
    assert isinstance(none, NoPlan)
    assert "cup.temperature" in none.reason


def test_keep_holds_a_variable_near_its_start(dispenser_model: InteractionModel) -> None:
    start = look(scenario().make_world(0))
    goal = parse_goal(["keep cup.x within 0.02"], dispenser_model, start)
    assert [(c.object, c.variable) for c in goal.conditions] == [("cup", "x")]
    assert goal.conditions[0].upper - goal.conditions[0].lower == pytest.approx(0.04)
    assert goal.conditions[0].lower + 0.02 == pytest.approx(start["cup"][0])
    with pytest.raises(InputError, match="no object 'mug'"):
        parse_goal(["keep mug.x within 0.02"], dispenser_model, start)
    with pytest.raises(InputError, match="at character 19, 'wide', a number is expected"):
        parse_goal(["keep cup.x within wide"], dispenser_model, start)


def test_an_impossible_goal_ends_the_run_with_its_reason(dispenser_model: InteractionModel) -> None:
    run = GraphRun(scenario(), ("cup.water >= 2",))
    run_graph(run, known=dispenser_model)
    report = run.report()
    assert not report["goal_reached"]
    assert report["metrics"]["failure_cause"] == "no plan"
    assert "cup.water" in report["reason"]
    assert report["control_steps"] <= 20


def test_a_run_that_takes_too_long_says_so(dispenser_model: InteractionModel) -> None:
    run = GraphRun(scenario(), tuple(HOT))
    run_graph(run, known=dispenser_model, settings=ExecutorSettings(ticks=15))
    assert run.report()["reason"] == "not done after 15 control steps"
    assert not run.goal_reached


def test_a_person_may_change_what_is_wanted_while_it_runs(dispenser_model: InteractionModel) -> None:
    world = scenario().make_world(0)
    start = look(world)
    goal = parse_goal(HOT, dispenser_model, start)
    executor, hand = goal_executor(dispenser_model, goal), start[scenario().graph.root]
    controller = GraphController(executor, start_command(world))
    episode = GraphEpisode(world, controller)
    item = next(a for a in scenario().adjustables() if a.name == "cup.water >=")
    item.apply(episode, 0.45)
    wanted = {(c.object, c.variable): c.lower for c in executor.goal.conditions}
    assert wanted == {("cup", "temperature"): 0.5, ("cup", "water"): 0.45}
    assert executor.goal.inactive == goal.inactive
    world = scenario().make_world(0)
    item.apply(Episode(world, Commands(hand[None])), 0.2)  # a demonstration wants nothing
    assert executor.goal.conditions[1].lower == 0.45


def test_a_report_tells_what_was_remembered() -> None:
    run = GraphRun(scenario(), tuple(HOT))
    report = run.report()
    metrics = report["metrics"]
    assert (report["control_steps"], metrics["replans"], metrics["events"], metrics["probability"]) == (0, 0, [], 0.0)
    edge = scenario().graph.interactions[0]
    run.memory = Memory(np.zeros(4), tick=7, replans=2, log=[(3, "slipped")], mode=Mode.REACHED)
    run.plan = Plan((PlanStep((edge,), ticks=5),), 5, 10, 20, probability=0.5, cost=8.0)
    report = run.report()
    metrics = report["metrics"]
    assert (report["control_steps"], metrics["replans"], metrics["events"]) == (7, 2, [{"step": 3, "what": "slipped"}])
    assert (metrics["probability"], metrics["cost"]) == (0.5, 8.0)
    assert metrics["search"] == {"expansions": 10, "rollouts": 20}
    assert run.goal_reached
    run.wrong = "the cup broke"
    assert not run.goal_reached


def lit(light: float = 0.6, *, held: bool = False, bright: bool = True, mode: Mode = Mode.REACHED) -> GraphRun:
    """A run of a lamp that ended so in truth; the first frame was dark, and so it was read all the time."""
    run = GraphRun(LampScenario(), ["lamp.light >= 0.5"])
    graph = LampScenario.graph
    states = {n: np.zeros((3, len(s))) for n, s in graph.objects.items()}
    states["lamp"][1:, 0] = light
    active = {n: np.zeros((3, len(graph.parents(n)))) for n in graph.objects if graph.parents(n)}
    active["dimmer"][:, 0] = [not held, not held, held]
    active["lamp"][:, graph.parents("lamp").index("switch")] = [0, 0, bright]
    measured = {n: np.zeros((3, len(s.observable))) for n, s in graph.objects.items()}
    run.log = EpisodeLog(np.arange(3) / 30, states, measured, active, np.zeros((3, 3)))
    run.goal = Goal(
        (Condition("lamp", "light", 0.5, 1.0),), (Interaction("hand", "dimmer"),), (Interaction("switch", "lamp"),)
    )
    run.memory = Memory(np.zeros(3), mode=mode, tick=7, replans=2, log=[(3, "lost: it slipped")])
    return run


def test_what_is_wrong_in_the_end_is_said_by_the_truth_of_the_last_frame() -> None:
    assert _wrong(lit()) == ""
    assert _wrong(lit(0.3)) == "0.5 <= lamp.light <= 1 is not true: it is 0.3"
    assert _wrong(lit(held=True)) == "hand->dimmer is still active"
    assert _wrong(lit(bright=False)) == "switch->lamp is not active"


@pytest.mark.parametrize(
    ("light", "mode", "reached", "cause"),
    [
        (0.6, Mode.REACHED, True, ""),
        (0.3, Mode.REACHED, False, "misjudged"),
        (0.6, Mode.STOPPED, False, "drive"),
        (0.3, Mode.STOPPED, False, "drive"),
    ],
)
def test_a_goal_is_reached_where_it_holds_in_truth_and_who_controls_says_so(
    light: float, mode: Mode, *, reached: bool, cause: str
) -> None:
    ended = lit(light, mode=mode)
    assert ended.memory is not None
    ended.memory.cause, ended.memory.reason = ("drive", "too slow") if mode == Mode.STOPPED else ("", "goal reached")
    run = GraphRun(LampScenario(), ["lamp.light >= 0.5"], goal=ended.goal, memory=ended.memory, log=ended.log)
    running.conclude(run)
    assert (run.goal_reached, run.cause) == (reached, cause)
    wrong = "0.5 <= lamp.light <= 1 is not true: it is 0.3"
    says = {"": "goal reached", "misjudged": f"taken as reached, but {wrong}", "drive": "too slow"}
    assert run.reason == says[cause]


def test_a_report_says_what_the_execution_did() -> None:
    run = lit()
    run.model = None
    report = run.report()
    assert (report["control_steps"], report["goal_reached"]) == (7, True)
    assert report["sim_seconds"] == pytest.approx(2 / 30, abs=1e-6)
    metrics = report["metrics"]
    assert (metrics["replans"], metrics["events"]) == (2, [{"step": 3, "what": "lost: it slipped"}])
    assert (report["models"], metrics["cautious"], "line" in report, "labels" in report) == ({}, {}, False, False)
    shown = Experience(cautious=(Interaction("hand", "dimmer"),))
    run.memory = replace(run.memory, experience=shown)  # type: ignore[type-var]
    run.model = SimpleNamespace(customary=lambda edge: (f"{edge.child}.x",))  # type: ignore[assignment]
    assert run.cautious == {"hand->dimmer": ["dimmer.x"]}


def test_a_plan_is_told_in_plain_numbers() -> None:
    edge = Interaction("hand", "dimmer")
    carry = PlanStep((edge,), {("dimmer", "x"): np.float64(0.4)}, predicted={"dimmer": np.array([0.4])}, ticks=6)  # type: ignore[dict-item]
    drive = replace(carry, chain=(edge, Interaction("dimmer", "lamp")), until=("lamp", "light", 1, 0.5))
    first, second = describe(Plan((carry, drive), 12))
    assert first == {
        "chain": ["hand->dimmer"], "wanted": {"dimmer.x": 0.4}, "drives": None,
        "predicted": {"dimmer": [0.4]}, "ticks": 6, "probability": 1.0,
    }  # fmt: skip
    assert (second["chain"], second["drives"]) == (["hand->dimmer", "dimmer->lamp"], "lamp.light")
    run = lit()
    run.plan = Plan((carry,), 6, 3, 5, probability=0.75, cost=8.0)
    metrics = run.report()["metrics"]
    assert (metrics["cost"], metrics["probability"], metrics["search"]) == (8.0, 0.75, {"expansions": 3, "rollouts": 5})
    run.plan = NoPlan(Condition("lamp", "light", 0.5, 1.0), 0.1, None, "dark", ("tried: nothing",))
    metrics = run.report()["metrics"]
    assert (metrics["explanation"], metrics["plan"], metrics["search"]) == (["tried: nothing"], [], {})
    # Where there was a plan at first, what counts is why there was none in the end.
    run.plan, run.memory = Plan((carry,), 6), Memory(np.zeros(3), refused=replace(run.plan, tree=("tried: all",)))
    assert run.report()["metrics"]["explanation"] == ["tried: all"]
