"""Executing a plan over an interaction graph (paper appendix B): a state machine that decides once a tick.

For each step of the plan: deactivate the running interaction, activate the next, then move objects and drive variables
with the learned models under feedback. Monitors compare what is observed with what was predicted; where they differ, it
plans anew from what is observed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ichain_drake.control.graph.carried import Carried
from ichain_drake.control.graph.carrying import Carry, CarryPart
from ichain_drake.control.graph.course import Motion
from ichain_drake.control.graph.driving import Drive
from ichain_drake.control.graph.goals import gap, value_of, words
from ichain_drake.control.graph.model import GraphModel
from ichain_drake.control.graph.plan import Goal, NoPlan, Plan, PlanStep, States
from ichain_drake.control.graph.skills import Skills
from ichain_drake.control.graph.tasks import Answer, Failed, Look, Mode, Switch, Task, View
from ichain_drake.control.graph.travel import resting_states
from ichain_drake.errors import UnreachableError
from ichain_drake.graph import Interaction
from ichain_drake.state import FloatArray

Planner = Callable[[States, Goal], Plan | NoPlan]

_READINGS = 12
_LOOK = 4  # ticks of averaging before planning and after a step
_GONE, _NARROW = 5.0, 0.05  # demonstrated ranges away, each at least so wide [m]
_PLACE, _VALUE = 0.05, 0.12  # of the demonstrated range: larger deviations from the prediction are noticed


@dataclass(frozen=True)
class ExecutorSettings:
    """How an execution goes.

    Attributes:
        monitors: whether observations are compared with predictions; without, every step is done once.
        replans: at most.
        attempts: at a switching.
        ticks: of an execution at most.
    """

    monitors: bool = True
    replans: int = 5
    attempts: int = 4
    ticks: int = 3000


@dataclass
class Memory:
    """Everything that an execution remembers from tick to tick.

    Attributes:
        command: last command, shape (n_root,).
        tick: decisions so far.
        readings: valid measurements of the last ticks.
        tasks: what is to do, in order.
        plan: the running plan.
        step: index of its running step; -1 before the first.
        plans: every plan so far.
        replans: plans that were made anew.
        mode: see `Mode`.
        reason: why it stopped; empty while it runs.
        cause: of the failure in a word; empty if there is none.
        looked_again: whether it looks longer since no plan was found.
        log: (tick, text) of everything that did not go as planned.
        carried: what the robot holds, and where it let go of what it held.
    """

    command: FloatArray
    tick: int = 0
    readings: list[dict[str, FloatArray]] = field(default_factory=list)
    tasks: list[Task] = field(default_factory=list)
    plan: Plan | None = None
    step: int = -1
    plans: list[Plan] = field(default_factory=list)
    replans: int = 0
    mode: Mode = Mode.LOOK
    reason: str = ""
    cause: str = ""
    looked_again: bool = False
    log: list[tuple[int, str]] = field(default_factory=list)
    carried: Carried = field(default_factory=Carried)

    @property
    def stopped(self) -> bool:
        """Whether it has ended, one way or the other."""
        return self.mode in (Mode.REACHED, Mode.STOPPED)

    @property
    def edge(self) -> Interaction | None:
        """The interaction that the running task is about."""
        return self.tasks[0].edge if self.tasks else None


class Executor:
    """Brings about a goal with a learned graph.

    It holds no memory of its own: `decide` changes the `Memory` that it is given.

    Args:
        model: the learned graph.
        skills: how the robot's interactions are switched.
        planner: makes plans from measured states.
        goal: what is wanted; or a function of the measured states at the start.
        settings: see there.
        motion: lays out the robot's ways; straight lines without.
    """

    def __init__(
        self,
        model: GraphModel,
        skills: Skills,
        planner: Planner,
        goal: Goal,
        settings: ExecutorSettings | None = None,
        motion: Motion | None = None,
    ) -> None:
        self.model, self.skills, self.planner, self.goal = model, skills, planner, goal
        self.settings = settings or ExecutorSettings()
        self.motion = motion
        self._vias = resting_states(model)
        self._root = model.graph.root

    def start(self, command: FloatArray) -> Memory:
        """A fresh memory.

        Args:
            command: where the robot is, shape (n_root,).
        """
        return Memory(np.array(command, dtype=float), tasks=[Look(None, _LOOK)])

    def decide(  # noqa: PLR0911 - one return an outcome
        self, memory: Memory, measured: States, valid: Mapping[str, bool]
    ) -> FloatArray:
        """One tick.

        Args:
            memory: of this execution; changed.
            measured: states, shape (n_variables,) each.
            valid: whether each sensor is valid. If one is not, the last command is held.

        Returns:
            The robot's command, shape (n_root,).
        """
        if memory.stopped:
            return memory.command
        memory.tick += 1
        if not all(valid.values()):
            memory.mode = Mode.BLIND
            return memory.command
        reading = {n: np.array(v, dtype=float) for n, v in measured.items()}
        memory.readings = [*memory.readings[1 - _READINGS :], reading]
        if memory.tick > self.settings.ticks:
            return self._stop(memory, "time", f"not done after {self.settings.ticks} control steps")
        gone = self._gone(reading)
        if gone:
            return self._stop(memory, "gone", gone)
        for _ in range(100):  # tasks that need no time
            if not memory.tasks:
                self._next(memory)
                if memory.stopped:
                    return memory.command
                continue
            task = memory.tasks[0]
            memory.mode = task.mode
            answer = self._act(memory, task)
            if isinstance(answer, Failed):
                self._failed(memory, answer)
                if memory.stopped:
                    return memory.command
            elif isinstance(answer, str):
                memory.tasks.pop(0)
            else:
                space = self.model.graph.objects[self._root].observable
                memory.command = space.clip(answer)
                return memory.command
        return self._stop(memory, "loop", "its tasks ended at once over and over again")

    def _view(self, memory: Memory) -> View:
        view = View(
            self.model, self.skills, self._vias, memory.readings, memory.command, self.settings.monitors,
            self.settings.attempts, self.motion, memory.carried.left,
        )  # fmt: skip
        if view.left:
            view.left = memory.carried.standing(self.model, view.averaged())
        return view

    def _gone(self, reading: States) -> str:
        """Which object is where nothing brings it back from (it fell, say), in words; empty if there is none."""
        for name in self.model.passive:
            low, high = self.model.low[name], self.model.high[name]
            for i, v in enumerate(self.model.graph.objects[name].observable.variables):
                away = max(low[i] - reading[name][i], reading[name][i] - high[i])
                if v.role is not None and v.role.kind == "position" and away > _GONE * max(high[i] - low[i], _NARROW):
                    return f"{name} is gone: its {v.name} is {reading[name][i]:.4g} {v.unit}; start again"
        return ""

    def _act(self, memory: Memory, task: Task) -> Answer:
        """One tick of a task; what the robot carries and where it let go of things is kept on the way."""
        view = self._view(memory)
        try:
            answer = task.act(view)
        except UnreachableError as error:
            if task.edge is None:
                raise
            return Failed(task.edge, "reach", f"{task.edge.name}: {error}")
        carried, child = memory.carried, task.edge.child if task.edge is not None else ""
        if isinstance(task, Carry):
            memory.carried = carried.taken(child)
        elif isinstance(task, Switch) and not task.activate:
            if carried.held == child:
                memory.carried = carried.let_go(memory.command)
            elif isinstance(answer, str):
                memory.carried = carried.settled(child, view.averaged()[child])
        return answer

    # From step to step.

    def _next(self, memory: Memory) -> None:
        now = self._view(memory).averaged(_LOOK)
        if memory.plan is None:
            self._plan(memory, self._view(memory).averaged(_READINGS) if memory.looked_again else now)
            return
        if memory.step >= 0 and self.settings.monitors:
            off = self._deviation(memory.plan.steps[memory.step], now)
            if off:
                self._replan(memory, "deviation", off)
                return
        memory.step += 1
        if memory.step < len(memory.plan.steps):
            memory.tasks = self._tasks(memory.plan.steps[memory.step], now)
            return
        unmet = self.unmet(now)
        if not unmet or not self.settings.monitors:
            memory.mode = Mode.REACHED
            memory.reason = "goal reached" if not unmet else "the plan was carried out; not watched whether it worked"
            return
        self._replan(memory, "goal unmet", unmet)

    def unmet(self, states: States) -> str:
        """Which condition of the goal does not hold, in words; empty if all hold."""
        for c in self.goal.conditions:
            value = float(value_of(c, states, self.model.graph))
            if gap(c, value) > 0:
                return f"{words(c, self.model.graph)} does not hold: it is {value:.4g}"
        for e in self.goal.inactive:
            if float(self.model.decide(e, states)) >= 0:
                return f"{e.name} is still active"
        return ""

    def _plan(self, memory: Memory, now: States) -> None:
        found = self.planner(now, self.goal)
        if isinstance(found, NoPlan):
            if self.settings.monitors and not memory.looked_again:
                # One reading less noisy may be all that is missing.
                memory.looked_again, memory.tasks = True, [Look(None, _READINGS)]
                return
            self._stop(memory, "no plan", found.reason)
            return
        memory.looked_again = False
        memory.plan, memory.step = found, -1
        memory.plans.append(found)

    def _replan(self, memory: Memory, cause: str, text: str) -> None:
        memory.log.append((memory.tick, f"{cause}: {text}"))
        if memory.replans >= self.settings.replans:
            self._stop(memory, cause, f"{text}; given up after {memory.replans} new plans")
            return
        memory.replans += 1
        memory.plan, memory.step = None, -1
        memory.tasks = [Look(None, _LOOK)]

    def _failed(self, memory: Memory, failure: Failed) -> None:
        """Bring a carried object back to where its drive began, let go of what is not carried, and plan anew."""
        step = memory.plan.steps[memory.step] if memory.plan is not None and memory.step >= 0 else None
        if failure.cause == "lost":
            memory.carried = memory.carried.slipped()
        self._replan(memory, failure.cause, failure.text)
        if memory.stopped or step is None:
            return
        edge, view = step.chain[0], self._view(memory)
        carries = bool(step.after or step.before or step.until is None)
        back: list[Task] = []
        if carries and view.is_active(edge):
            now = view.averaged()
            if failure.cause not in ("carry", "lost") and step.before:
                back = _carry(self.model, edge, self._indices(step.before, edge), now, place_first=False)
        elif failure.cause != "deactivation":
            back = [Switch(edge, activate=False, forced=True)]
        memory.tasks = [*back, *memory.tasks]

    def _stop(self, memory: Memory, cause: str, reason: str) -> FloatArray:
        memory.mode, memory.cause, memory.reason = Mode.STOPPED, cause, reason
        memory.tasks = []
        return memory.command

    def _deviation(self, step: PlanStep, now: States) -> str:
        """What is not as predicted at a step's end, in words; empty if all is."""
        for name, dynamics in self.model.passive.items():
            space = self.model.graph.objects[name].observable
            if name not in step.predicted:
                continue
            off = np.abs(space.difference(now[name], step.predicted[name]))
            width = self.model.high[name] - self.model.low[name]
            for i, v in enumerate(space.variables):
                if dynamics.variables[i].kind != "hold" or v.kind in ("binary", "integer"):
                    continue
                pose = v.role is not None and v.role.kind in ("position", "orientation")
                allowed = max((_PLACE if pose else _VALUE) * width[i], 4.0 * self.model.noise[name][i])
                if off[i] > allowed:
                    return (
                        f"{name}.{v.name} is {now[name][i]:.3g} where {step.predicted[name][i]:.3g} was predicted "
                        f"after {step.chain[-1].name}"
                    )
        return ""

    # The tasks of a step.

    def _tasks(self, step: PlanStep, now: States) -> list[Task]:
        edge = step.chain[0]
        mine = [e for e in self.model.graph.interactions if e.parent == self._root and e != edge]
        out: list[Task] = [Switch(e, activate=False) for e in mine if float(self.model.decide(e, now)) >= 0]
        if not step.wanted and not step.before and not step.after and step.until is None:
            return [*out, Switch(edge, activate=False), Look(None, _LOOK)]
        carried = self._indices(step.wanted, edge, but=step.until)
        follows = bool(step.before or step.after or step.until is None)
        out.append(Switch(edge, activate=True))
        if follows and step.before:
            out += _carry(self.model, edge, self._indices(step.before, edge), now, place_first=True)
        if follows and carried:
            out += _carry(self.model, edge, carried, now, place_first=True)
        if step.until is not None:
            goal = None if follows or step.hold is None else step.hold
            out.append(Drive(edge, step=step, goal=goal))
            if step.before:
                out += _carry(self.model, edge, self._indices(step.before, edge), now, place_first=False)
        after = self._indices(step.after, edge)
        if after and after != carried:
            out += _carry(self.model, edge, after, now, place_first=False)
        if step.release:
            out.append(Switch(edge, activate=False))
        return [*out, Look(None, _LOOK)]

    def _indices(
        self, values: Mapping[tuple[str, str], float], edge: Interaction, but: Sequence[object] | None = None
    ) -> dict[int, float]:
        space = self.model.graph.objects[edge.child].observable
        skip = tuple(but[:2]) if but is not None else None
        return {space.index(v): x for (o, v), x in values.items() if o == edge.child and (o, v) != skip}


def _carry(
    model: GraphModel, edge: Interaction, target: Mapping[int, float], now: States, *, place_first: bool
) -> list[Task]:
    """Carrying in two parts: what is turned is turned at the place where that is wanted, not on the way."""
    space = model.graph.objects[edge.child].observable
    place = {i for i in target if (r := space.variables[i].role) is not None and r.kind == "position"}
    if not place or place == set(target):
        return [Carry(edge, target=dict(target))]
    part = {i: x for i, x in target.items() if (i in place) == place_first}
    return [CarryPart(edge, target=part, every=tuple(target)), Carry(edge, target=dict(target))]


__all__ = ["Executor", "ExecutorSettings", "Memory", "Mode"]
