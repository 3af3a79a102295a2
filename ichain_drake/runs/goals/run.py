"""`run` and `plan` for a goal over an interaction graph: demonstrations, learning, planning, execution."""

from __future__ import annotations

import time
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits

from ichain_drake.control.execution.controller import GraphController
from ichain_drake.control.execution.executor import Executor, ExecutorSettings, Memory
from ichain_drake.control.execution.tasks import Mode
from ichain_drake.control.planning.advice import Advice, helpful_demonstration
from ichain_drake.control.planning.experience import Experience
from ichain_drake.control.planning.format import count
from ichain_drake.control.planning.goal_text import check_goal_text
from ichain_drake.control.planning.goals import gap, parse_goal, value_of, words
from ichain_drake.control.planning.plan import Goal, NoPlan, Plan, States
from ichain_drake.control.planning.skills import OwnSkills
from ichain_drake.demonstrations import Demonstration
from ichain_drake.errors import UnreachableError
from ichain_drake.graph import Interaction
from ichain_drake.learning import InteractionModel, InteractionSpec
from ichain_drake.learning.discovery.labels import Labelled
from ichain_drake.remote import RemoteWorld, connect
from ichain_drake.runs.goals.settings import graph_spec, planner_of
from ichain_drake.runs.goals.unlabelled import Taught
from ichain_drake.runs.learn import Known, learn_rest
from ichain_drake.runs.pieces import read_for, record_pieces
from ichain_drake.runs.provenance import given_of, versions
from ichain_drake.scenarios.base import Progress
from ichain_drake.scenarios.goal_scenario import GoalScenario, PlansMotion
from ichain_drake.simulation.episode import EpisodeInterrupted, EpisodeLog
from ichain_drake.simulation.goal_episode import GraphEpisode
from ichain_drake.simulation.wiring import goal_executor, look, make_planner, start_command
from ichain_drake.state import FloatArray
from ichain_drake.world.world import World


@dataclass
class GraphRun:
    """A run towards a goal, filled as it goes, so that an interrupted one keeps what it has.

    Attributes:
        scenario: what runs.
        expressions: the goal, as text; by default the scenario's own.
        number: of the run; keys start, noise and faults.
        pieces: demonstrations.
        model: learned from them, or from a library.
        goal: in force; conditions with `start` refer to readings at the start.
        plan: the first plan, or why there is none.
        memory: of the execution.
        log: everything logged in it.
        doing: the controller's ports, shape (n,) each.
        reason: why the goal was or was not reached.
        cause: of a failure in a word.
        wrong: conditions that do not hold in truth at the end, in words.
        plan_seconds: processor time that went into planning [s].
        started: when, by the monotonic clock [s].
        taught: whether flags and edges are inferred from states.
        labels: what was inferred, where it was.
        robot: address of a robot in another process; empty for a world in this one.
        line: how the line to it was.
    """

    scenario: GoalScenario
    expressions: Sequence[str] = ()
    number: int = 0
    pieces: list[Demonstration] = field(default_factory=list)
    model: InteractionModel | None = None
    goal: Goal | None = None
    plan: Plan | NoPlan | None = None
    memory: Memory | None = None
    log: EpisodeLog | None = None
    doing: dict[str, FloatArray] = field(default_factory=dict)
    reason: str = "interrupted"
    cause: str = "interrupted"
    wrong: str = ""
    plan_seconds: float = 0.0
    started: float = field(default_factory=time.monotonic)
    taught: Taught = field(default_factory=Taught)
    labels: Labelled | None = None
    robot: str = ""
    line: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.expressions = tuple(self.expressions) or own_goal(self.scenario)

    @property
    def goal_reached(self) -> bool:
        """Whether the goal holds in truth, and the controller came to an end by itself."""
        return self.memory is not None and self.memory.mode == Mode.REACHED and not self.wrong

    def report(self) -> dict[str, Any]:
        """The contents of `report.json`."""
        scenario, memory = self.scenario, self.memory
        refused = self.plan if isinstance(self.plan, NoPlan) else None
        if memory is not None and memory.mode != Mode.REACHED:
            refused = memory.refused or refused
        return {
            "scenario": scenario.name,
            "physics": scenario.physics,
            "seed": scenario.seed,
            "goal_reached": self.goal_reached,
            "reason": self.reason,
            "control_steps": 0 if memory is None else memory.tick,
            "sim_seconds": 0.0 if self.log is None else round(float(self.log.times[-1]), 6),
            "wall_seconds": time.monotonic() - self.started,
            "versions": versions(),
            "given": given_of(scenario),
            "models": {} if self.model is None else self._models(),
            **({} if self.labels is None else {"labels": self.labels.report()}),
            **({"line": self.line} if self.robot else {}),
            "metrics": {
                "goal": list(self.expressions),
                "replans": 0 if memory is None else memory.replans,
                "plan": [] if not isinstance(self.plan, Plan) else describe(self.plan),
                "cost": self.plan.cost if isinstance(self.plan, Plan) else None,
                "probability": self.plan.probability if isinstance(self.plan, Plan) else 0.0,
                "explanation": [] if refused is None else list(refused.tree),
                "failure_cause": self.cause,
                "events": [] if memory is None else [{"step": t, "what": text} for t, text in memory.log],
                "cautious": self.cautious,
                "would_help": None if self.advice is None else self.advice.report(),
                "search": {} if not isinstance(self.plan, Plan) else {
                    "expansions": self.plan.expansions, "rollouts": self.plan.rollouts,
                },
            },
        }  # fmt: skip

    @property
    def advice(self) -> Advice | None:
        """Which demonstration would have helped most; None where the goal was reached, or nothing tells."""
        if self.goal_reached or self.model is None:
            return None
        memory, refused = self.memory, self.plan if isinstance(self.plan, NoPlan) else None
        if memory is None or not memory.readings:
            return None
        shown = memory.experience.contradictions
        return helpful_demonstration(self.model, shown, memory.refused or refused, memory.readings[-1])

    @property
    def cautious(self) -> dict[str, list[str]]:
        """Interactions that failed where their classifier saw no reason, and what was asked of them from then on."""
        if self.memory is None or self.model is None:
            return {}
        return {e.name: list(self.model.customary(e)) for e in self.memory.experience.cautious}

    def _models(self) -> dict[str, Any]:
        assert self.model is not None
        model = self.model
        report: dict[str, Any] = model.report()
        edges = {}
        for edge in model.graph.interactions:
            found = report["interactions"][edge.name]
            edges[edge.name] = {
                "samples": found["status"]["samples"],
                "robot_seconds": model.robot_seconds_of(edge),
                "score": found["status"]["f1"],
                "source": model.source_of(edge),
                **found,
            }
            if edge in model.known.reasons:
                edges[edge.name]["why_learned"] = model.known.reasons[edge]
        return edges | {"passive": report["passive"], "pieces": report["pieces"], "warnings": report["warnings"]}


def own_goal(scenario: GoalScenario) -> tuple[str, ...]:
    """The goal in a scenario's configuration, as text; empty where there is none."""
    return tuple(getattr(scenario.config, "goal", ()))


def describe(plan: Plan) -> list[dict[str, Any]]:
    """A plan as plain numbers and texts, for the report."""
    return [
        {
            "chain": [e.name for e in step.chain],
            "wanted": {f"{o}.{v}": float(x) for (o, v), x in step.wanted.items()},
            "drives": None if step.until is None else f"{step.until[0]}.{step.until[1]}",
            "predicted": {n: [float(x) for x in s] for n, s in step.predicted.items()},
            "ticks": int(step.ticks),
            "probability": float(step.probability),
        }
        for step in plan.steps
    ]


def run_graph(
    run: GraphRun,
    *,
    demos: str | Path | None = None,
    keep_demos: str | Path | None = None,
    known: Known | None = None,
    spec: InteractionSpec | None = None,
    own_skills: OwnSkills | None = None,
    settings: ExecutorSettings | None = None,
    resampled: bool = False,
    progress: Progress | None = None,
) -> None:
    """Do everything up to the report, filling `run`.

    Args:
        run: with `scenario` and `expressions` set.
        demos: folder of demonstrations to learn from, in place of recording them.
        keep_demos: folder that recorded demonstrations are written to.
        known: what was learned before, in place of learning; of what is known in part, only the rest is recorded and
            learned (see `load`).
        spec: candidate estimators; default: those that the scenario's settings ask for.
        own_skills: a designer's functions, by interaction and whether they activate.
        settings: of the execution.
        resampled: whether to take demonstrations of another period to the library's.
        progress: called with a line at each step.

    Raises:
        InputError: on bad demonstrations, a goal that can't be read, or a setting that is for paths.
        EpisodeInterrupted, RecordingInterrupted: on Ctrl-C; `run` keeps what there is.
    """
    keep_demos = None if keep_demos is None else Path(keep_demos)
    demos = None if demos is None else Path(demos)
    say = progress or (lambda line: None)
    asked = graph_spec(run.scenario.config)
    check_goal_text(run.expressions, run.scenario.graph)
    taught = run.taught
    graph = taught.graph(run.scenario.graph)

    def show(shown: Collection[Interaction]) -> Sequence[Demonstration]:
        run.pieces = []
        if demos is not None:
            run.pieces = read_for(
                run.scenario, demos, shown, graph=graph, resampled=resampled, unlabelled=taught.unlabelled, say=say
            )
        else:
            record_pieces(run.scenario, run.pieces, keep_demos, say, [e.name for e in shown])
        return run.pieces

    if taught.unlabelled and not isinstance(known, InteractionModel):
        run.labels = taught.labelled(show(()), graph, say, recorded=demos is None)
        run.pieces, graph = list(run.labels.pieces), run.labels.graph
        model = run.model = learn_rest(lambda shown: run.pieces, graph, known, spec or asked, say)
    else:
        model = run.model = learn_rest(show, graph, known, spec or asked, say)
    with threadpool_limits(limits=1):
        say("planning")
        world = connect(run.robot, run.scenario.graph) if run.robot else run.scenario.make_world(run.number)
        run.goal = parse_goal(run.expressions, model, look(world))
        execute(run, model, run.goal, world, own_skills, settings or ExecutorSettings(), say)


def execute(
    run: GraphRun,
    model: InteractionModel,
    wanted: Goal,
    world: World,
    own_skills: OwnSkills | None,
    settings: ExecutorSettings,
    say: Progress,
) -> None:
    """Plan and act towards a goal with what was learned, filling `run`.

    Args:
        run: with its scenario and number.
        model: the learned graph.
        wanted: the goal.
        world: no part of a diagram yet; its default context is the start.
        own_skills, settings: as for `run_graph`.
        say: called with a line at each plan.

    Raises:
        EpisodeInterrupted: on Ctrl-C; `run` keeps what there is.
    """
    executor = executor_of(run, model, wanted, own_skills, settings, say)
    episode = GraphEpisode(world, GraphController(executor, start_command(world)))
    try:
        episode.run(settings.ticks + 10, lambda e: episode.memory.stopped)
    except KeyboardInterrupt:
        _keep(run, episode)
        assert run.log is not None
        raise EpisodeInterrupted(run.log) from None
    except UnreachableError as lost:  # the robot, where it is elsewhere
        _keep(run, episode)
        run.reason, run.cause = str(lost), "unreachable"
        raise
    _keep(run, episode)
    conclude(run)


def executor_of(
    run: GraphRun,
    model: InteractionModel,
    wanted: Goal,
    own_skills: OwnSkills | None,
    settings: ExecutorSettings,
    say: Progress,
) -> Executor:
    """What decides in a run; it fills the run's first plan and its time for planning. Arguments as for `execute`."""
    planner = make_planner(model, planner_of(run.scenario.config))

    def planned(now: States, goal: Goal, experience: Experience) -> Plan | NoPlan:
        began = time.process_time()
        found = planner.plan(now, goal, experience)
        run.plan_seconds += time.process_time() - began
        if run.plan is None:
            run.plan = found
        say("no plan" if isinstance(found, NoPlan) else f"executing {count(found)}")
        return found

    motion = run.scenario.make_motion() if isinstance(run.scenario, PlansMotion) else None
    return goal_executor(model, wanted, motion=motion, own_skills=own_skills, settings=settings, planner=planned)


def conclude(run: GraphRun) -> None:
    """Say why a run whose memory and log are there ended, and whether its goal holds in truth."""
    assert run.memory is not None
    run.reason, run.cause = run.memory.reason, run.memory.cause
    run.wrong = _wrong(run)
    if run.memory.mode == Mode.REACHED and run.wrong:
        run.reason, run.cause = f"taken as reached, but {run.wrong}", "misjudged"


def _keep(run: GraphRun, episode: GraphEpisode) -> None:
    run.memory, run.log, run.doing = episode.memory, episode.log(), episode.doing()
    run.goal = episode.controller.executor.goal  # a person may have changed it
    if isinstance(episode.world, RemoteWorld):
        run.line = episode.world.report()


def _wrong(run: GraphRun) -> str:
    """Which condition does not hold in truth at the end, in words; empty if all hold."""
    assert run.log is not None
    assert run.goal is not None
    graph = run.scenario.graph
    last = {n: s[-1][graph.objects[n].observable_indices] for n, s in run.log.states.items()}
    for c in run.goal.conditions:
        value = float(value_of(c, last, graph))
        if gap(c, value) > 0:
            return f"{words(c, graph)} is not true: it is {value:.4g}"
    for e in run.goal.inactive:
        if run.log.active[e.child][-1, graph.parents(e.child).index(e.parent)] > 0.5:  # noqa: PLR2004 - a flag
            return f"{e.name} is still active"
    for e in run.goal.active:
        if run.log.active[e.child][-1, graph.parents(e.child).index(e.parent)] < 0.5:  # noqa: PLR2004 - a flag
            return f"{e.name} is not active"
    return ""


__all__ = ["GraphRun", "describe", "own_goal", "run_graph"]
