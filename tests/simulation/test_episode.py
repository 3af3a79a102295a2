"""Episodes: who is wired to what, what is logged when, and where a run ends."""

from collections.abc import Iterator

import numpy as np
import pytest
from pydrake.systems.framework import Context, Diagram, LeafSystem, State, System
from pydrake.systems.primitives import Multiplexer, VectorLogSink

from ichain_drake.control.tracking.path import TimedPath
from ichain_drake.control.tracking.systems import Controller, PathController
from ichain_drake.simulation.episode import Episode, follow_path
from ichain_drake.systems.car_game.scenario import CarGame
from ichain_drake.timing import FRAME, FRAMES_PER_TICK, TICK

GAME = CarGame(physics="ideal", seed=2)
LINE = TimedPath(np.array([[300.0, 300.0], [420.0, 300.0]]), GAME.path_limits())


class Pusher:
    """A policy for the tests: holds the stick at one throttle and keeps what it is shown."""

    memory_size, lookahead = 0, 2

    def __init__(self, forward: float = 0.02) -> None:
        self.forward = forward
        self.seen: list[list[np.ndarray]] = []

    def decide(
        self, states: list[np.ndarray], wanted: np.ndarray, memory: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, list[np.ndarray]]:
        self.seen.append([s[0].copy() for s in states])
        return np.array([[0.5, self.forward]]), memory, [np.zeros_like(s) for s in states[:-1]]


def along(path: TimedPath, policy: Pusher, inputs: list[int] | None = None) -> PathController:
    spaces = {n: s.observable for n, s in GAME.graph.objects.items()}
    controller = Controller(policy, spaces, 2, np.array([0.5, 0.0]), inputs)  # type: ignore[arg-type]
    return PathController(controller, path, "car", spaces["car"], (0, 1))


class Steps(LeafSystem):
    """Commands x = 0.5 + 0.0001 k at tick k."""

    def __init__(self) -> None:
        super().__init__()
        self._command = self.DeclareDiscreteState([0.5, 0.0])
        self._frame = self.DeclareDiscreteState(1)
        self.DeclareStateOutputPort("hand_command", self._command)
        self.DeclarePeriodicUnrestrictedUpdateEvent(FRAME, 0.0, self._decide)

    def _decide(self, context: Context, state: State) -> None:
        frame = context.get_discrete_state(self._frame).value()[0]
        state.get_mutable_discrete_state().set_value(self._frame, [frame + 1])
        if frame % FRAMES_PER_TICK == 0:
            state.get_mutable_discrete_state().set_value(self._command, [0.5 + 1e-4 * (frame // 10), 0.0])


def diagrams(top: Diagram) -> Iterator[Diagram]:
    yield top
    for system in top.GetSystems():
        if isinstance(system, Diagram):
            yield from diagrams(system)


def wires(top: Diagram) -> list[tuple[str, System]]:
    """(name of the output port, system that reads it) of every connection at every level."""
    return [
        (source.get_output_port(port).get_name(), reader)
        for diagram in diagrams(top)
        for (reader, _), (source, port) in diagram.connection_map().items()
    ]


@pytest.mark.parametrize("physics", ["ideal", "contact"])
def test_nothing_but_the_log_reads_an_active_port(physics: str) -> None:
    """`active` is for labels and scoring: no controller, follower or other object is connected to it."""
    game = CarGame(physics=physics)  # type: ignore[arg-type]
    world = game.make_world(LINE, 0)
    episode = Episode(world, along(LINE, Pusher()))
    readers = [reader for port, reader in wires(episode.diagram) if port.split(".")[-1] == "active"]
    assert len(readers) == 2  # the joystick's and the car's
    assert isinstance(readers[0], Multiplexer)
    assert readers[0] is readers[1]
    joined = readers[0].get_output_port()
    behind = [
        reader
        for (reader, _), (source, port) in episode.diagram.connection_map().items()
        if source.get_output_port(port) is joined
    ]
    assert [type(reader) for reader in behind] == [VectorLogSink]


def test_controller_and_follower_read_what_was_measured() -> None:
    commander = along(LINE, Pusher())
    episode = Episode(GAME.make_world(LINE, 0), commander)
    sources = {
        commander.get_input_port(port).get_name(): source.get_output_port(out).get_name()
        for (system, port), (source, out) in episode.diagram.connection_map().items()
        if system is commander
    }
    assert sources == {**{n: f"{n}.measured" for n in GAME.graph.objects}, "car.measured": "car.measured"}
    inner = {(port, reader.get_name()) for port, reader in wires(commander)}
    assert inner == {("target", "controller")}


def test_only_an_oracle_reads_the_truth() -> None:
    world = GAME.make_world(LINE, 0)
    policy = Pusher()
    names = tuple(GAME.graph.objects)
    episode = Episode(world, along(LINE, policy, [2, 4, 6]), names)
    episode.run(1)
    assert [len(s) for s in policy.seen[0]] == [2, 4, 6]
    np.testing.assert_array_equal(policy.seen[0][2], episode.log().states["car"][0])


def test_the_controller_sees_at_a_tick_what_the_log_holds_for_it() -> None:
    world = GAME.make_world(LINE, 0)
    policy = Pusher()
    episode = Episode(world, along(LINE, policy))
    episode.run(12)
    log = episode.log()
    assert len(policy.seen) == 12
    for tick, seen in enumerate(policy.seen):
        for name, state in zip(GAME.graph.objects, seen, strict=True):
            np.testing.assert_array_equal(state, log.measured[name][10 * tick])


def test_a_row_is_logged_at_every_frame_after_any_number_of_ticks() -> None:
    """Also where k x 1/3 s and 10 k x 1/30 s differ in floating point (5, 7, 10, ... ticks)."""
    world = GAME.make_world(LINE, 0)
    episode = Episode(world, Steps())
    for tick in range(1, 41):
        episode.run(1)
        assert len(episode.log().times) == 10 * tick + 1, f"after {tick} ticks"
    np.testing.assert_allclose(episode.log().times, FRAME * np.arange(401), atol=1e-9)


def test_a_logged_command_is_the_one_in_force_before_the_instants_update() -> None:
    world = GAME.make_world(LINE, 0)
    episode = Episode(world, Steps())
    episode.run(6)
    log = episode.log()
    np.testing.assert_allclose(log.command[1::10, 0], 0.5 + 1e-4 * np.arange(6), atol=1e-12)
    np.testing.assert_allclose(log.states["hand"][10::10][:6, 0], 0.5 + 1e-4 * np.arange(6), atol=1e-12)
    assert log.states["car"].shape == (61, 6)
    assert log.measured["car"].shape == (61, 5)
    assert log.active["joystick"].shape == (61, 1)
    assert (log.active["car"][1:] == 1).all()


def test_the_run_starts_as_the_scenario_says() -> None:
    """On the path's first point within a few px, along it, at its speed, with the stick at its start axes."""
    world = GAME.make_world(LINE, 0)
    log_episode = Episode(world, Steps())
    log_episode.run(1)
    first = {n: s[0] for n, s in log_episode.log().states.items()}
    assert np.linalg.norm(first["car"][:2] - [300, 300]) < 4
    np.testing.assert_allclose(first["car"][2:4], [0.0, LINE.speed[0]], atol=1e-9)
    np.testing.assert_allclose(first["joystick"][2:], [0.0, 0.4], atol=1e-6)
    np.testing.assert_allclose(first["hand"], GAME.hand_for_tilt(first["joystick"][:2]), atol=1e-9)


def test_two_runs_of_one_number_are_the_same_and_of_two_are_not() -> None:
    logs = []
    for run in (0, 0, 1):
        world = GAME.make_world(LINE, run)
        episode = Episode(world, Steps())
        episode.run(5)
        logs.append(episode.log())
    for name in GAME.graph.objects:
        np.testing.assert_array_equal(logs[0].measured[name], logs[1].measured[name])
    assert not np.array_equal(logs[0].measured["car"], logs[2].measured["car"])


def test_stop_ends_an_episode_at_a_tick() -> None:
    world = GAME.make_world(LINE, 0)
    episode = Episode(world, Steps())
    assert episode.run(20, lambda e: e.context.get_time() > 2.5 * TICK)
    assert episode.context.get_time() == pytest.approx(3 * TICK)
    assert not episode.run(2, lambda e: False)
    assert episode.context.get_time() == pytest.approx(5 * TICK)


def test_a_path_that_is_driven_to_its_end_is_completed() -> None:
    """The car starts along a straight line and goes on: the end comes within reach."""
    short = TimedPath(np.array([[300.0, 300.0], [360.0, 300.0]]), GAME.path_limits())
    world = GAME.make_world(short, 0)
    log, arrival = follow_path(world, along(short, Pusher(0.02)))
    assert arrival.arrived
    assert not arrival.reason("px", 1.0)
    assert log.states["car"][-1, 0] > 357
    assert (np.diff(log.extra["progress"][:, 0]) >= 0).all()


def test_a_run_that_passes_beside_the_end_has_not_arrived() -> None:
    """Left to itself the car drifts off the longer line: progress says that its end was reached."""
    world = GAME.make_world(LINE, 0)
    log, arrival = follow_path(world, along(LINE, Pusher(0.02)))
    assert log.extra["progress"][-1, 0] >= 100
    assert not arrival.arrived
    assert "came no nearer to the end than" in arrival.reason("px", 1.0)


def test_a_run_that_gets_lost_is_given_up_before_its_time() -> None:
    """Driven backward, the car is soon 12 ticks of nominal speed from its path."""
    world = GAME.make_world(LINE, 0)
    log, arrival = follow_path(world, along(LINE, Pusher(-0.04)))
    assert not arrival.arrived
    assert "left the path or stood still" in arrival.reason("px", 1.0)
    assert log.states["car"][-1, 0] == pytest.approx(300 - 12 * 45 * TICK, abs=25)
    assert log.times[-1] < 1.6 * LINE.time[-1] + 4


def test_a_run_that_comes_to_no_end_is_given_up_too() -> None:
    world = GAME.make_world(LINE, 0)
    log, arrival = follow_path(world, along(LINE, Pusher(0.001)))
    assert not arrival.arrived
    assert "left the path or stood still" in arrival.reason("px", 1.0)
    assert log.times[-1] == pytest.approx(1.6 * LINE.time[-1] + 5, abs=2 * TICK)
