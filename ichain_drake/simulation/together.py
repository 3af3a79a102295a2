"""Many runs along one path at once, in `ideal` physics: each to the last bit what `follow_path` makes of it alone."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ichain_drake.control.settings import TRACKING
from ichain_drake.control.tracking.arrival import Arrival
from ichain_drake.control.tracking.each_row import each_row
from ichain_drake.control.tracking.systems import PathController
from ichain_drake.simulation.episode import EpisodeLog
from ichain_drake.simulation.path_watch import PathWatch
from ichain_drake.simulation.run_logs import RunLogs
from ichain_drake.timing import FRAMES_PER_TICK, TICK
from ichain_drake.world.rows import WorldRows
from ichain_drake.world.world import World


def follow_path_together(
    worlds: Sequence[World], commander: PathController, truth: tuple[str, ...] = ()
) -> list[tuple[EpisodeLog, Arrival]]:
    """Run one path in every world, to its end or until it is clear that the end will not be reached.

    Args:
        worlds: see `WorldRows`.
        commander: says what decides and reads what, and holds the path; it does not run.
        truth: see `Episode`.

    Returns:
        Of each run the log, of true states and commands alone, and whether it has arrived.

    Raises:
        NotTogetherError: if these worlds can't be calculated together.
        InputError: on a command that is not finite.
    """
    world = WorldRows(worlds)
    controller, path = commander.controller, commander.follower.path
    policy = each_row(controller.policy)
    space = world.graph.objects[commander.followed]
    targets = list(commander.targets)
    true_targets = space.indices([space.observable.names[k] for k in targets])

    watches = [PathWatch(path) for _ in worlds]
    allowed = watches[0].allowed
    log = RunLogs(len(worlds), allowed, world.states, controller.initial_command[None])
    running, search = np.arange(len(worlds)), TRACKING.search * TICK
    memory = np.zeros((len(worlds), controller.policy.memory_size))
    ahead = TICK * np.arange(1, controller.policy.lookahead + 1)
    position = world.measured(commander.followed)[:, targets]
    progress = path.advance_rows(position, np.zeros(len(worlds), dtype=np.intp), search)
    for tick in range(allowed):
        first = tick * FRAMES_PER_TICK
        wanted = path.at_time(path.time[progress][:, None] + ahead)
        states = [world.states[o] if o in truth else world.measured(o) for o in controller.reads]
        command, memory, _ = policy.decide(states, wanted, memory)
        log.add(running, tick, ((states, {}) for states in world.frames(command)), command)
        position = world.measured(commander.followed)[:, targets]
        progress = path.advance_rows(position, progress, search)
        passed = log.states[commander.followed][running, first : first + FRAMES_PER_TICK + 1][..., true_targets]
        on = np.ones(len(running), dtype=bool)
        for k, run in enumerate(running):
            on[k] = not watches[run].see_at(int(progress[k]), position[k], passed[k], path)
        running, progress, memory, position = running[on], progress[on], memory[on], position[on]
        if not len(running):
            break
        if not on.all():
            world.keep(on)
    return [(log.of(k), watch.arrival) for k, watch in enumerate(watches)]
