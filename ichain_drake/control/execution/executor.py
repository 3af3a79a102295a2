"""Executing a plan over an interaction graph (paper appendix B): a state machine that decides once a tick.

For each step of the plan: deactivate the running interaction, activate the next, then move objects and drive variables
with the learned models under feedback. Monitors compare what is observed with what was predicted; where they differ, it
plans anew from what is observed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Literal

import numpy as np

from ichain_drake.control.execution.carried import Carried
from ichain_drake.control.execution.carrying import CarryTask
from ichain_drake.control.execution.course import RobotMotion
from ichain_drake.control.execution.detour import Blocked, Detour, places, stopped_before
from ichain_drake.control.execution.driving import Approach
from ichain_drake.control.execution.following import goes_along, strays
from ichain_drake.control.execution.keep import Keep
from ichain_drake.control.execution.laying_out import step_tasks
from ichain_drake.control.execution.memory import ExecutorSettings, Memory, Resting
from ichain_drake.control.execution.monitoring import asked, deviation, gone, undriven, unmet
from ichain_drake.control.execution.putting_right import put_right
from ichain_drake.control.execution.switching import Switch
from ichain_drake.control.execution.tasks import Answer, Failed, Look, Mode, Task, View
from ichain_drake.control.planning.experience import Contradiction, Experience
from ichain_drake.control.planning.plan import Goal, NoPlan, Plan, States
from ichain_drake.control.planning.skills import Skills
from ichain_drake.control.settings import EXECUTION
from ichain_drake.errors import UnreachableError
from ichain_drake.graph import Interaction
from ichain_drake.learning.model import InteractionModel
from ichain_drake.learning.settings import LEARNING
from ichain_drake.rules import enabled
from ichain_drake.state import FloatArray

Planner = Callable[[States, Goal, Experience], Plan | NoPlan]
"""Makes a plan from measured states, with what the execution has shown so far."""

_UNFORESEEN = ("activation", "chain", "reach")
"""Causes of failure that a classifier should have foreseen: the interaction did not begin, or the way was blocked."""


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
        model: InteractionModel,
        skills: Skills,
        planner: Planner,
        goal: Goal,
        settings: ExecutorSettings | None = None,
        motion: RobotMotion | None = None,
    ) -> None:
        self.model, self.skills, self.planner, self.goal = model, skills, planner, goal
        self.settings = settings or ExecutorSettings()
        self.motion = motion
        graph = model.graph
        self._views = {robot: model if robot == graph.root else model.acting(robot) for robot in graph.roots}

    def start(self, command: FloatArray) -> Memory:
        """A fresh memory.

        Args:
            command: where the robot is, shape (n_root,); of several robots, one after the other.
        """
        graph = self.model.graph
        each = {n: Resting(np.array(c)) for n, c in graph.split_command(command).items()}
        first = each.pop(graph.root)
        return Memory(first.command, tasks=[Look(None, LEARNING.look)], robot=graph.root, resting=each)

    def decide(self, memory: Memory, measured: States, valid: Mapping[str, bool]) -> FloatArray:
        """One tick.

        Args:
            memory: of this execution; changed.
            measured: states, shape (n_variables,) each.
            valid: whether each sensor is valid. If one is not, the last command is held.

        Returns:
            The robot's command, shape (n_root,); of several robots, one after the other.
        """
        command = self._decide(memory, measured, valid)
        resting = {name: other.command for name, other in memory.resting.items()}
        return command if not resting else self.model.graph.join_command({**resting, memory.robot: command})

    def _decide(  # noqa: PLR0911 - one return an outcome
        self, memory: Memory, measured: States, valid: Mapping[str, bool]
    ) -> FloatArray:
        """The command of the robot that acts, shape (n_root,)."""
        if memory.stopped:
            return memory.command
        memory.tick += 1
        if not all(valid.values()):
            memory.mode = Mode.BLIND
            return memory.command
        reading = self._sense(memory, measured)
        self._watch(memory)
        stopped = self._stopped(memory)
        if memory.tick > self.settings.ticks:
            return self._stop(memory, "time", f"not done after {self.settings.ticks} control steps")
        away = gone(self.model, reading)
        if away:
            return self._stop(memory, "gone", away)
        self._watch_kept(memory)
        if memory.stopped:
            return memory.command
        for _ in range(100):  # tasks that need no time
            if not memory.tasks:
                self._next(memory)
                if memory.stopped:
                    return memory.command
                continue
            task = memory.tasks[0]
            memory.mode = task.mode
            answer = self._act(memory, task, stopped=stopped)
            stopped = False
            if isinstance(answer, Failed):
                self._failed(memory, answer)
                if memory.stopped:
                    return memory.command
            elif isinstance(answer, str):
                memory.tasks.pop(0)
            else:
                space = self.model.graph.objects[memory.robot].observable
                memory.command = space.clip(answer)
                return memory.command
        return self._stop(memory, "loop", "its tasks ended at once over and over again")

    def _sense(self, memory: Memory, measured: States) -> dict[str, FloatArray]:
        """Keep a reading, and what it tells of the noise of readings."""
        reading = {n: np.array(v, dtype=float) for n, v in measured.items()}
        if memory.readings:
            memory.noise = memory.noise.seen(self.model, memory.readings[-1], reading)
        if memory.model is None or memory.tick % EXECUTION.readings == 0:
            memory.model = memory.noise.in_force(self._own(memory))
        memory.readings = [*memory.readings[1 - EXECUTION.readings :], reading]
        return reading

    def _model(self, memory: Memory) -> InteractionModel:
        """The learned graph with the noise that readings have in this run, as the robot that acts sees it."""
        return memory.model or self._own(memory)

    def _own(self, memory: Memory) -> InteractionModel:
        """The learned graph as the robot that acts sees it."""
        return self._views.get(memory.robot, self.model)

    def _turn_to(self, memory: Memory, robot: str) -> None:
        """From now on another robot acts; the one that did rests where it is, with what it holds."""
        if robot in memory.resting:
            rests = Resting(memory.command, memory.carried, memory.blocked)
            takes = memory.resting[robot]
            others = {n: r for n, r in memory.resting.items() if n != robot}
            memory.resting = {**others, memory.robot: rests}
            memory.robot, memory.command = robot, takes.command
            memory.carried, memory.blocked = takes.carried, takes.blocked
            memory.model = memory.noise.in_force(self._own(memory))

    def _watch_kept(self, memory: Memory) -> None:
        """See whether what resting robots keep hold of is still held; else plan anew."""
        if not self.settings.monitors or memory.giving_up is not None:
            return
        view = self._view(memory)
        for edge in memory.kept:
            if edge.parent != memory.robot and not view.is_active(edge, LEARNING.ticks):
                memory.kept = tuple(e for e in memory.kept if e != edge)
                if memory.plan is not None:
                    text = f"{edge.name} became inactive while {edge.parent} kept hold of {edge.child}"
                    self._failed(memory, Failed(edge, "kept", text))
                return

    def _watch(self, memory: Memory) -> None:
        """See whether what the robot holds goes along with it, and what else is no longer where it was."""
        carried = memory.carried
        if self.settings.monitors:
            memory.places = memory.places.seen(self._model(memory), self._view(memory).averaged(), carried.held)
        if carried.held is not None and self.settings.monitors:
            edge = Interaction(memory.robot, carried.held)
            seen = (self._model(memory), edge, memory.readings, carried.ticks + 1)
            memory.carried = carried.watched(False if strays(*seen) else goes_along(*seen))

    def _stopped(self, memory: Memory) -> bool:
        """Whether the robot is stopped on its way: then it goes on from where it is, around that place.

        Where its ways are laid out by whoever knows what stands there, nothing stops it but what it is to push.
        """
        watched = self.motion is None and self.settings.monitors and enabled("detour")
        if not watched or not memory.tasks or not memory.tasks[0].travels:
            return False
        further = stopped_before(self._model(memory), memory.readings, memory.command)
        if further is None:
            return False
        space, here = self.model.graph.objects[memory.robot].observable, memory.readings[-1][memory.robot]
        known = memory.blocked or Blocked()
        memory.blocked = known.met(
            further, memory.carried.held or "", self.model.step_limit[memory.robot][places(space)]
        )
        memory.command = np.where(space.jump_mask, memory.command, here)
        return True

    def _view(self, memory: Memory) -> View:
        motion, blocked = self.motion, memory.blocked
        if motion is None and blocked is not None and blocked.held == (memory.carried.held or ""):
            space = self.model.graph.objects[memory.robot].observable
            motion = Detour(space, self.model.step_limit[memory.robot], blocked)
        view = View(
            self._model(memory), self.skills, memory.readings, memory.command, self.settings.monitors,
            self.settings.attempts, motion, follows=memory.carried.following,
            news=0 if blocked is None else len(blocked.places), moved=memory.places.moved,
        )  # fmt: skip
        view.standing = lambda: memory.carried.where(
            view.model, view.readings[-LEARNING.look :], view.averaged(), view.command
        )
        return view

    def _act(self, memory: Memory, task: Task, *, stopped: bool) -> Answer:
        """One tick of a task; what the robot carries and where it let go of things is kept on the way."""
        if task.edge is not None:
            self._turn_to(memory, task.edge.parent)
        view, child = self._view(memory), task.edge.child if task.edge is not None else ""
        view.stopped = stopped
        if isinstance(task, CarryTask | Approach):
            memory.carried = memory.carried.taken(child, view.averaged()[child])
        try:
            answer = task.act(view)
        except UnreachableError as error:
            if task.edge is None:
                raise
            return Failed(task.edge, "reach", f"{task.edge.name}: {error}")
        memory.carried = self._kept(memory, task, child, done=isinstance(answer, str))
        return answer

    def _kept(self, memory: Memory, task: Task, child: str, *, done: bool) -> Carried:
        """What the robot holds after a tick of a task."""
        carried, seen = memory.carried, self._view(memory).averaged
        if done and task.edge is not None and isinstance(task, Keep | Switch):
            others = tuple(e for e in memory.kept if e != task.edge)
            memory.kept = (*others, task.edge) if isinstance(task, Keep) else others
        if isinstance(task, Switch) and not task.activate:
            if carried.held == child:
                return carried.let_go(memory.command)
            return carried.settled(child, seen()[child]) if done else carried
        if isinstance(task, Switch) and done and task.onward is not None and task.taken is not None:
            carried = carried.taken(child, task.taken)
        if task.followed and carried.following != child:
            carried = carried.taken(child, seen()[child]).watched(True)
        return carried

    # From step to step.

    def _next(self, memory: Memory) -> None:
        now = self._view(memory).averaged(LEARNING.look)
        if memory.giving_up is not None:
            self._last_look(memory)
            return
        if memory.plan is None:
            self._plan(memory, self._view(memory).averaged(EXECUTION.readings) if memory.looked_again else now)
            return
        if memory.step >= 0 and self.settings.monitors:
            done = memory.plan.steps[memory.step]
            off = deviation(self._model(memory), done, now)
            if off:
                self._contradicted(memory)
                if undriven(self.model, done, memory.began, now):
                    self._beware(memory, done.chain[-1])
                self._replan(memory, "deviation", off)
                return
        memory.step += 1
        if memory.step < len(memory.plan.steps):
            step, memory.began = memory.plan.steps[memory.step], now
            self._turn_to(memory, step.chain[0].parent)
            memory.tasks = step_tasks(self._own(memory), step, now, memory.carried)
            return
        missing = unmet(self._model(memory), self.goal, now)
        if not missing or not self.settings.monitors:
            memory.mode = Mode.REACHED
            memory.reason = "goal reached" if not missing else "the plan was carried out; not watched whether it worked"
            return
        self._contradicted(memory)
        self._replan(memory, "goal unmet", missing)

    def _plan(self, memory: Memory, now: States) -> None:
        goal = asked(self._model(memory), self.goal, now) if self.settings.monitors else self.goal
        found = self.planner(now, goal, replace(memory.experience, stood=memory.places.stood))
        if isinstance(found, NoPlan):
            if self.settings.monitors and not memory.looked_again:
                # One reading less noisy may be all that is missing.
                memory.looked_again, memory.tasks = True, [Look(None, EXECUTION.readings)]
                return
            memory.refused = found
            self._give_up(memory, "no plan", found.reason)
            return
        memory.looked_again = False
        memory.plan, memory.step = found, -1
        memory.plans.append(found)

    def _replan(self, memory: Memory, cause: str, text: str) -> None:
        memory.log.append((memory.tick, f"{cause}: {text}"))
        if memory.replans >= self.settings.replans:
            self._give_up(memory, cause, f"{text}; given up after {memory.replans} new plans")
            return
        memory.replans += 1
        memory.plan, memory.step = None, -1
        memory.tasks = [Look(None, LEARNING.look)]

    def _failed(self, memory: Memory, failure: Failed) -> None:
        """Put right what can be, and plan anew."""
        if memory.giving_up is not None:
            self._last_look(memory)
            return
        step = memory.plan.steps[memory.step] if memory.plan is not None and memory.step >= 0 else None
        view = self._view(memory)
        unforeseen, origin = failure.cause in _UNFORESEEN, memory.carried.origin
        if failure.cause == "reach":  # what was in the way may have been taken for wider than it is
            memory.blocked = None
        if failure.cause == "lost":
            unforeseen = memory.carried.stayed(view.model, view.averaged())
            memory.carried = memory.carried.slipped()
        no_way: Literal["", "to it", "with it"] = ""
        if failure.cause == "reach" and step is not None:
            no_way = "with it" if view.holds(step.chain[0]) else "to it"
        self._contradicted(memory, no_way)
        self._replan(memory, failure.cause, failure.text)
        if memory.giving_up is not None:
            return
        if unforeseen:
            self._beware(memory, failure.edge)
        if step is not None:
            memory.tasks = [*put_right(self._own(memory), view, step, failure, origin), *memory.tasks]

    def _beware(self, memory: Memory, edge: Interaction) -> None:
        """From now on plan for an interaction only what is like what was shown of it, if that says any more."""
        conditions = self.model.customary(edge)
        if conditions and edge not in memory.experience.cautious:
            cautious = (*memory.experience.cautious, edge)
            memory.experience = replace(memory.experience, cautious=cautious)
            memory.log.append((memory.tick, f"cautious: {edge.name} only as it was shown, by {', '.join(conditions)}"))

    def _contradicted(self, memory: Memory, no_way: Literal["", "to it", "with it"] = "") -> None:
        """What the running step, or the last, was meant to do did not come about from where it began."""
        if memory.plan is not None and memory.plan.steps and memory.began:
            step = memory.plan.steps[min(max(memory.step, 0), len(memory.plan.steps) - 1)]
            failed = (*memory.experience.contradictions, Contradiction(step, memory.began, no_way))
            memory.experience = replace(memory.experience, contradictions=failed)

    def _give_up(self, memory: Memory, cause: str, reason: str) -> None:
        """Stop, unless the goal holds once everything is let go of: what failed may not have mattered."""
        if not self.settings.monitors:
            self._stop(memory, cause, reason)
            return
        view = self._view(memory)
        # What was in use may be in effect still, whatever the classifier says of where that came to.
        begun = () if memory.plan is None or cause == "reach" else memory.plan.steps[: memory.step + 1]
        used = begun[-1].chain[0] if begun else None
        memory.giving_up = (cause, reason)
        memory.tasks = [
            Switch(e, activate=False, forced=not view.holds(e))
            for e in self.model.graph.interactions
            if self.model.graph.by_robot(e) and e in self.goal.inactive and (view.holds(e) or e == used)
        ]
        if memory.tasks or not memory.looked_again:
            memory.tasks.append(Look(None, EXECUTION.readings))

    def _last_look(self, memory: Memory) -> None:
        assert memory.giving_up is not None
        many = EXECUTION.readings
        if unmet(self._model(memory), self.goal, self._view(memory).averaged(many), many):
            self._stop(memory, *memory.giving_up)
        else:
            memory.mode, memory.reason, memory.tasks = Mode.REACHED, "goal reached", []
            memory.log.append((memory.tick, f"{memory.giving_up[0]}: the goal holds all the same"))

    def _stop(self, memory: Memory, cause: str, reason: str) -> FloatArray:
        memory.mode, memory.cause, memory.reason = Mode.STOPPED, cause, reason
        memory.tasks = []
        return memory.command


__all__ = ["Executor", "ExecutorSettings", "Memory", "Mode"]
