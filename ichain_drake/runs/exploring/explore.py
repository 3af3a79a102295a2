"""From nothing but declared objects and reach to a graph: the robot tries things out, what tells most comes next."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from threadpoolctl import threadpool_limits

from ichain_drake.demonstrations import Demonstration
from ichain_drake.learning.discovery.edges import DiscoveredGraph, discover_graph
from ichain_drake.learning.discovery.experiments import Experiment, Question, bits, choose, questions
from ichain_drake.learning.discovery.labels import raw_piece
from ichain_drake.runs.exploring.rehearsing import rehearse
from ichain_drake.runs.exploring.settings import EXPLORING, ExploringSettings
from ichain_drake.runs.exploring.touching import Reach, Toucher
from ichain_drake.runs.goals.run import own_goal
from ichain_drake.runs.goals.unlabelled import without_flags
from ichain_drake.scenarios import build_world
from ichain_drake.scenarios.base import Progress
from ichain_drake.scenarios.graph_scenario import FIRST_DEMONSTRATION
from ichain_drake.simulation.recorder import record
from ichain_drake.simulation.wiring import start_command
from ichain_drake.timing import TICK


@dataclass
class Exploration:
    """What a robot found out by itself, filled as it goes, so that an interrupted one keeps what it has.

    Attributes:
        scenario: whose world it is in; of its graph, objects and robot alone are looked at.
        goal: that it tries to reach as soon as the graph is known; the scenario's own by default, empty for none.
        settings: see `ExploringSettings`.
        pieces: what it recorded, states alone.
        successes: the attempt that reached the goal; it shows nothing that had not been learned from the pieces.
        done: the experiments.
        found: the graph, after the last piece.
        history: a line a piece: what was done, why, and what was known afterwards.
        reason: why it ended.
        reached: whether the robot has reached the goal, as far as it can tell.
    """

    scenario: Any
    goal: tuple[str, ...] | None = None
    settings: ExploringSettings = EXPLORING
    pieces: list[Demonstration] = field(default_factory=list)
    successes: list[Demonstration] = field(default_factory=list)
    done: list[Experiment] = field(default_factory=list)
    found: DiscoveredGraph | None = None
    history: list[dict[str, Any]] = field(default_factory=list)
    reason: str = "interrupted"
    reached: bool = False

    def __post_init__(self) -> None:
        if self.goal is None:
            self.goal = own_goal(self.scenario)  # none where paths are followed

    @property
    def known(self) -> bool:
        """Whether the graph was the same in the last pieces, and nothing was left to try."""
        last = self.history[-self.settings.pieces :]
        return (
            len(last) == self.settings.pieces
            and all(h["sure"] for h in last)
            and all(set(h["edges"]) == set(last[-1]["edges"]) for h in last)
        )

    @property
    def over(self) -> bool:
        """Whether all is known that was asked for."""
        return self.known and (self.reached or not self.goal)

    @property
    def ticks_left(self) -> int:
        """Of the budget."""
        return int(self.settings.budget / TICK) - self._ticks

    @property
    def _ticks(self) -> int:
        return sum(len(p) - 1 for p in (*self.pieces, *self.successes))

    @property
    def robot_seconds(self) -> float:
        """That the robot moved [s]."""
        return TICK * self._ticks

    def report(self) -> dict[str, Any]:
        """Plain numbers and texts, ready for JSON."""
        return {
            "scenario": self.scenario.name,
            "physics": self.scenario.physics,
            "seed": self.scenario.seed,
            "known": self.known,
            "goal": list(self.goal or ()),
            "goal_reached": self.reached,
            "reason": self.reason,
            "pieces": len(self.pieces),
            "samples": self._ticks,
            "robot_seconds": round(self.robot_seconds, 3),
            "edges": self.history[-1]["edges"] if self.history else {},
            "open": [] if self.found is None else [q.text for q in self.unsure()],
            "history": self.history,
        }

    def lines(self) -> list[str]:
        """What was found, a line an interaction, what is still open, and what it cost."""
        found = [] if self.found is None else self.found.found
        out = [
            f"{f.edge.name}: sure by {f.confidence:.3f}"
            + "".join(f"; or it is {r.parent} ({r.probability:.2f})" for r in f.rivals)
            for f in found
        ]
        out += [f"open: {q.text}" for q in self.unsure()]
        return [*out, f"{self.reason}: {len(self.pieces)} pieces, {self.robot_seconds:.0f} s of the robot"]

    def unsure(self) -> list[Question]:
        """Questions whose answer isn't sure."""
        reach = Reach(self.scenario.graph)
        every = questions(self.found, [n for n in reach.spaces if n != reach.root], reach.touchable)
        return [q for q in every if q.bits > bits(self.settings.confidence)]

    def open_questions(self) -> list[Question]:
        """Those of them for which not everything was tried several times."""
        return [q for q in self.unsure() if any(self.done.count(e) < self.settings.tries for e in q.answers)]


def explore(run: Exploration, say: Progress = lambda line: None) -> None:
    """Try things out until the graph is known or the budget is spent, filling `run`.

    Each piece begins as a run of the system does. Nothing is taken from the scenario but the world, its objects' state
    spaces, and which of them is the robot.

    Args:
        run: with the scenario.
        say: called with a line at each step.

    Raises:
        InputError: if the robot is no hand, or there are several.
        RecordingInterrupted: on Ctrl-C; `run` keeps the pieces before.
    """
    scenario, settings = run.scenario, run.settings
    reach = Reach(scenario.graph)
    objects = [n for n in reach.spaces if n != reach.root]
    rehearsed = 0  # pieces that there were then
    with threadpool_limits(limits=1):
        while run.ticks_left >= settings.piece and not run.over:
            number = FIRST_DEMONSTRATION + len(run.pieces)
            if run.known and len(run.pieces) >= rehearsed + settings.pieces:
                assert run.goal and run.found is not None
                say(f"{' and '.join(run.goal)}: with what is known")
                attempt = rehearse(scenario, run.goal, run.pieces, run.found, number, run.ticks_left, say)
                say(attempt.reason)
                run.reached = attempt.reached
                if attempt.piece is not None:
                    (run.successes if attempt.reached else run.pieces).append(attempt.piece)
                    _note(run, reach, "reach the goal", attempt.reason)
                rehearsed = len(run.pieces)
                continue
            experiment, why = choose(questions(run.found, objects, reach.touchable), run.done)
            say(f"{experiment}: {why}")
            world = build_world(scenario, run=number)
            toucher = Toucher(reach, experiment, start_command(world), [scenario.seed, number], settings)
            piece = record(world, toucher, settings.piece, tuple(reach.spaces), f"explored_{number}")
            run.done.append(experiment)
            run.pieces.append(without_flags(piece))
            _note(run, reach, str(experiment), why)
    goal = ", and the goal was reached" if run.reached else ""
    known = "everything was tried several times" if run.unsure() else "the graph is known"
    run.reason = f"{known}{goal}" if run.over else "the budget is spent"


def _note(run: Exploration, reach: Reach, what: str, why: str) -> None:
    """What was done in the last piece, and what is known since. A goal that was reached ends it: nothing changes."""
    if not run.reached:
        run.found = discover_graph([raw_piece(p, run.scenario.graph) for p in run.pieces], reach.spaces, reach.root)
    assert run.found is not None
    line = {
        "piece": (*run.pieces, *run.successes)[-1].name,
        "experiment": what,
        "why": why,
        "robot_seconds": round(run.robot_seconds, 3),
        "sure": not run.open_questions(),
        "edges": {
            f.edge.name: {
                "confidence": round(f.confidence, 4),
                "rivals": {r.parent: round(r.probability, 4) for r in f.rivals},
            }
            for f in run.found.found
        },
    }
    run.history.append(line)
