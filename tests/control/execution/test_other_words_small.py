"""Objects and variables renamed to random words: the execution is the same in every bit."""

from dataclasses import replace

import numpy as np
import pytest
from small_job import GRAPH, QUICK, drive, executor, fresh, pieces, readings

from ichain_drake.control.execution.executor import Executor, Memory
from ichain_drake.control.execution.tasks import Mode
from ichain_drake.control.planning.goals import parse_goal
from ichain_drake.control.planning.planner import GraphPlanner
from ichain_drake.control.planning.skills import Skills
from ichain_drake.demonstrations import Demonstration, column
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning import learn_interactions
from ichain_drake.state import StateSpace

WORDS = iter(f"x{k}y" for k in np.random.default_rng(21).permutation(1000))
OBJECTS = {n: next(WORDS) for n in GRAPH.objects}
VARIABLES = {(n, v): next(WORDS) for n, s in GRAPH.objects.items() for v in s.names}


def renamed_graph() -> InteractionGraph:
    spaces = {}
    for name, space in GRAPH.objects.items():
        parts = []
        for v in space.variables:
            role = v.role if v.role is None or not v.role.of else replace(v.role, of=VARIABLES[name, v.role.of])
            parts.append(replace(v, name=VARIABLES[name, v.name], role=role))
        spaces[OBJECTS[name]] = StateSpace(next(WORDS), tuple(parts))
    return InteractionGraph(spaces, [Interaction(OBJECTS[e.parent], OBJECTS[e.child]) for e in GRAPH.interactions])


def renamed_pieces() -> list[Demonstration]:
    names = {column(o, v): column(OBJECTS[o], w) for (o, v), w in VARIABLES.items()}
    names |= {e.name: Interaction(OBJECTS[e.parent], OBJECTS[e.child]).name for e in GRAPH.interactions}
    return [Demonstration(p.table.rename(columns=names), {}, next(WORDS)) for p in pieces()]


class Renamed(Executor):
    """Reads the world under its old names."""

    def decide(self, memory: Memory, measured, valid) -> np.ndarray:  # type: ignore[no-untyped-def]
        return super().decide(
            memory, {OBJECTS[n]: v for n, v in measured.items()}, {OBJECTS[n]: v for n, v in valid.items()}
        )


@pytest.mark.parametrize(("water", "seed"), [(0.4, 77), (0.5, 78)])
def test_every_command_is_the_same(water: float, seed: int) -> None:
    graph, shown = renamed_graph(), renamed_pieces()
    model = learn_interactions(shown, graph, QUICK)
    skills, planner = Skills.of(model), GraphPlanner(model)
    world = fresh(seed)
    states = {OBJECTS[n]: v for n, v in readings(world).items()}
    wanted = f"{OBJECTS['box']}.{VARIABLES['box', 'water']} >= {water}"
    theirs: list[np.ndarray] = []
    run = Renamed(model, skills, planner.plan, parse_goal([wanted], model, states))
    memory = drive_renamed(run, world, theirs)
    ours: list[np.ndarray] = []
    plain = fresh(seed)
    same = drive(executor([f"box.water >= {water}"], plain), plain, each=lambda m: ours.append(np.array(m.command)))
    assert same.mode == Mode.REACHED, same.reason
    assert (memory.mode, memory.tick, memory.replans) == (same.mode, same.tick, same.replans)
    np.testing.assert_array_equal(theirs, ours)


def drive_renamed(run: Executor, world, commands: list[np.ndarray]) -> Memory:  # type: ignore[no-untyped-def]
    return drive(run, world, each=lambda m: commands.append(np.array(m.command)))
