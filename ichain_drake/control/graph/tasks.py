"""What an execution consists of, tick by tick: switching an interaction, carrying an object, driving a variable.

Each task keeps its own memory and answers each tick with a robot command, with `DONE`, or with why it failed.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np

from ichain_drake.control.graph.model import GraphModel
from ichain_drake.control.graph.plan import PlanStep, States
from ichain_drake.control.graph.skills import Skills
from ichain_drake.control.graph.travel import corners, jumping, step_towards
from ichain_drake.graph import Interaction
from ichain_drake.learning.interaction import invert
from ichain_drake.state import FloatArray

DONE = "done"
_CORRECTED = 5  # ticks after which a carried object is looked at anew


class Mode(IntEnum):
    """What the controller is at, as its port `mode` says it."""

    LOOK = 0
    DEACTIVATE = 1
    ACTIVATE = 2
    CARRY = 3
    DRIVE = 4
    REACHED = 5
    STOPPED = 6
    BLIND = 7


@dataclass(frozen=True)
class Failed:
    """Why a task can't go on.

    Attributes:
        edge: the interaction concerned.
        cause: one of a few words, for statistics.
        text: in words.
    """

    edge: Interaction
    cause: str
    text: str


Answer = FloatArray | Failed | str


@dataclass(eq=False)
class View:
    """What tasks see in a tick.

    Attributes:
        model: the learned graph.
        skills: of the robot's interactions.
        vias: robot states in which nothing is switched.
        readings: measured states of the last ticks, the newest last.
        command: the last command, shape (n_root,).
        monitors: whether to watch.
        attempts: for a switching.
    """

    model: GraphModel
    skills: Skills
    vias: list[FloatArray]
    readings: list[dict[str, FloatArray]]
    command: FloatArray
    monitors: bool = True
    attempts: int = 4

    def averaged(self, ticks: int = 3) -> dict[str, FloatArray]:
        """Measured states averaged over the last ticks; whole numbers by their median, the robot's is its command."""
        last = self.readings[-ticks:]
        out = {}
        for name in self.model.graph.objects:
            space = self.model.graph.objects[name].observable
            values = np.array([r[name] for r in last])
            mean = values[-1] + np.mean([space.difference(v, values[-1]) for v in values], axis=0)
            mean = np.where(jumping(space), np.round(np.median(values, axis=0)), mean)
            out[name] = space.clip(np.where(space.angle_mask, (mean + np.pi) % (2 * np.pi) - np.pi, mean))
        out[self.model.graph.root] = self.command.copy()
        return out

    def is_active(self, edge: Interaction, ticks: int = 2) -> bool:
        """Whether the classifier says active, by the mean of its decisions on the last readings."""
        return self.decision(edge, ticks) >= 0.0

    def decision(self, edge: Interaction, ticks: int = 2) -> float:
        """Mean decision value of the last readings; each by itself, since the states may be moving."""
        last = self.readings[-ticks:]
        return float(np.mean(self.model.decide(edge, {n: np.array([r[n] for r in last]) for n in last[0]})))

    def towards(self, goal: FloatArray) -> tuple[FloatArray, bool]:
        """See `step_towards`."""
        root = self.model.graph.root
        return step_towards(self.model.graph.objects[root].observable, self.command, goal, self.model.step_limit[root])


@dataclass(eq=False)
class Task:
    """Base of tasks; `edge` is the interaction they are about."""

    edge: Interaction | None

    mode = Mode.LOOK

    def act(self, view: View) -> Answer:
        """One tick."""
        raise NotImplementedError


@dataclass(eq=False)
class Look(Task):
    """Stay, so that readings can be averaged."""

    ticks: int = 3

    def act(self, view: View) -> Answer:
        """See `Task`."""
        if self.ticks <= 0:
            return DONE
        self.ticks -= 1
        return view.command.copy()


@dataclass(eq=False)
class Switch(Task):
    """Activate or deactivate an interaction of the robot by a skill; retried with other events."""

    activate: bool = True
    attempt: int = 0
    path: list[FloatArray] | None = None
    wait: int = 0
    retreating: bool = False
    forced: bool = False

    @property
    def mode(self) -> Mode:  # type: ignore[override]
        """See `Mode`."""
        return Mode.ACTIVATE if self.activate and not self.retreating else Mode.DEACTIVATE

    def act(self, view: View) -> Answer:
        """See `Task`."""
        assert self.edge is not None
        if self.path is None:
            if not self.forced and view.is_active(self.edge) == self.activate:
                return DONE
            self.path = self._lay(view, self.activate)
        if self.path:
            command, there = view.towards(self.path[0])
            if there:
                self.path.pop(0)
            self.wait = 2
            return command
        if self.wait:
            self.wait -= 1
            if not (self.wait == 0 and not self.retreating):
                return view.command.copy()
        if self.retreating:
            self.retreating, self.path = False, self._lay(view, self.activate)
            return view.command.copy()
        if view.is_active(self.edge) == self.activate or (self.forced and not view.monitors):
            return DONE
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

    def _lay(self, view: View, activate: bool) -> list[FloatArray]:
        assert self.edge is not None
        states = view.averaged()
        path = view.skills.path(view.model, self.edge, activate, states, self.attempt)
        if not activate:
            return list(path)
        return [*corners(view.model, states, path[0], view.vias), *path[1:]]


@dataclass(eq=False)
class Carry(Task):
    """Bring variables of an object that follows the robot to values, by the learned inverse model under feedback."""

    target: Mapping[int, float] = field(default_factory=dict)
    ticks: int = 0
    still: int = 0
    lost: int = 0
    best: float = np.inf
    since: int = 0
    looked: bool = False
    ahead: FloatArray | None = None

    mode = Mode.CARRY

    def act(self, view: View) -> Answer:
        """See `Task`."""
        assert self.edge is not None
        model, child = view.model, self.edge.child
        space = model.graph.objects[child].observable
        index = np.array(sorted(self.target), dtype=np.intp)
        goal = np.array([self.target[int(i)] for i in index])
        limit = np.maximum(model.step_limit[child][index], 1e-9)
        tolerance = np.maximum(3.0 * model.noise[child][index], 0.02 * limit)
        self.ticks += 1
        if view.monitors:
            self.lost = 0 if view.is_active(self.edge) else self.lost + 1
            if self.lost > 3:
                return Failed(self.edge, "lost", f"{self.edge.name} became inactive while {child} was carried")
        if self.still:  # near: look for some ticks before correcting
            self.still -= 1
            if self.still:
                return view.command.copy()
            now = view.averaged(3)
        else:
            now = view.averaged(1)
        error = self._error(space, goal, now[child], index)
        size = float(np.max(np.abs(error) / tolerance))
        if size < self.best - 0.2:
            self.best, self.since = size, self.ticks
        averaged = self.still == 0 and self.looked
        if size <= 1.0 and averaged:
            return DONE
        if self.ticks - self.since > 24:
            if size <= 3.0 or not view.monitors:
                return DONE
            worst = int(index[np.argmax(np.abs(error) / tolerance)])
            return Failed(
                self.edge, "carry",
                f"{self.edge.name}: {child}.{space.names[worst]} stayed {np.abs(error).max():.3g} "
                f"{space.variables[worst].unit} off",
            )  # fmt: skip
        # The whole way is inverted, then gone in steps; what is seen on the way corrects it now and then.
        if self.ahead is None or self.looked or self.ticks % _CORRECTED == 0:
            wanted = np.full(len(space), np.nan)
            wanted[index] = error
            self.ahead = self._inverse(view, now, wanted)
        command, near = view.towards(self.ahead)
        self.looked = near
        self.still = 3 if near else 0
        return command

    def _error(self, space: object, goal: FloatArray, state: FloatArray, index: np.ndarray) -> FloatArray:
        full = np.array(state, dtype=float)
        full[index] = goal
        return space.difference(full, state)[index]  # type: ignore[attr-defined]

    def _inverse(self, view: View, now: States, wanted: FloatArray) -> FloatArray:
        assert self.edge is not None
        answers = invert(view.model, self.edge.child, wanted, now, one_tick=False)  # type: ignore[arg-type]
        found = next((a for a in answers if a.edge == self.edge), None)
        command = view.command.copy()
        if found is not None:
            space = view.model.graph.objects[view.model.graph.root].observable
            for i in found.variables:
                if not jumping(space)[i]:
                    command[i] = found.parent[i]
        return command


@dataclass(eq=False)
class Drive(Task):
    """Hold the robot (or what it carries) while a chain of interactions drives a variable, until it is where it should be."""

    step: PlanStep | None = None
    goal: FloatArray | None = None
    history: list[FloatArray] = field(default_factory=list)
    inactive: list[tuple[bool, ...]] = field(default_factory=list)
    arrived: bool = False
    pushed: bool = False

    mode = Mode.DRIVE

    def act(self, view: View) -> Answer:
        """See `Task`."""
        step = self.step
        assert step is not None
        assert step.until is not None
        if not self.arrived and self.goal is not None:
            command, self.arrived = view.towards(self.goal)
            return command
        model, chain = view.model, step.chain
        target, name, direction, value = step.until
        space = model.graph.objects[target].observable
        i = space.index(name)
        self.history.append(view.readings[-1][target].copy())
        now = view.averaged(2)
        self.inactive.append(tuple(not view.is_active(e) for e in chain))
        if view.monitors:
            recent = np.array(self.inactive[-5:])
            if len(recent) == 5 and recent[:, 0].sum() >= 4:
                return Failed(chain[0], "lost", f"{chain[0].name} became inactive while it drove {target}.{name}")
            if len(self.inactive) in (6, 7) and (recent.mean(axis=0) >= 0.8).any():
                edge = chain[int(np.argmax(recent.mean(axis=0)))]
                if not self._moves(model, i, direction):
                    if self._further(view):
                        return view.command.copy()
                    return Failed(edge, "chain", f"{edge.name} is not active, so that {target}.{name} is not driven")
        if self._over(view, i, direction, value):
            return DONE
        if len(self.history) > 2 * step.ticks + 40:
            if not view.monitors:
                return DONE
            return Failed(chain[-1], "drive", f"{target}.{name} is at {now[target][i]:.3g}, not yet at {value:.3g}")
        return view.command.copy()

    def _further(self, view: View) -> bool:
        """Where the first object does not follow as demonstrated, go to where it followed most; whether there is more.

        It is looked for among the demonstrated states in which the second interaction was active: a button that needs
        more force, say, is pressed as far as a person ever pressed it.
        """
        step, model = self.step, view.model
        assert step is not None
        if self.pushed or self.goal is None or len(step.chain) == 1:
            return False
        edge, samples = step.chain[0], model.edges[step.chain[1]].examples.active
        on = model.decide(edge, samples) >= 0.0
        driven = sorted({f.variable for f in model.edges[edge].effects})
        if not on.any() or not driven:
            return False
        values = samples[edge.child][on][:, driven]
        toward = np.sign(np.median(values, axis=0) - view.averaged()[edge.child][driven])
        width = np.maximum(model.high[edge.child] - model.low[edge.child], 1e-9)[driven]
        score = (toward * values / width).sum(axis=1)
        space = model.graph.objects[edge.parent].observable
        root = samples[edge.parent][on][score >= score.max() - 0.01]
        most = self.goal + np.mean(space.difference(root, self.goal), axis=0)
        self.goal = np.where(jumping(space), self.goal, most)
        self.pushed, self.arrived, self.history, self.inactive = True, False, [], []
        return True

    def _moves(self, model: GraphModel, i: int, direction: int) -> bool:
        assert self.step is not None
        noise = model.noise[self.step.chain[-1].child][i]
        values = np.array(self.history)[:, i]
        half = len(values) // 2
        return bool(direction * (values[half:].mean() - values[:half].mean()) > 2.0 * noise)

    def _over(self, view: View, i: int, direction: int, value: float) -> bool:
        """All variables that the drive should change are where they should be, or have stopped changing."""
        step, model = self.step, view.model
        assert step is not None
        target = step.chain[-1].child
        noise, width = model.noise[target], model.high[target] - model.low[target]
        seen = np.array(self.history)
        start, now = seen[:2].mean(axis=0), seen[-3:].mean(axis=0)
        if len(seen) < 4:
            return False
        beyond = direction * (now[i] - value)
        if beyond > max(3.0 * noise[i], 0.03 * abs(value - start[i])):
            return True  # whatever the others do
        wanted = step.predicted[target].copy()
        wanted[i] = value
        kinds = model.passive[target].variables
        for k in range(seen.shape[1]):
            change = wanted[k] - start[k]
            if k != i and (kinds[k].kind != "hold" or abs(change) < max(5 * noise[k], 0.05 * width[k])):
                continue
            sign = direction if k == i else np.sign(change)
            slack = max(1.2 * noise[k], 0.005 * width[k]) if k == i else 0.1 * abs(change)
            if sign * (now[k] - wanted[k]) >= -slack:
                continue
            if not self._stalled(seen[:, k], float(noise[k]), sign, abs(change)):
                return False
        return True

    def _stalled(self, values: FloatArray, noise: float, sign: float, change: float) -> bool:
        """Whether a variable has stopped: compared over windows as long as its noise asks for."""
        assert self.step is not None
        rate = max(change / max(self.step.ticks, 1), 1e-9)
        w = int(np.clip(np.ceil((6.0 * noise / rate) ** (2.0 / 3.0)), 6, 40))
        if len(values) < 2 * w + 2:
            return False
        return bool(sign * (values[-w:].mean() - values[-2 * w : -w].mean()) < 0.3 * rate * w)
