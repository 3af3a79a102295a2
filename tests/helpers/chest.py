"""A third graph: a hand, a chest with a lid that slides, and a ball. Nothing gets in or out but through an open lid.

The pieces can't show that: no hand is ever at the ball behind the shut lid, since the lid would be in its way.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pandas as pd

from ichain_drake.control.execution.executor import Executor, ExecutorSettings, Memory
from ichain_drake.control.planning.goals import parse_goal
from ichain_drake.control.planning.planner import GraphPlanner
from ichain_drake.control.planning.skills import Skills
from ichain_drake.demonstrations import Demonstration
from ichain_drake.errors import UnreachableError
from ichain_drake.graph import InteractionGraph
from ichain_drake.learning import InteractionModel, InteractionSpec, learn_interactions
from ichain_drake.learning.chain.link import EstimatorSpec
from ichain_drake.motion_query import MotionQuery
from ichain_drake.state import FloatArray, Role, StateSpace, Variable
from ichain_drake.timing import TICK

REACH = 0.03
SHUT, OPEN = np.array([0.5, 0.0, 0.2]), np.array([0.5, 0.3, 0.2])  # places of the lid's handle
LEAST_OPEN = 0.2
INSIDE = np.array([0.7, 0.0, 0.1])
DOORWAY = 0.55  # x of the chest's front

_PLACE = tuple(Variable(a, "m", role=Role("position", "robot", a)) for a in "xyz")

GRAPH = InteractionGraph(
    {
        "hand": StateSpace("hand", (*_PLACE, Variable("grip", kind="binary", lower=0, upper=1))),
        "lid": StateSpace("lid", _PLACE),
        "ball": StateSpace("ball", _PLACE),
    },
    ["hand->lid", "hand->ball", "lid->ball"],
)


class Chest:
    """The truth, one tick at a time; with `firm` a shut lid refuses grasps through it."""

    def __init__(self, seed: int, *, inside: bool, lid: FloatArray = SHUT, firm: bool = True) -> None:
        self.rng, self.firm = np.random.default_rng([seed, 5]), firm
        u = self.rng.uniform
        self.ball = INSIDE + u(-0.02, 0.02, 3) if inside else np.array([u(0.25, 0.35), u(-0.2, 0.0), 0.0])
        self.lid, self.hand, self.grip, self.held = lid.copy(), np.array([0.3, u(0.0, 0.1), 0.3]), 0.0, ""
        self.rows: list[dict[str, float]] = []
        self.record()

    @property
    def shut(self) -> bool:
        return bool(self.lid[1] < LEAST_OPEN)

    def record(self) -> None:
        values: dict[str, float] = {"time": TICK * len(self.rows)}
        for name, place in (("hand", self.hand), ("lid", self.lid), ("ball", self.ball)):
            seen = place + 1e-3 * self.rng.standard_normal(3)
            values |= {f"{name}.{a}": v for a, v in zip("xyz", seen, strict=True)}
        values["hand.grip"] = self.grip
        flags = {"hand->lid": self.held == "lid", "hand->ball": self.held == "ball"}
        flags["lid->ball"] = bool(self.ball[0] > DOORWAY)
        self.rows.append(values | {k: float(v) for k, v in flags.items()})

    def tick(self, hand: FloatArray, grip: float) -> None:
        hand = np.asarray(hand, dtype=float)
        if self.held == "ball":
            self.ball = self.ball + hand - self.hand
        elif self.held == "lid":
            self.lid[1] = np.clip(self.lid[1] + hand[1] - self.hand[1], SHUT[1], OPEN[1])
        self.hand = hand
        if not grip:
            self.held = ""
        elif not self.grip:
            near = {"lid": self.lid, "ball": self.ball}
            if self.firm and self.shut and self.ball[0] > DOORWAY:
                near.pop("ball")
            self.held = next((n for n, p in near.items() if np.all(np.abs(hand - p) < REACH)), "")
        self.grip = grip
        self.record()

    def go(self, target: FloatArray, grip: float) -> None:
        target = np.asarray(target, dtype=float)
        count = max(1, int(np.ceil(np.linalg.norm(target - self.hand) / 0.04)))
        for point in np.linspace(self.hand, target, count + 1)[1:]:
            self.tick(point, grip)

    def miss(self, name: str) -> None:
        """Close beside it, in all directions."""
        for sign in (-1.0, 1.0):
            for axis in range(3):
                place = getattr(self, name) + sign * REACH * self.rng.uniform(1.1, 1.4) * np.eye(3)[axis]
                self.go(place, 0.0)
                for grip in (1.0, 1.0, 0.0):
                    self.tick(self.hand, grip)

    def move(self, name: str, target: FloatArray) -> None:
        """Take it, bring it somewhere, the ball over all else, let go and back off."""
        self.go(getattr(self, name) - [0.1, 0.0, 0.0], 0.0)
        self.go(getattr(self, name) + self.rng.uniform(-0.5, 0.5, 3) * REACH, 0.0)
        for _ in range(4):
            self.tick(self.hand, 1.0)
        off = self.hand - getattr(self, name)
        if name == "ball":
            self.go(self.hand * [1, 1, 0] + [0, 0, 0.25], 1.0)
            self.go(np.array([*(target + off)[:2], 0.25]), 1.0)
        self.go(target + off, 1.0)
        for _ in range(2):
            self.tick(self.hand, 0.0)
        self.go(self.hand - [0.1, 0.0, -0.05], 0.0)


def pieces() -> list[Demonstration]:
    out = []
    for k in range(8):
        inside = k % 2 == 0
        w = Chest(k, inside=inside, lid=SHUT if inside else OPEN)
        if inside:
            w.move("lid", OPEN)
        if k in (2, 3):
            w.miss("lid")
        if k in (0, 1, 5):
            w.miss("ball")
        table = np.array([*w.rng.uniform([0.25, -0.2], [0.35, 0.0]), 0.0])
        w.move("ball", table if inside else INSIDE + w.rng.uniform(-0.02, 0.02, 3))
        w.move("lid", SHUT)
        out.append(Demonstration(pd.DataFrame(w.rows), {}, f"piece_{k}"))
    return out


@cache
def learned() -> tuple[InteractionModel, Skills, GraphPlanner]:
    spec = InteractionSpec(
        effect_estimators=(EstimatorSpec.parse("polynomial(degree=1, clip=None)"),),
        status_estimators=(EstimatorSpec.parse("box(reach=0.15)"),),
    )
    model = learn_interactions(pieces(), GRAPH, spec)
    return model, Skills.of(model), GraphPlanner(model)


def readings(world: Chest) -> dict[str, FloatArray]:
    row = world.rows[-1]
    return {n: np.array([row[f"{n}.{v}"] for v in s.observable.names]) for n, s in GRAPH.objects.items()}


class Before:
    """A `RobotMotion` that knows the chest: straight, but for a shut lid."""

    def __init__(self, world: Chest) -> None:
        self.world = world

    def path(self, query: MotionQuery) -> FloatArray:
        now, goal = np.asarray(query.now), np.asarray(query.goal)
        if self.world.shut and goal[0] > DOORWAY:
            raise UnreachableError("the lid is in the way")
        rows = np.linspace(now, goal, max(1, int(np.ceil(np.max(np.abs(goal - now)[:3]) / 0.04))) + 1)[1:]
        rows[:-1, 3] = now[3]
        return rows


def run(world: Chest, goal: str, *, motion: bool = False, settings: ExecutorSettings | None = None) -> Memory:
    """Carry out a goal in a world until the executor stops."""
    model, skills, planner = learned()
    wanted = parse_goal([goal, "not hand->ball"], model, readings(world))
    executor = Executor(model, skills, planner.plan, wanted, settings, Before(world) if motion else None)
    memory = executor.start(readings(world)["hand"])
    while not memory.stopped:
        command = executor.decide(memory, readings(world), dict.fromkeys(GRAPH.objects, True))
        world.tick(command[:3], round(command[3]))
    return memory
