"""What an execution remembers from tick to tick, and its settings."""

from __future__ import annotations

import copy
from dataclasses import dataclass, field, replace

from ichain_drake.control.execution.carried import Carried, Places
from ichain_drake.control.execution.detour import Blocked
from ichain_drake.control.execution.sensing import SensorNoise
from ichain_drake.control.execution.tasks import Mode, Task
from ichain_drake.control.planning.experience import Experience
from ichain_drake.control.planning.plan import NoPlan, Plan, States
from ichain_drake.graph import Interaction
from ichain_drake.learning.model import InteractionModel
from ichain_drake.state import FloatArray


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


@dataclass(frozen=True)
class Resting:
    """A robot that stays where it is while another one acts.

    Attributes:
        command: its last command, shape (n_root,).
        carried: what it holds, and where it let go of what it held.
        blocked: where it was stopped on its way; None where it never was.
    """

    command: FloatArray
    carried: Carried = field(default_factory=Carried)
    blocked: Blocked | None = None


@dataclass
class Memory:
    """Everything that an execution remembers from tick to tick.

    Attributes:
        command: last command of the robot that acts, shape (n_root,).
        tick: decisions so far.
        readings: valid measurements of the last ticks.
        tasks: what is to do, in order.
        plan: the running plan.
        step: index of its running step; -1 before the first.
        plans: every plan so far.
        refused: why there was none in the end.
        replans: plans that were made anew.
        mode: see `Mode`.
        reason: why it stopped; empty while it runs.
        cause: of the failure in a word; empty if there is none.
        looked_again: whether it looks longer since no plan was found.
        log: (tick, text) of everything that did not go as planned.
        carried: what the robot holds, and where it let go of what it held.
        places: where the rest was seen to stand.
        experience: what new plans are told: what was contradicted, and what they are to be cautious with.
        began: measured states in which the running step began.
        noise: what readings tell of their noise.
        model: the learned graph with that noise; None before the first reading.
        blocked: where the robot was stopped on its way; None where it never was.
        giving_up: cause and reason for which it will stop, unless a last look finds that the goal holds.
        robot: the one that acts.
        resting: the others, by name.
        kept: interactions by which robots keep hold of something while another one acts.
    """

    command: FloatArray
    tick: int = 0
    readings: list[dict[str, FloatArray]] = field(default_factory=list)
    tasks: list[Task] = field(default_factory=list)
    plan: Plan | None = None
    step: int = -1
    plans: list[Plan] = field(default_factory=list)
    refused: NoPlan | None = None
    replans: int = 0
    mode: Mode = Mode.LOOK
    reason: str = ""
    cause: str = ""
    looked_again: bool = False
    log: list[tuple[int, str]] = field(default_factory=list)
    carried: Carried = field(default_factory=Carried)
    places: Places = field(default_factory=Places)
    experience: Experience = field(default_factory=Experience)
    began: States = field(default_factory=dict)
    noise: SensorNoise = field(default_factory=SensorNoise)
    model: InteractionModel | None = None
    blocked: Blocked | None = None
    giving_up: tuple[str, str] | None = None
    robot: str = ""
    resting: dict[str, Resting] = field(default_factory=dict)
    kept: tuple[Interaction, ...] = ()

    def own(self) -> Memory:
        """A copy that a decision may change."""
        tasks = copy.deepcopy(self.tasks)
        return replace(self, tasks=tasks, log=list(self.log), plans=list(self.plans))

    @property
    def stopped(self) -> bool:
        """Whether it has ended, one way or the other."""
        return self.mode in (Mode.REACHED, Mode.STOPPED)

    @property
    def edge(self) -> Interaction | None:
        """The interaction that the running task is about."""
        return self.tasks[0].edge if self.tasks else None
