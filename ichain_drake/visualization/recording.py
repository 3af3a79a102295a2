"""What a run leaves behind to be looked at: the truth of every object in time, in episodes."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction
from ichain_drake.state import StateSpace

FloatArray = NDArray[np.float64]

RATE = 30.0
"""Samples of a recording a second [Hz]: the world's tick."""


@dataclass(frozen=True)
class Readout:
    """One line of the read-out in the playback.

    Attributes:
        values: what to show at each sample: numbers, shape (n,), NaN where there is none, or n texts.
        unit: unit symbol of the numbers; empty for texts.
    """

    values: FloatArray | list[str]
    unit: str = ""

    @property
    def is_text(self) -> bool:
        """Whether the values are texts."""
        return isinstance(self.values, list)


@dataclass(frozen=True)
class Strip:
    """A quantity that the playback plots over an episode's time, such as a variable that the goal names.

    Attributes:
        values: at each sample, shape (n,); NaN where there is none.
        unit: unit symbol.
        lower, upper: what is wanted of it, drawn as a band; infinite where open, or where nothing is wanted.
    """

    values: FloatArray
    unit: str = ""
    lower: float = -math.inf
    upper: float = math.inf

    @property
    def is_wanted(self) -> bool:
        """Whether there is a band to be in."""
        return math.isfinite(self.lower) or math.isfinite(self.upper)


@dataclass(frozen=True)
class RecordedEpisode:
    """One piece of a run, such as one followed path.

    Attributes:
        name: shown in the playback, such as the path's name.
        times: simulation time of the samples, shape (n,) [s], every 1/30 s.
        states: true state of each object, shape (n, n_variables), in the variables' units.
        plant_positions: generalized positions of the arm's plant, shape (n, n_positions) [m, rad]; None without an arm.
        readouts: further values to show, by label.
        lines: commanded polylines, shape (m, 2), by the name of the object that draws them, in that object's units.
        active: whether an interaction is active, shape (n,), by its name `parent->child`.
        strips: what is plotted over time, by label.
    """

    name: str
    times: FloatArray
    states: Mapping[str, FloatArray]
    plant_positions: FloatArray | None = None
    readouts: Mapping[str, Readout] = field(default_factory=dict)
    lines: Mapping[str, FloatArray] = field(default_factory=dict)
    active: Mapping[str, NDArray[np.bool_]] = field(default_factory=dict)
    strips: Mapping[str, Strip] = field(default_factory=dict)

    @property
    def duration(self) -> float:
        """From the first sample to the last [s]."""
        return float(self.times[-1] - self.times[0])


@dataclass(frozen=True)
class Recording:
    """Everything that a playback shows.

    Attributes:
        scenario, physics, seed: what ran.
        spaces: state space of each object, in the order they are shown.
        episodes: in the order they were run; they may each start at any simulation time.
        interactions: edges of the interaction graph, for a drawing of it; none draws none.

    Raises:
        InputError: if an array doesn't fit its state space or its times, or an interaction the graph; names the
            episode and the field.
    """

    scenario: str
    physics: str
    seed: int
    spaces: Mapping[str, StateSpace]
    episodes: tuple[RecordedEpisode, ...]
    interactions: tuple[Interaction, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "episodes", tuple(self.episodes))
        object.__setattr__(self, "interactions", tuple(self.interactions))
        for edge in self.interactions:
            if edge.parent not in self.spaces or edge.child not in self.spaces:
                raise InputError(f"interaction {edge.name}: the recording's objects are {', '.join(self.spaces)}")
        if not self.episodes:
            raise InputError(f"recording of {self.scenario}: it has no episodes; record one first")
        for episode in self.episodes:
            _check_episode(episode, self.spaces)
            _check_activity(episode, [e.name for e in self.interactions])

    def starts(self, gap: float = 1.0) -> tuple[float, ...]:
        """When each episode starts in the playback [s], on the grid of 1/30 s.

        Args:
            gap: pause between two episodes [s].
        """
        starts, frame = [], 0
        for episode in self.episodes:
            starts.append(frame / RATE)
            frame += len(episode.times) - 1 + max(1, round(gap * RATE))
        return tuple(starts)

    def duration(self, gap: float = 1.0) -> float:
        """Length of the playback [s]; `gap` as for `starts`."""
        return self.starts(gap)[-1] + (len(self.episodes[-1].times) - 1) / RATE


def _check_episode(episode: RecordedEpisode, spaces: Mapping[str, StateSpace]) -> None:
    """Refuse an episode whose arrays don't fit together."""
    where = f"episode {episode.name}"
    times = np.asarray(episode.times)
    if times.ndim != 1 or not len(times) or not np.isfinite(times).all():
        raise InputError(f"{where}: times must be finite, shape (n,) with n >= 1; shape {times.shape} given")
    steps = np.diff(times)
    if len(steps) and not np.allclose(steps, 1 / RATE, atol=1e-6, rtol=0):
        worst = int(np.argmax(np.abs(steps - 1 / RATE)))
        raise InputError(
            f"{where}: times must step by 1/30 s; from {times[worst]:.4f} s to {times[worst + 1]:.4f} s they don't"
        )
    n = len(times)
    missing = [name for name in spaces if name not in episode.states]
    unknown = [name for name in episode.states if name not in spaces]
    if missing or unknown:
        raise InputError(
            f"{where}: states must be given for exactly {', '.join(spaces)}; "
            f"missing {', '.join(missing) or 'none'}, unknown {', '.join(unknown) or 'none'}"
        )
    for name, space in spaces.items():
        value = space.check(episode.states[name], f"{where}: states of {name}")
        if value.shape != (n, len(space)):
            raise InputError(f"{where}: states of {name} have shape {value.shape}, {(n, len(space))} needed")
    q = episode.plant_positions
    if q is not None and (np.ndim(q) != 2 or len(q) != n or not np.isfinite(q).all()):
        raise InputError(f"{where}: plant_positions must be finite, shape ({n}, n_positions); {np.shape(q)} given")
    for label, readout in episode.readouts.items():
        if len(readout.values) != n or (not readout.is_text and np.ndim(readout.values) != 1):
            raise InputError(f"{where}: readout {label!r} needs {n} values, shape {np.shape(readout.values)} given")
    for name, line in episode.lines.items():
        if np.ndim(line) != 2 or np.shape(line)[1] != 2 or not np.isfinite(line).all():
            raise InputError(f"{where}: line {name!r} must be finite, shape (m, 2); shape {np.shape(line)} given")


def _check_activity(episode: RecordedEpisode, edges: list[str]) -> None:
    """Refuse flags of interactions that there aren't, and flags or strips of another length than the episode."""
    where, n = f"episode {episode.name}", len(episode.times)
    for name, flags in episode.active.items():
        if name not in edges:
            raise InputError(
                f"{where}: flags of {name!r}; the recording's interactions are {', '.join(edges) or 'none'}"
            )
        if np.shape(flags) != (n,):
            raise InputError(f"{where}: flags of {name} need shape ({n},), shape {np.shape(flags)} given")
    for label, strip in episode.strips.items():
        if np.shape(strip.values) != (n,):
            raise InputError(f"{where}: strip {label!r} needs shape ({n},), shape {np.shape(strip.values)} given")
