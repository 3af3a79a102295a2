"""Settings of discovery: prices of what a gated effect may consist of, and when evidence counts."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class DiscoverySettings:
    """How gated effects are searched for in logs of states.

    Attributes:
        face: price of a face of a gate [nat]: half the logarithm of some thousand rows, as for any parameter (BIC).
        unlikely_face: price of a face on a content or a tilt [nat]: interactions are about places, grips and levels.
        other_object: price of an object that acts or that a gate looks at, beside the child [nat].
        declared: price of an effect that the roles declare [nat]; it has no parameter.
        constant: price of a constant effect [nat].
        slope: price of each input of a linear effect [nat]: a parameter, and that it was picked from many.
        clip: most that one tick may say [nat]: one odd reading decides nothing.
        outliers: share of ticks that no model describes (knocks, drop-outs), anywhere within a variable's range.
        least: log-likelihood on left-out rows that a term must gain [nat], beside its price and the one standard error.
        window: effects that drown in one tick's noise are judged by means over so many [ticks].
        folds: rows are left out in so many parts, dealt in blocks.
        block: successive ticks that are left out together [ticks]: longer than what one event shows.
        most_terms: gated effects on one object at most.
        most_inputs: inputs of a linear effect at most.
        rows: fewest ticks that an effect is fitted to.
        perturbed: residuals of so many noises are no noise.
        discernible: noises (of the means that it is judged by) that an undeclared effect must have at least.
        certain: evidence beyond which a tick's status is taken from what was seen there [nat].
        shows: evidence below which nothing shows in a tick, so that its status stays open [nat].
        against: share of ticks that may speak against what an object does all the time by itself.
        dead_band: noises of a difference within which a measured change is none, if its neighbours say so too.
        empty: noises of an amount below which what is dissolved in it means nothing.
        moving: noises of a displacement that shows how frames are turned.
    """

    face: float = 4.0
    unlikely_face: float = 16.0
    other_object: float = 8.0
    declared: float = 1.0
    constant: float = 4.0
    slope: float = 10.0
    clip: float = 12.0
    outliers: float = 0.005
    least: float = 15.0
    window: int = 6
    folds: int = 4
    block: int = 12
    most_terms: int = 8
    most_inputs: int = 3
    rows: int = 6
    perturbed: float = 4.0
    discernible: float = 1.0
    certain: float = 6.0
    shows: float = 1.0
    against: float = 0.05
    dead_band: float = 1.0
    empty: float = 15.0
    moving: float = 4.0
