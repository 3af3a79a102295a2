"""Switching an interaction of the robot by a skill, and what tells that it worked."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ichain_drake.control.execution.course import Course
from ichain_drake.control.execution.following import goes_along
from ichain_drake.control.execution.tasks import DONE, Answer, Failed, Mode, Task, View
from ichain_drake.control.planning.holding import taken_as
from ichain_drake.control.planning.motion import Motion
from ichain_drake.control.planning.travel import jumping
from ichain_drake.control.settings import PLANNING
from ichain_drake.errors import UnreachableError
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import FloatArray


@dataclass(eq=False)
class Switch(Task):
    """Activate or deactivate an interaction of the robot by a skill; retried with other events.

    Before the robot lets go to try again, it goes on with the plan for some ticks: what then goes along with it was
    taken, whatever the classifier says of it.
    """

    activate: bool = True
    attempt: int = 0
    path: list[FloatArray] | None = None
    wait: int = 0
    retreating: bool = False
    forced: bool = False
    far: bool = False  # whether the first state of the path is still to be reached, from wherever the robot was
    moved: int = 0  # how often something was seen elsewhere when the path was laid
    pending: int = 0  # states of the path up to the one in which it lets go; -1 once what is left is laid out
    course: Course = field(default_factory=Course)
    onward: Task | None = None  # what the plan goes on with, where the child goes along
    trial: Task | None = None
    tried: int = 0  # ticks of it
    since: int = -1  # ticks since what jumps has jumped
    taken: FloatArray | None = None  # the child's state then
    motion: Motion | None = None  # that the child is taken for
    first: int = 0  # of the demonstrated events: after a failure another one is tried first

    @property
    def mode(self) -> Mode:  # type: ignore[override]
        """See `Mode`."""
        return Mode.ACTIVATE if self.activate and not self.retreating else Mode.DEACTIVATE

    @property
    def travels(self) -> bool:  # type: ignore[override]
        """See `Task`: it is, until it does as was demonstrated, which may be to push."""
        return self.far and bool(self.path)

    def act(self, view: View) -> Answer:  # noqa: PLR0911 - one return a phase
        """See `Task`."""
        assert self.edge is not None
        if self.path is None:
            if not self.forced and view.holds(self.edge) == self.activate:
                return DONE
            self.path = self._lay(view, self.activate)
        if self.far and self.path and view.moved != self.moved:  # what it goes to may be elsewhere now
            self.path = self._lay(view, self.activate)
        self._count(view)
        if self.path:
            self.wait = 2
            if self._taken(view):
                return DONE
            return self._go(view)
        if self.wait:
            self.wait -= 1
            if not (self.wait == 0 and not self.retreating):
                return view.command.copy()
        if self.retreating:
            self.retreating, self.path = False, self._lay(view, self.activate)
            return view.command.copy()
        if view.is_active(self.edge) == self.activate or (self.forced and not view.monitors):
            return DONE
        answer = self._try(view)
        if answer is not None:
            return answer
        self.attempt += 1
        if self.attempt >= (view.attempts if view.monitors else 1):
            if not view.monitors:
                return DONE
            what = "active" if self.activate else "inactive"
            value = view.decision(self.edge)
            return Failed(
                self.edge,
                "activation" if self.activate else "deactivation",
                f"{self.edge.name} did not become {what} in {self.attempt} attempts; decision value {value:.2f}",
            )
        self.retreating = self.activate
        self.path = self._lay(view, False) if self.activate else self._lay(view, self.activate)
        return view.command.copy()

    def _count(self, view: View) -> None:
        """Count the ticks in which the child may go along, and remember where it was then."""
        assert self.edge is not None
        self.since = self.since + 1 if self._switched(view) else -1
        if self.since == 0:
            self.taken = view.readings[-1][self.edge.child]

    def _try(self, view: View) -> FloatArray | str | None:
        """Go on with the plan for some ticks, to see whether the child goes along; None if it was not seen to."""
        assert self.edge is not None
        if not self.activate or not view.monitors or self.onward is None:
            return None
        if self.trial is None:
            self.trial, self.tried = copy.deepcopy(self.onward), 0
        along = goes_along(view.model, self.edge, view.readings, self.since)
        self.followed = along is True
        if self.followed:
            return DONE
        if along is None and self.tried < LEARNING.look:
            self.tried += 1
            try:
                answer = self.trial.act(view)
            except UnreachableError:
                answer = DONE
            if isinstance(answer, np.ndarray):
                return answer
        self.trial = None
        return None

    def _taken(self, view: View) -> bool:
        """What is taken goes along from here on: its ways are laid out with it, not as it was once demonstrated."""
        if (view.motion is None and self.motion is None) or not self.path:
            return False
        return self._switched(view) and view.is_active(self.edge)  # type: ignore[arg-type]

    def _switched(self, view: View) -> bool:
        """Whether an activation has done what can't be done gradually (it closed the hand, say)."""
        if not self.activate or self.retreating or self.far or self.path is None:
            return False
        jumps = jumping(view.model.graph.objects[view.model.graph.root].observable)
        return all((row[jumps] == view.command[jumps]).all() for row in self.path)

    def _go(self, view: View) -> FloatArray:
        assert self.path
        try:  # what was demonstrated is gone as it was, where it hits nothing
            self._check(view)
            command, there = view.travel(self.course, self.path[0]) if self.far else view.towards(self.path[0])
        except UnreachableError:
            if self._begins_later(view):
                return view.command.copy()
            if self.attempt + 1 >= view.attempts:
                if self._ends_sooner(view):
                    return view.command.copy()
                raise
            # Another event may begin where the robot can get to, or end where nothing is.
            self.attempt += 1
            self.path = self._lay(view, self.activate and not self.retreating)
            return view.command.copy()
        if there:
            self.path.pop(0)
            self.far, self.course = False, Course()
            self.pending -= self.pending > 0
        return command

    def _begins_later(self, view: View) -> bool:
        """Of a demonstrated approach whose beginning is out of reach, or blocked here, what is left leads there too."""
        assert self.path
        mask = jumping(view.model.graph.objects[view.model.graph.root].observable)
        later = self.far and len(self.path) > 1 and bool((self.path[0][mask] == self.path[1][mask]).all())
        if later:
            self.path.pop(0)
        return later

    def _ends_sooner(self, view: View) -> bool:
        """Of a demonstrated retreat whose end is out of reach, or blocked here, what comes before leads away, too."""
        assert self.path
        retreats = self.mode is Mode.DEACTIVATE and not self.pending and not any(self._jumps(view, self.path))
        if not retreats or len(self.path) == 1:
            return False
        self.path.pop()
        return True

    def _check(self, view: View) -> None:
        """Lay out the approach, or the retreat from where it lets go, as any other way.

        What follows once it has closed its hand does what was shown: what it holds then is not known yet.
        """
        assert self.path and self.edge is not None
        if self.far or self.pending:
            return
        jumped = self._jumps(view, self.path)
        count = jumped.index(True) + 1 if True in jumped else len(self.path)
        way = view.as_shown(self.path[:count], None if self.mode is Mode.DEACTIVATE else self.edge.child)
        self.path, self.pending = [*way, *self.path[count:]], -1

    def _set_down(self, view: View) -> FloatArray | None:
        """Where the robot lets go of what hangs clearly lower in its hand than a usual grasp has it; else None.

        That is where a usual grasp would have it: what it stands on pushes it back, as when it was shown. Let go of as
        it hangs it would tip over.
        """
        assert self.edge is not None
        model, child, command = view.model, self.edge.child, view.command.copy()
        usual, root = view.standing().get(child), model.graph.objects[self.edge.parent].observable
        places = [i for i in root.role_indices("position") if getattr(root.variables[i].role, "axis", "") == "z"]
        noise = model.noise[child][model.graph.objects[child].observable.role_indices("position")].max(initial=0.0)
        if usual is None or not (command[places] - usual[places] > PLANNING.noises * noise).any():
            return None
        command[places] = usual[places]
        return command

    def _jumps(self, view: View, path: Sequence[FloatArray]) -> list[bool]:
        """In which states of a path something is not as it is now that can't be changed gradually."""
        mask = jumping(view.model.graph.objects[view.model.graph.root].observable)
        return [bool((row[mask] != view.command[mask]).any()) for row in path]

    def _lay(self, view: View, activate: bool) -> list[FloatArray]:
        assert self.edge is not None
        states = view.averaged()
        prefer = None if self.motion is None else view.command
        if activate and self.motion is not None:
            child = states[self.edge.child]
            prefer = taken_as(view.model, self.motion, int(self.motion.grasp(child[None])[0][0]), child)
        down = None if activate or view.follows != self.edge.child else self._set_down(view)
        if down is not None:
            states[self.edge.parent] = down
        path = list(view.skills.path(view.model, self.edge, activate, states, self.attempt, prefer, self.first))
        path = path if down is None else [down, *path]
        self.far, self.course, self.moved = activate, Course(), view.moved
        jumped = [] if activate else self._jumps(view, path)
        self.pending = jumped.index(True) + 1 if True in jumped else 0
        return path
