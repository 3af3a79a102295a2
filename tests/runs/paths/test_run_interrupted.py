"""Ctrl-C while a world is simulated: whole ticks are kept, and nothing but the interruption is raised."""

import signal
import threading

import numpy as np
import pytest
from pydrake.systems.framework import Context, State

from ichain_drake.scenarios.joystick_demonstrations import Player
from ichain_drake.simulation.episode import EpisodeLog
from ichain_drake.simulation.interruption import deferred_interrupt
from ichain_drake.simulation.recorder import RecordingInterrupted, record, whole_frames
from ichain_drake.systems.car_game.scenario import CarGame


def test_a_frame_that_only_some_ports_have_is_dropped():
    def rows(count: int) -> np.ndarray:
        return np.arange(2.0 * count).reshape(count, 2)

    log = EpisodeLog(
        np.arange(5.0), {"a": rows(5), "b": rows(4)}, {"a": rows(5), "b": rows(5)}, {"b": rows(5)}, rows(5), rows(5),
        {"progress": rows(4)},
    )  # fmt: skip
    cut = whole_frames(log)
    parts = [cut.times, cut.command, cut.plant_positions, *cut.states.values(), *cut.measured.values()]
    parts += [*cut.active.values(), *cut.extra.values()]
    assert {len(p) for p in parts if p is not None} == {4}
    np.testing.assert_array_equal(cut.states["a"], rows(5)[:4])
    whole = EpisodeLog(np.arange(3.0), {"a": rows(3)}, {"a": rows(3)}, {}, rows(3))
    assert len(whole_frames(whole).times) == 3
    assert whole_frames(whole).plant_positions is None


def test_ctrl_c_is_held_back_once():
    with deferred_interrupt() as pressed:
        assert not pressed()
        signal.raise_signal(signal.SIGINT)
        assert pressed()
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
    with pytest.raises(KeyboardInterrupt):
        signal.raise_signal(signal.SIGINT)


def test_other_threads_and_ignored_signals_are_left_alone():
    seen = []

    def work() -> None:
        with deferred_interrupt() as pressed:
            seen.append(pressed())

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    usual = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        work()
        assert signal.getsignal(signal.SIGINT) == signal.SIG_IGN
    finally:
        signal.signal(signal.SIGINT, usual)
    assert seen == [False, False]


class PressesCtrlC(Player):
    """Plays, and presses Ctrl-C in the middle of a tick."""

    asked = 0  # on every second frame

    def _on_event(self, context: Context, state: State) -> None:
        if self.asked == 18:
            signal.raise_signal(signal.SIGINT)
        self.asked += 1
        super()._on_event(context, state)


def test_an_interrupted_recording_holds_whole_ticks():
    world = CarGame([], "ideal", 0).build_world(np.array([400.0, 300.0, 0.0, 0.0, 0.0, 0.0]), [0.0, 0.0], 0)
    player = PressesCtrlC(np.array([0.5, 0.0]), 0.04, 0.03, 50, [0])
    with pytest.raises(RecordingInterrupted) as stopped:
        record(world, player, 50, ("hand", "joystick"), "play")
    table = stopped.value.piece.table
    assert len(table) == 5  # the tick that was under way is finished
    assert table.notna().all().all()
    with pytest.raises(KeyboardInterrupt):
        signal.raise_signal(signal.SIGINT)  # as before
