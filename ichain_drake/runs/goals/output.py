"""What a run towards a goal leaves behind to be looked at: recording, playback and pictures."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ichain_drake.control.execution.tasks import Mode
from ichain_drake.control.planning.goals import gap, value_of
from ichain_drake.control.planning.plan import Condition
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning import InteractionModel
from ichain_drake.runs.goals.run import GraphRun
from ichain_drake.simulation.episode import EpisodeLog
from ichain_drake.state import BoolArray, FloatArray
from ichain_drake.timing import FRAME, FRAMES_PER_TICK, TICK
from ichain_drake.visualization import Lane, Readout, RecordedEpisode, Recording, Strip, plot_timeline, write_playback
from ichain_drake.visualization.timeline import Style

_ACTIVE = 0.5
_SKILLS = ("", "activate", "deactivate")
_DONE = {"look": "looks", "blind": "waits for sensors", "carry": "carries", "drive": "drives"} | {
    "activate": "activates",
    "deactivate": "deactivates",
    "reached": "goal reached",
    "stopped": "gave up",
}


def flags_of(log: EpisodeLog, graph: InteractionGraph) -> dict[str, BoolArray]:
    """Whether each interaction is active in truth, shape (n,), by its name."""
    return {
        e.name: log.active[e.child][:, graph.parents(e.child).index(e.parent)] > _ACTIVE for e in graph.interactions
    }


def make_graph_recording(run: GraphRun) -> Recording:
    """Everything that the playback shows.

    Raises:
        InputError: if nothing was recorded.
    """
    scenario = run.scenario
    episodes = () if run.log is None else (_episode(run, run.log),)
    graph = scenario.graph
    return Recording(scenario.name, scenario.physics, scenario.seed, dict(graph.objects), episodes, graph.interactions)


def _episode(run: GraphRun, log: EpisodeLog) -> RecordedEpisode:
    graph = run.scenario.graph
    readouts = _goal_readouts(run, log) | _doing_readouts(run) | _contents(log, graph)
    flags = flags_of(log, graph)
    return RecordedEpisode(
        "to the goal", log.times, log.states, log.plant_positions, readouts, {}, flags, _strips(run, log)
    )


def _doing_readouts(run: GraphRun) -> dict[str, Readout]:
    """What the controller is at."""
    edges = run.scenario.graph.interactions
    doing = run.doing
    return {
        "controller": Readout([_DONE[Mode(int(v)).name.lower()] for v in doing["mode"]]),
        "interaction": Readout([edges[int(v)].name if v >= 0 else "-" for v in doing["edge"]]),
        "skill": Readout([_SKILLS[int(v)] or "-" for v in doing["skill"]]),
        "plan step": Readout(["-" if v < 0 else str(int(v) + 1) for v in doing["plan_step"]]),
    }


def _goal_readouts(run: GraphRun, log: EpisodeLog) -> dict[str, Readout]:
    """How many conditions hold in truth, and how far the one that is farthest off is from holding."""
    if run.goal is None:
        return {}
    graph, conditions = run.scenario.graph, run.goal.conditions
    off = np.array([_off(c, log, graph) for c in conditions]).reshape(len(conditions), len(log.times))
    flags = flags_of(log, graph)
    as_wanted = [~flags[e.name] for e in run.goal.inactive] + [flags[e.name] for e in run.goal.active]
    held = (off == 0).sum(axis=0) + np.array(as_wanted, dtype=bool).reshape(-1, len(log.times)).sum(axis=0)
    total = len(conditions) + len(as_wanted)
    readouts = {"goal": Readout([f"{int(h)} of {total} met" for h in held])}
    if len(conditions):
        # Units differ: the worst is the one that has most of its own largest distance left.
        worst = np.argmax(off / np.maximum(off.max(axis=1, keepdims=True), 1e-12), axis=0)
        readouts["error"] = Readout([_error(conditions[w], off[w, k], graph) for k, w in enumerate(worst)])
    return readouts


def _off(condition: Condition, log: EpisodeLog, graph: InteractionGraph) -> FloatArray:
    return np.asarray(gap(condition, _value(condition, log, graph)), dtype=float)


def _value(condition: Condition, log: EpisodeLog, graph: InteractionGraph) -> FloatArray:
    seen = graph.objects[condition.object].observable_indices
    return value_of(condition, {condition.object: log.states[condition.object][:, seen]}, graph)


def _error(condition: Condition, off: float, graph: InteractionGraph) -> str:
    if off <= 0:
        return "none"
    unit = _unit(graph, condition.object, condition.variable)
    return f"{condition.object}.{condition.variable}: {off:.3f}{' ' + unit if unit else ''}"


def _contents(log: EpisodeLog, graph: InteractionGraph) -> dict[str, Readout]:
    """Amounts and what mixes with them, such as water and its temperature, known by their roles."""
    readouts = {}
    for name, space in graph.objects.items():
        for i, variable in enumerate(space.variables):
            if variable.role is not None and variable.role.kind in ("amount", "intensive") and not variable.hidden:
                readouts[f"{name} {variable.name}"] = Readout(log.states[name][:, i], _unit(graph, name, variable.name))
    return readouts


def _strips(run: GraphRun, log: EpisodeLog) -> dict[str, Strip]:
    """The variables that the goal names, with the ranges that are wanted of them."""
    if run.goal is None:
        return {}
    graph = run.scenario.graph
    return {
        _label(c): Strip(_value(c, log, graph), _unit(graph, c.object, c.variable), c.lower, c.upper)
        for c in run.goal.conditions
    }


def _label(condition: Condition) -> str:
    name = f"{condition.object}.{condition.variable}"
    if not math.isfinite(condition.upper):
        return f"{name} \u2265 {condition.lower:.3g}"
    if not math.isfinite(condition.lower):
        return f"{name} \u2264 {condition.upper:.3g}"
    return f"{name} from {condition.lower:.3f} to {condition.upper:.3f}"


def _unit(graph: InteractionGraph, obj: str, variable: str) -> str:
    space = graph.objects[obj]
    unit = space.variables[space.index(variable)].unit
    return "" if unit == "1" else unit


def classified(model: InteractionModel, log: EpisodeLog) -> dict[str, BoolArray]:
    """What the status classifiers say of what was measured at each tick, shape (n_ticks,), by interaction.

    Args:
        model: the classifiers; each sees its own last answer, as in an execution.
        log: of an episode.
    """
    readings = {n: values[::FRAMES_PER_TICK] for n, values in log.measured.items()}
    said: dict[str, list[bool]] = {e.name: [] for e in model.graph.interactions}
    previous: dict[Interaction, bool] | None = None
    for k in range(len(log.times[::FRAMES_PER_TICK])):
        found = model.active({n: r[k] for n, r in readings.items()}, previous)
        previous = {e: bool(on) for e, on in found.items()}
        for edge, on in previous.items():
            said[edge.name].append(on)
    return {name: np.array(flags, dtype=bool) for name, flags in said.items()}


def write_graph_pictures(run: GraphRun, folder: Path) -> list[Path]:
    """When each interaction was active in truth, by its classifier, and what the controller did, as `timeline.png`.

    Raises:
        InputError: if the file can't be written.
    """
    if run.log is None or len(run.log.times) < 2 or run.model is None:  # noqa: PLR2004
        return []
    file = folder / "timeline.png"
    edges = run.model.graph.interactions  # where they were found out of states, not all of the scenario's
    truth, said = flags_of(run.log, run.scenario.graph), classified(run.model, run.log)
    lanes = {
        e.name: [
            *([Lane("truth", "solid", _spans(truth[e.name], FRAME))] if e.name in truth else []),
            Lane("classifier", "grey", _spans(said[e.name], TICK)),
            *_controller_lanes(run, edges.index(e)),
        ]
        for e in edges
    }
    plot_timeline(file, lanes, float(run.log.times[-1]), _strips(run, run.log), run.log.times)
    return [file]


def _controller_lanes(run: GraphRun, edge: int) -> list[Lane]:
    about = run.doing["edge"] == edge
    mode = run.doing["mode"]
    kinds = {
        "activates": (Mode.ACTIVATE,),
        "carries, drives": (Mode.CARRY, Mode.DRIVE),
        "deactivates": (Mode.DEACTIVATE,),
    }
    styles: dict[str, Style] = {"activates": "rising", "carries, drives": "dots", "deactivates": "falling"}
    return [
        Lane(f"controller {label}", styles[label], _spans(about & np.isin(mode, modes), FRAME))
        for label, modes in kinds.items()
    ]


def _spans(flags: BoolArray | Sequence[bool], period: float) -> list[tuple[float, float]]:
    """Where flags are set: start and duration [s]; a flag holds until the next one."""
    padded = np.concatenate([[0], np.asarray(flags, dtype=int), [0]])
    starts, ends = np.flatnonzero(np.diff(padded) == 1), np.flatnonzero(np.diff(padded) == -1)
    return [(float(a * period), float((b - a) * period)) for a, b in zip(starts, ends, strict=True)]


def write_graph_recording(run: GraphRun, file: Path) -> list[Path]:
    """Write the playback, if there is anything to play.

    Raises:
        InputError: if the file can't be written.
    """
    if run.log is None or len(run.log.times) < 2:  # noqa: PLR2004
        return []
    scenario = run.scenario
    write_playback(
        make_graph_recording(run), scenario.drawings(), file, plant=scenario.drawn_plant(), camera=scenario.view()
    )
    return [file]
