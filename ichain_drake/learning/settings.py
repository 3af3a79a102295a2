"""Constants of learning, which discovery and control read too: what is a difference, near, and enough to tell."""

from __future__ import annotations

from dataclasses import dataclass

from ichain_drake.settings import setting


@dataclass(frozen=True)
class LearningSettings:
    """What learning takes for a difference, and how much evidence it asks for.

    A *noise* is the standard deviation of one reading of a variable, as demonstrations show it; a *range* is that of a
    variable in the demonstrations.

    Attributes:
        clear: from here on a difference is one, and nothing stands at a bound; residuals of so many medians are odd.
        surely: beyond it nothing is noise, and within it is all of what stands still.
        plain: a displacement so large shows whether things move together; a residual counts no more than this.
        moving: root mean square that the changes of a variable must have to be a motion.
        faint: what is less may be none: a difference, or by how much a goal holds.
        empty: an amount below it is as good as none: what is dissolved in it means nothing.
        away: from rest, that what goes back to it was seen at least.
        noisy: times the squared changes that noise alone gives, that there must be to explain.
        outstanding: times the median change, from which on one is no noise.
        sure: by which the less likely of two explanations must be better to be taken.
        near: of a range, within which something is as good as there; of others of its kind, what is as good as none; of
            cosines and sines, how much they change where nothing turns.
        slight: of a response, that may be a bias of the model; of a goal's range, that a margin takes; of all evidence,
            with which what roles declare is not compared any further.
        unexplained: of a motion that may be left by what explains it.
        together: of a child's squared motion that may be left where it moves with its parent.
        sway: ridge penalty on how a turning parent sways its child, against fits to hardly any turning.
        reach: of a range: how far a region may go on beyond what was shown, and what is narrow.
        kept: of rows or ticks: the rest may be odd.
        simpler: of an error that a further column must leave at most, to be worth a planner's knowing.
        single: the same for one column in screening.
        pair: the same for two columns at once.
        preference: by which a column that roles don't ask for must be better.
        dead_bands: of a prediction's root mean square, below which it may mean nothing.
        margins: of a decision value, by which what is active may stay so.
        surprise: candidates whose mean log-likelihoods differ by less are equal: the simpler is taken.
        told: F1 from which on a known status is the one shown.
        well: F1 from which on a status is learned well.
        events: F1 of the moments at which it switches, the same.
        rows: that something is fitted to at least; twice as many contradict, four times as many stand for themselves.
        short: rows of a block at least.
        several: rows that show how frames are turned, or a threshold.
        few: pieces or events that something must show in, failures that are no chance.
        folds: parts that rows are left out in.
        groups: the same for effects.
        look: readings that are averaged, before and after a row, before a plan and after a step.
        ticks: longer than noise lasts, shorter than a change of grasp: of a displacement, and until something is lost.
        examples: rows of either status that are kept; rows of a long recording that are learned from or not together.
        most_rows: that one effect is fitted to: what is slow in the number of rows stays quick.
        most_learned: rows that a graph is learned from at most; of more, stretches that show every switch, and evenly
            of the rest. Hours of ticks: classifiers take time in the square of them, and learn little from more.
        seeds: best columns that pairs are tried with.
        sweeps: of an alternating search, or moves of one, at most.
    """

    clear: float = setting(3.0, "noises", above=0)
    surely: float = setting(4.0, "noises", above=0)
    plain: float = setting(8.0, "noises", above=0)
    moving: float = setting(1.5, "noises", above=1)
    faint: float = setting(1.0, "noises", lower=0)
    empty: float = setting(15.0, "noises", above=0)
    away: float = setting(5.0, "noises", above=0)
    noisy: float = setting(2.0, "times", above=1)
    outstanding: float = setting(7.0, "medians", above=1)
    sure: float = setting(2.0, "standard errors", above=0)
    unexplained: float = setting(0.5, "share", above=0, below=1)
    together: float = setting(0.3, "share", above=0, below=1)
    sway: float = setting(0.3, "1", above=0)
    near: float = setting(0.05, "share", above=0, below=1)
    slight: float = setting(0.25, "share", above=0, below=1)
    kept: float = setting(0.8, "share", above=0, upper=1)
    reach: float = setting(0.3, "share", above=0)
    simpler: float = setting(0.85, "share", above=0, below=1)
    single: float = setting(0.55, "share", above=0, below=1)
    pair: float = setting(0.35, "share", above=0, below=1)
    preference: float = setting(1.03, "times", lower=1)
    dead_bands: tuple[float, ...] = setting((0.0, 0.05, 0.1, 0.2, 0.35), "share", lower=0)
    margins: tuple[float, ...] = setting((0.0, 0.05, 0.1, 0.2), "1", lower=0)
    surprise: float = setting(0.005, "nat", lower=0)
    told: float = setting(0.8, "F1", above=0, below=1)
    well: float = setting(0.9, "F1", above=0, below=1)
    events: float = setting(0.5, "F1", above=0, below=1)
    rows: int = setting(6, "rows", lower=1)
    short: int = setting(5, "rows", lower=1)
    several: int = setting(8, "rows", lower=1)
    few: int = setting(3, "times", lower=1)
    folds: int = setting(5, "parts", lower=2)
    groups: int = setting(8, "parts", lower=2)
    look: int = setting(4, "readings", lower=1)
    ticks: int = setting(3, "ticks", lower=1)
    examples: int = setting(200, "rows", lower=1)
    most_rows: int = setting(500, "rows", lower=1)
    most_learned: int = setting(50_000, "rows", lower=1000)
    seeds: int = setting(10, "columns", lower=1)
    sweeps: int = setting(25, "times", lower=1)


LEARNING = LearningSettings()
"""The ones in force."""
