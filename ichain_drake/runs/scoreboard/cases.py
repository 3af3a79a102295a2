"""Which rows the scoreboard has, and how many trials of each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase

from ichain_drake.errors import InputError
from ichain_drake.robot import Physics
from ichain_drake.runs.goals.run import own_goal
from ichain_drake.runs.goals.variants import CASES, NOISE
from ichain_drake.scenarios.base import READING_NOISE, PathScenario, Scenario
from ichain_drake.scenarios.graph_scenario import GraphScenario
from ichain_drake.systems import SCENARIOS
from ichain_drake.systems.own import own_scenario

GOAL, NONE, NOISY, READING = "goal", "none", "noise", "reading"
PHYSICS: tuple[Physics, ...] = ("ideal", "arm", "contact")
FIRST_SEED = 98_010
"""Of all trials, unless another is asked for; the next whole board begins elsewhere once failures on these seeds have
led to fixes."""


@dataclass(frozen=True)
class Budget:
    """How many trials a row has.

    Attributes:
        goals: of a row of a system with a goal, by physics.
        paths: of a row of a system with paths, by physics.
        faults: of a goal's row in which something goes wrong, by physics.
        noisy_paths: of a path's row with more noise, by physics.
        read_paths: of a path's row with a vehicle that is read with noise, by physics.
        oracle: of how many trials of a path's row without faults the oracle follows too, by physics.
        only: names of the rows, as patterns; empty for all.
    """

    goals: dict[Physics, int]
    paths: dict[Physics, int]
    faults: dict[Physics, int]
    noisy_paths: dict[Physics, int]
    read_paths: dict[Physics, int]
    oracle: dict[Physics, int]
    only: tuple[str, ...] = ()


SLOW_ORACLES = ("ship",)
"""Systems whose oracle takes minutes for one path: it does not follow here; its figures are on the system's page."""

WHOLE = Budget(
    goals={"ideal": 20, "arm": 5, "contact": 8},
    paths={"ideal": 20, "arm": 3, "contact": 5},
    faults={"ideal": 20, "arm": 3, "contact": 5},
    noisy_paths={"ideal": 10, "arm": 0, "contact": 3},
    read_paths={"ideal": 10, "arm": 0, "contact": 0},
    oracle={"ideal": 5, "arm": 0, "contact": 0},
)
QUICK = Budget(
    goals={"ideal": 3, "arm": 0, "contact": 1},
    paths={"ideal": 2, "arm": 0, "contact": 1},
    faults={"ideal": 2, "arm": 0, "contact": 0},
    noisy_paths={"ideal": 0, "arm": 0, "contact": 0},
    read_paths={"ideal": 0, "arm": 0, "contact": 0},
    oracle={"ideal": 0, "arm": 0, "contact": 0},
    only=("*/ideal/*", "car_game/*/contact/none", "water_dispenser/*/contact/none"),
)


@dataclass(frozen=True)
class Case:
    """One row of the scoreboard.

    Attributes:
        system: its name.
        kind: its class.
        task: `goal`, or the name of a path.
        physics: of the world.
        fault: `none`, a fault of the system, `noise`: `NOISE` times as much in the run as in the demonstrations, or
            `reading`: a vehicle that is read with the noise that it declares, in the demonstrations, too.
        settings: of the world that has the fault.
        taught: settings of the world of the demonstrations.
        trials: how many.
        oracle: in how many of them the oracle follows too.
        without: rule that is switched off in the run; empty for none.
    """

    system: str
    kind: type[Scenario]
    task: str
    physics: Physics
    fault: str
    settings: tuple[str, ...]
    trials: int
    oracle: int = 0
    without: str = ""
    taught: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """`system/task/physics/fault`."""
        return f"{self.system}/{self.task}/{self.physics}/{self.fault}"

    def trial(self, seed: int) -> str:
        """Name of one trial."""
        return f"{self.name}/{f'without {self.without}/' if self.without else ''}seed {seed}"


def all_cases(
    budget: Budget, also: Sequence[str] = (), only: Sequence[str] = (), trials: int | None = None
) -> tuple[list[Case], dict[str, str]]:
    """The rows, in the order in which they are printed.

    Args:
        budget: how many trials.
        also: files or modules with systems of the user's own.
        only: patterns of which a row's name must match one; empty for all.
        trials: of every row, in place of the budget's.

    Returns:
        The rows, and why a physics or fault of a system is left out, by `system/physics/fault`.

    Raises:
        InputError: if no row is left, or a system of the user's own can't be loaded or has a name that is taken.
    """
    kinds = dict(SCENARIOS)
    for name in also:
        kind = own_scenario(name)
        if kind.name in kinds and kinds[kind.name] is not kind:
            raise InputError(f"--also {name}: there is a system {kind.name!r} already; rename yours")
        kinds[kind.name] = kind
    cases: list[Case] = []
    skipped: dict[str, str] = {}
    for name, kind in kinds.items():
        for physics in PHYSICS:
            cases += _cases(name, kind, physics, budget, trials, skipped)
    chosen = [
        c for c in cases
        if all(any(fnmatchcase(c.name, p) for p in patterns) for patterns in (only, budget.only) if patterns)
    ]  # fmt: skip
    if not chosen:
        example = cases[0].name if cases else "system/task/physics/fault"
        raise InputError(f"--only {' '.join(only)}: no row is called so; rows are named as {example}")
    return chosen, skipped


def _cases(
    name: str, kind: type[Scenario], physics: Physics, budget: Budget, trials: int | None, skipped: dict[str, str]
) -> list[Case]:
    """The rows of a system in one physics; what it refuses is noted with its reason."""
    if physics != "ideal" and issubclass(kind, GraphScenario) and kind.bodies is GraphScenario.bodies:
        return []  # nothing that an arm could touch
    try:
        scenario = kind((), physics, FIRST_SEED)
    except InputError as error:
        skipped[f"{name}/{physics}"] = str(error)
        return []
    noise = (f"noise.scale={NOISE * scenario.config.noise.scale:g}",)
    faults = {f: s for f, s in CASES.items() if f in scenario.faults} | {NOISY: noise}
    follows = isinstance(scenario, PathScenario)
    if follows and READING_NOISE in scenario.features:
        faults |= {READING: ("noise.vehicle=1",)}
    tasks = list(scenario.reference_paths()) if isinstance(scenario, PathScenario) else [GOAL]
    if not follows and not own_goal(scenario):  # type: ignore[arg-type] # it has what a goal needs
        skipped[f"{name}/{physics}"] = "it has no goal of its own"
        return []
    out = []
    for task in tasks:
        for fault, settings in faults.items():
            if follows:
                of_fault = {NONE: budget.paths, READING: budget.read_paths}
                count = of_fault.get(fault, budget.noisy_paths)[physics]
            else:
                count = (budget.goals if fault == NONE else budget.faults)[physics]
            if not count:
                continue
            try:
                kind(settings, physics, FIRST_SEED)
            except InputError as error:
                skipped[f"{name}/{physics}/{fault}"] = str(error)
                continue
            has_oracle = isinstance(scenario, PathScenario) and not scenario.no_oracle and name not in SLOW_ORACLES
            oracle = budget.oracle[physics] if has_oracle and fault == NONE else 0
            taught = settings if fault == READING else ()
            out.append(Case(name, kind, task, physics, fault, settings, trials or count, oracle, taught=taught))
    return out
