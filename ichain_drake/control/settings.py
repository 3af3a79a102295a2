"""Constants of control: what planning, execution and path tracking take for the same, for near and for too long."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ichain_drake.learning.discovery.settings import DISCOVERY
from ichain_drake.learning.settings import LEARNING
from ichain_drake.settings import setting


@dataclass(frozen=True)
class PlanningSettings:
    """How options are found and plans are searched for. A *range* is that of a variable in the demonstrations.

    Attributes:
        same: of a range, within which two values are the same; of the largest of several motions, what is none.
        least: of a range, that an option must change; of its rate, below which it has stopped.
        hardly: of a change that is expected, below which nothing has happened.
        likely: probability, or share of samples, from which on an interaction is taken for possible.
        push: of the robot's largest step, with which its effect is tried; two goals, or places, nearer than that are
            one; short of a step by more, and not getting on, it is stopped.
        noises: that a change must have at least, where it is to be seen in single readings.
        nearly: of the best sample's change, from which on the surest sample is taken.
        unseen: weight of the distance from poses that were shown, in ranges.
        cheaper: times the length of a shorter plan that one may have which watches more interactions.
        meets: of a tick's largest change: how near a predicted state must be to a demonstrated one to go on from it.
        alike: of a tick's largest change, within which demonstrated states are one.
        discount: a tick: looks about fifty ticks ahead, longer than a stroke and a new grasp.
        samples: demonstrated states, or places on the way, that are tried.
        states: demonstrated states in which a status is asked for.
        poses: demonstrated states of an option.
        line: places between demonstrated ones.
        nodes: demonstrated states that a motion is made of: a few a centimetre of a hand's way, in one model step.
        probe: that a drive is tried for, and until statuses are asked anew; twice as many it may take at once.
        long: the same, to see how far it gets.
        window: over which a drive's rate is read.
        retake: to let go of an object and take another, or press a button; so long what does not get on is waited for.
        steps: of a drive, or of the search for a motion, at most.
    """

    same: float = setting(0.02, "share", above=0, below=1)
    least: float = setting(0.08, "share", above=0, below=1)
    hardly: float = setting(0.2, "share", above=0, below=1)
    likely: float = setting(0.5, "probability", above=0, below=1)
    push: float = setting(0.5, "share", above=0, upper=1)
    noises: float = setting(5.0, "noises", above=0)
    nearly: float = setting(0.9, "share", above=0, upper=1)
    unseen: float = setting(4.0, "1", lower=0)
    cheaper: float = setting(1.2, "times", lower=1)
    meets: float = setting(0.35, "share", above=0)
    alike: float = setting(0.15, "share", above=0)
    discount: float = setting(0.98, "a tick", above=0, below=1)
    samples: int = setting(40, "states", lower=1)
    states: int = setting(24, "states", lower=1)
    poses: int = setting(60, "states", lower=1)
    line: int = setting(17, "places", lower=2)
    nodes: int = setting(240, "states", lower=1)
    probe: int = setting(6, "ticks", lower=1)
    long: int = setting(36, "ticks", lower=1)
    window: int = setting(8, "ticks", lower=1)
    retake: int = setting(20, "ticks", lower=1)
    steps: int = setting(400, "times", lower=1)


@dataclass(frozen=True)
class ExecutionSettings:
    """How a plan is carried out and watched.

    Attributes:
        readings: averaged where one look was not enough.
        corrected: over which it is seen whether an interaction is active, and after which what it carries is looked at.
        shortest: ticks over which it is seen whether something goes along, at least.
        noise_rows: newest readings that the noise of a run is estimated by.
        ahead: of a range: a demonstrated pose beyond what was planned is one from here on.
        slack: of a range, within which a motion is there.
        slack_noises: the same in noises of a reading.
        value: of a range: a prediction that is off by more, in what is no place, is noticed.
        gone: ranges beyond the demonstrated one, from which nothing brings an object back.
        narrow: range that an object's places are taken to have at least.
        nodes: of a way around where it was stopped, that are tried at most.
    """

    readings: int = setting(12, "ticks", lower=1)
    corrected: int = setting(5, "ticks", lower=1)
    shortest: int = setting(2, "ticks", lower=1)
    noise_rows: int = setting(120, "readings", lower=3)
    ahead: float = setting(0.03, "share", above=0, below=1)
    slack: float = setting(0.005, "share", above=0, below=1)
    slack_noises: float = setting(1.2, "noises", above=0)
    value: float = setting(0.12, "share", above=0, below=1)
    gone: float = setting(5.0, "ranges", above=0)
    narrow: float = setting(0.05, "m", above=0)
    nodes: int = setting(20_000, "places", lower=1)


@dataclass(frozen=True)
class TrackingSettings:
    """How paths are followed, and which are too sharp.

    Attributes:
        search: how far ahead on a path the nearest point is looked for.
        nearest: between errors whose likeness tells a lasting one.
        furthest: the same at most.
        band: of a speed, within which a transition counts as of that speed; so much longer a run may take.
        quantile: of the turns that were shown: the sharpest few are noise.
        smoothing: over which a demonstrated trajectory is averaged to follow it in validation.
        slowest: of nominal speed: a path that has to be taken slower is too sharp to tell methods apart.
        kept: share of the best paths by which a method is judged.
        lost: usual steps off its path from which on a run is lost.
    """

    search: float = setting(4.0, "ticks", above=0)
    nearest: int = setting(2, "ticks", lower=1)
    furthest: int = setting(9, "ticks", lower=1)
    band: float = setting(0.3, "share", above=0, below=1)
    quantile: float = setting(0.98, "share", above=0, below=1)
    smoothing: int = setting(11, "ticks", lower=1)
    slowest: float = setting(0.6, "share", above=0, upper=1)
    kept: float = setting(0.75, "share", above=0, upper=1)
    lost: float = setting(12.0, "steps", above=0)


PLANNING = PlanningSettings()
"""The ones in force."""

EXECUTION = ExecutionSettings()
"""The ones in force."""

TRACKING = TrackingSettings()
"""The ones in force."""


def constants() -> dict[str, Any]:
    """The constants of learning and control that are in force: a settings dataclass per part."""
    return {
        "learning": LEARNING,
        "discovery": DISCOVERY,
        "planning": PLANNING,
        "execution": EXECUTION,
        "tracking": TRACKING,
    }
