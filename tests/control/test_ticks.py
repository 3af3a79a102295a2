"""Systems that decide once a tick: when they are asked, and what they are told."""

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, State

from ichain_drake.control.ticks import TickSystem
from ichain_drake.timing import FRAME


class Remembers(TickSystem):
    """Keeps the last tick and counts its decisions, all in the context."""

    def __init__(self) -> None:
        super().__init__("remembers")
        self.kept = self.DeclareDiscreteState(np.array([-1.0, 0.0]))
        self.DeclareStateOutputPort("kept", self.kept)

    def decide(self, context: Context, state: State, tick: int) -> None:
        count = context.get_discrete_state(self.kept).value()[1]
        state.get_mutable_discrete_state().set_value(self.kept, [tick, count + 1])


def test_it_decides_on_each_tenth_frame_and_is_told_the_tick() -> None:
    system = Remembers()
    simulator = Simulator(system)
    assert system.get_name() == "remembers"
    simulator.Initialize()
    for frame in range(1, 305):
        simulator.AdvanceTo(frame * FRAME)
        tick = (frame - 1) // 10  # updates of an instant are still to come when it is reached
        assert system.GetOutputPort("kept").Eval(simulator.get_context()).tolist() == [tick, tick + 1]


def test_it_is_asked_on_every_second_frame_alone() -> None:
    """A call into Python costs, whatever it finds."""
    asked = []

    class Asked(Remembers):
        def _on_event(self, context: Context, state: State) -> None:
            asked.append(context.get_time())
            super()._on_event(context, state)

    Simulator(Asked()).AdvanceTo(99.5 * FRAME)
    assert asked == [frame * FRAME for frame in range(0, 100, 2)]


def test_its_count_is_in_the_context() -> None:
    system = Remembers()
    simulator = Simulator(system)
    simulator.AdvanceTo(15 * FRAME)
    resumed = Simulator(system, simulator.get_context().Clone())
    for run in (simulator, resumed):
        run.AdvanceTo(45 * FRAME)
    a, b = (system.GetOutputPort("kept").Eval(run.get_context()) for run in (simulator, resumed))
    assert a.tolist() == b.tolist() == [4.0, 5.0]
