"""Running a world with a controller, and logging it: one episode."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder, System

from ichain_drake.control.tracking.arrival import Arrival
from ichain_drake.control.tracking.systems import PathController, PathFollower
from ichain_drake.simulation.frame_log import DOING, FrameLog
from ichain_drake.simulation.interruption import deferred_interrupt
from ichain_drake.simulation.path_watch import PathWatch
from ichain_drake.simulation.watching import Watcher, present_watcher
from ichain_drake.simulation.wiring import wire
from ichain_drake.state import FloatArray
from ichain_drake.timing import FRAME, FRAMES_PER_TICK, TICK
from ichain_drake.world.world import World


@dataclass(frozen=True)
class EpisodeLog:
    """Everything logged in one episode, a row per 30 Hz frame.

    Attributes:
        times: [s], shape (n,).
        states: truth of the robot and of every object, shape (n, n_variables) each.
        measured: what their sensors gave, shape (n, n_observable) each.
        active: truth of every object's incoming interactions, shape (n, n_parents) each.
        command: hand command, shape (n, n_hand).
        plant_positions: of the arm's plant, shape (n, n_q), or None.
        extra: further logged ports by name.
    """

    times: FloatArray
    states: Mapping[str, FloatArray]
    measured: Mapping[str, FloatArray]
    active: Mapping[str, FloatArray]
    command: FloatArray
    plant_positions: FloatArray | None = None
    extra: Mapping[str, FloatArray] = field(default_factory=dict)


class EpisodeInterrupted(KeyboardInterrupt):
    """Ctrl-C in the middle of an episode.

    Attributes:
        log: what was logged up to then.
    """

    def __init__(self, log: EpisodeLog) -> None:
        super().__init__("interrupted")
        self.log = log


class Episode:
    """A world with whatever sends its hand commands, wired, logged and ready to run.

    Args:
        world: the world; its default context is where the episode starts.
        commander: see `wire`.
        truth: names of objects whose full state the commander reads; only an oracle does.
        log: whether to log; a benchmark may do without.
    """

    def __init__(self, world: World, commander: System, truth: tuple[str, ...] = (), *, log: bool = True) -> None:
        self.world = world
        self.commander = commander
        self.path = None if self.follower is None else self.follower.path  # as it was at first: a person may move it
        self._seen_by: Watcher[Episode] | None = None
        builder = DiagramBuilder()
        builder.AddSystem(world)
        builder.AddSystem(commander)
        wire(builder, world, commander, truth)
        self._log = FrameLog(builder, world, commander) if log else None
        self.diagram: Diagram = builder.Build()
        self.simulator = Simulator(self.diagram)
        self.context = self.simulator.get_mutable_context()
        self.simulator.Initialize()

    @property
    def follower(self) -> PathFollower | None:
        """What follows the path; None where there is none."""
        return self.commander.follower if isinstance(self.commander, PathController) else None

    def run(self, ticks: int, stop: Callable[[Episode], bool] | None = None) -> bool:
        """Advance tick by tick.

        Args:
            ticks: at most so many.
            stop: asked after every tick; true ends the episode.

        Returns:
            Whether `stop` ended it.
        """
        start = round(self.context.get_time() / TICK)
        with deferred_interrupt() as pressed:
            return self._run(start, ticks, stop, pressed)

    def _advance(self, tick: int, watcher: Watcher[Episode] | None) -> None:
        """To a tick, frame by frame if somebody watches, which gives the same."""
        last = tick * FRAMES_PER_TICK
        # Counted in frames: a number of ticks may end a rounding error before its last frame.
        if watcher is None or self._log is None:
            self.simulator.AdvanceTo(last * FRAME)
            return
        if self._seen_by is not watcher:
            self._seen_by = watcher
            watcher.begin(self)
        for frame in range(last - FRAMES_PER_TICK + 1, last + 1):
            self.simulator.AdvanceTo(frame * FRAME)
            if watcher.frame(self):
                raise KeyboardInterrupt

    def _run(self, start: int, ticks: int, stop: Callable[[Episode], bool] | None, pressed: Callable[[], bool]) -> bool:
        watcher = present_watcher()
        for tick in range(start, start + ticks):
            self._advance(tick + 1, watcher)
            if pressed():
                raise KeyboardInterrupt
            if stop is not None and stop(self):
                return True
        return False

    def value(self, name: str, port: str = "measured") -> FloatArray:
        """The present value of an object's port."""
        system = self.world.system(name)
        return system.GetOutputPort(port).Eval(system.GetMyContextFromRoot(self.context)).copy()

    def recent(self, name: str) -> FloatArray:
        """True states of an object at the frames of the last tick, its start included, shape (n, n_variables)."""
        assert self._log is not None
        return self._log.rows(self.context, f"{name}.state", FRAMES_PER_TICK + 1)

    def log(self) -> EpisodeLog:
        """What has been logged so far."""
        assert self._log is not None
        times, rows = self._log.all_rows(self.context)
        names = self.world.graph.objects
        return EpisodeLog(
            times,
            {n: rows[f"{n}.state"] for n in names},
            {n: rows[f"{n}.measured"] for n in names},
            {n: rows[f"{n}.active"] for n in names if f"{n}.active" in rows},
            rows["command"],
            rows.get("plant_positions"),
            {key: rows[key] for key in DOING if key in rows},
        )


def follow_path(world: World, commander: PathController, truth: tuple[str, ...] = ()) -> tuple[EpisodeLog, Arrival]:
    """Run one path to its end, or until it is clear that the end will not be reached.

    Returns:
        The log, and whether it has arrived.

    Raises:
        EpisodeInterrupted: on Ctrl-C, with the log up to then.
    """
    follower, followed, targets = commander.follower, commander.followed, commander.targets
    path = follower.path
    episode = Episode(world, commander, truth)
    space = world.graph.objects[followed]
    true_targets = space.indices([space.observable.names[k] for k in targets])
    watch = PathWatch(path)

    def over(running: Episode) -> bool:
        position = running.value(followed)[list(targets)]
        last = int(follower.GetOutputPort("progress").Eval(follower.GetMyContextFromRoot(running.context))[0])
        present = follower.path  # a person may have moved it
        return watch.see(position, running.recent(followed)[:, true_targets], present, last)

    try:
        episode.run(watch.allowed, over)
    except KeyboardInterrupt:
        raise EpisodeInterrupted(episode.log()) from None
    return episode.log(), watch.arrival
