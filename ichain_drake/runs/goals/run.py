"""`run` and `plan` for a goal over an interaction graph: demonstrations, learning, planning, execution."""

from __future__ import annotations

import time
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits

from ichain_drake.control.execution.controller import GraphController
from ichain_drake.control.execution.executor import Executor, ExecutorSettings, Memory
from ichain_drake.control.execution.tasks import Mode
from ichain_drake.control.planning.contradictions import Contradiction
from ichain_drake.control.planning.format import count
from ichain_drake.control.planning.goal_text import check_goal_text
from ichain_drake.control.planning.goals import gap, value_of, words
from ichain_drake.control.planning.plan import Goal, NoPlan, Plan, States
from ichain_drake.control.planning.skills import SkillFunction
from ichain_drake.demonstrations import Demonstration, write_demonstrations
from ichain_drake.demonstrations.quality import tell_findings
from ichain_drake.graph import Interaction
from ichain_drake.learning import InteractionModel, InteractionSpec, read_pieces
from ichain_drake.learning.library import LibraryParts
from ichain_drake.runs.goals.knowledge import Knowledge, learn_rest
from ichain_drake.runs.goals.plan import make_goal
from ichain_drake.runs.goals.settings import graph_spec
from ichain_drake.runs.provenance import given_of, versions
from ichain_drake.scenarios.base import Progress
from ichain_drake.scenarios.goal_scenario import GoalScenario, PlansMotion
from ichain_drake.simulation.episode import EpisodeInterrupted, EpisodeLog
from ichain_drake.simulation.goal_episode import GraphEpisode, look, start_command
from ichain_drake.simulation.recorder import RecordingInterrupted
from ichain_drake.state import FloatArray


@dataclass
class GraphRun:
    """A run towards a goal, filled as it goes, so that an interrupted one keeps what it has.

    Attributes:
        scenario: what runs.
        expressions: the goal, as text; by default the scenario's own.
        number: of the run; keys start, noise and faults.
        pieces: demonstrations.
        knowledge: learned from them, or from a library.
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
    """

    scenario: GoalScenario
    expressions: Sequence[str] = ()
    number: int = 0
    pieces: list[Demonstration] = field(default_factory=list)
    knowledge: Knowledge | None = None
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

    def __post_init__(self) -> None:
        self.expressions = tuple(self.expressions) or own_goal(self.scenario)

    @property
    def model(self) -> InteractionModel | None:
        """What was learned, once it is."""
        return None if self.knowledge is None else self.knowledge.model

    @property
    def goal_reached(self) -> bool:
        """Whether the goal holds in truth, and the controller came to an end by itself."""
        return self.memory is not None and self.memory.mode == Mode.REACHED and not self.wrong

    def report(self) -> dict[str, Any]:
        """The contents of `report.json`."""
        scenario, memory = self.scenario, self.memory
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
            "metrics": {
                "goal": list(self.expressions),
                "replans": 0 if memory is None else memory.replans,
                "plan": [] if not isinstance(self.plan, Plan) else describe(self.plan),
                "probability": self.plan.probability if isinstance(self.plan, Plan) else 0.0,
                "explanation": list(self.plan.tree) if isinstance(self.plan, NoPlan) else [],
                "failure_cause": self.cause,
                "events": [] if memory is None else [{"step": t, "what": text} for t, text in memory.log],
                "cautious": self.cautious,
                "search": {} if not isinstance(self.plan, Plan) else {
                    "expansions": self.plan.expansions, "rollouts": self.plan.rollouts,
                },
            },
        }  # fmt: skip

    @property
    def cautious(self) -> dict[str, list[str]]:
        """Interactions that failed where their classifier saw no reason, and what was asked of them from then on."""
        if self.memory is None or self.model is None:
            return {}
        return {e.name: list(self.model.customary(e)) for e in self.memory.cautious}

    def _models(self) -> dict[str, Any]:
        assert self.knowledge is not None
        knowledge = self.knowledge
        report: dict[str, Any] = knowledge.model.report()
        edges = {}
        for edge in knowledge.model.graph.interactions:
            found = report["interactions"][edge.name]
            edges[edge.name] = {
                "samples": found["status"]["samples"],
                "robot_seconds": knowledge.robot_seconds_of(edge),
                "score": found["status"]["f1"],
                "source": knowledge.source_of(edge),
                **found,
            }
            if edge in knowledge.parts.reasons:
                edges[edge.name]["why_learned"] = knowledge.parts.reasons[edge]
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
        }
        for step in plan.steps
    ]


def record_pieces(
    run: GraphRun,
    keep: Path | None = None,
    say: Progress | None = None,
    known: Collection[Interaction] = (),
    *,
    overwrite: bool = False,
) -> None:
    """Record demonstrations into `run`, writing each to the folder `keep` as soon as it is there.

    Args:
        run: its pieces are replaced.
        keep: folder for them.
        say: called with a line before each.
        known: interactions that need none.
        overwrite: whether files in that folder may be replaced.
    """
    run.pieces = []
    try:
        with threadpool_limits(limits=1):
            for piece in run.scenario.record_demonstrations(say, [e.name for e in known]):
                run.pieces.append(piece)
                if keep is not None:
                    write_demonstrations([piece], keep, overwrite=overwrite)
    except RecordingInterrupted as stopped:
        if keep is not None:
            write_demonstrations([stopped.piece], keep, overwrite=overwrite)
        raise


def run_graph(
    run: GraphRun,
    *,
    demos: str | Path | None = None,
    keep_demos: str | Path | None = None,
    knowledge: Knowledge | LibraryParts | None = None,
    spec: InteractionSpec | None = None,
    own_skills: Mapping[tuple[Interaction, bool], SkillFunction] | None = None,
    settings: ExecutorSettings | None = None,
    resampled: bool = False,
    progress: Progress | None = None,
) -> None:
    """Do everything up to the report, filling `run`.

    Args:
        run: with `scenario` and `expressions` set.
        demos: folder of demonstrations to learn from, in place of recording them.
        keep_demos: folder that recorded demonstrations are written to.
        knowledge: what was learned before, in place of learning; of what a library knows in part, only the rest is
            recorded and learned (see `load_what_fits`).
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

    def show(known: Collection[Interaction]) -> Sequence[Demonstration]:
        if demos is not None:
            run.pieces = read_pieces(demos, run.scenario.graph, known, resampled=resampled, say=say)
            tell_findings(run.pieces, run.scenario.graph, say)
        else:
            record_pieces(run, keep_demos, say, known)
        return run.pieces

    if isinstance(knowledge, Knowledge):
        run.knowledge = knowledge
    else:
        parts = knowledge or LibraryParts()
        run.knowledge = learn_rest(show, run.scenario.graph, parts, spec or asked, own_skills, say)
    with threadpool_limits(limits=1):
        say("planning")
        start = look(run.scenario, run.number)
        run.goal = make_goal(run.expressions, run.knowledge.model, start)
        _execute(run, run.knowledge, settings or ExecutorSettings(), say)


def _execute(run: GraphRun, knowledge: Knowledge, settings: ExecutorSettings, say: Progress) -> None:
    assert run.goal is not None
    world, prepare = run.scenario.make_world(run.number)

    def planned(
        now: States, goal: Goal, cautious: Collection[Interaction], contradictions: Sequence[Contradiction]
    ) -> Plan | NoPlan:
        began = time.process_time()
        found = knowledge.planner.plan(now, goal, cautious, contradictions)
        run.plan_seconds += time.process_time() - began
        if run.plan is None:
            run.plan = found
        say("no plan" if isinstance(found, NoPlan) else f"executing {count(found)}")
        return found

    motion = run.scenario.make_motion() if isinstance(run.scenario, PlansMotion) else None
    executor = Executor(knowledge.model, knowledge.skills, planned, run.goal, settings, motion)
    controller = GraphController(executor, start_command(world, prepare))
    episode = GraphEpisode(world, controller, prepare)
    try:
        episode.run(settings.ticks + 10, lambda e: episode.memory.stopped)
    except KeyboardInterrupt:
        _keep(run, episode)
        assert run.log is not None
        raise EpisodeInterrupted(run.log) from None
    _keep(run, episode)
    assert run.memory is not None
    run.reason, run.cause = run.memory.reason, run.memory.cause
    run.wrong = _wrong(run)
    if run.memory.mode == Mode.REACHED and run.wrong:
        run.reason, run.cause = f"taken as reached, but {run.wrong}", "misjudged"


def _keep(run: GraphRun, episode: GraphEpisode) -> None:
    run.memory, run.log, run.doing = episode.memory, episode.log(), episode.doing()
    run.goal = episode.controller.executor.goal  # a person may have changed it


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


__all__ = ["GraphRun", "describe", "own_goal", "record_pieces", "run_graph"]
