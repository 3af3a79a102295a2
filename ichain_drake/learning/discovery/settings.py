"""Constants of discovery: prices of what a gated effect may consist of, and when evidence counts."""

from __future__ import annotations

from dataclasses import dataclass

from ichain_drake.settings import setting


@dataclass(frozen=True)
class DiscoverySettings:
    """How gated effects are searched for in logs of states; what it shares with all learning is in `LearningSettings`.

    Attributes:
        face: price of a face of a gate: half the logarithm of some thousand rows, as for any parameter (BIC).
        unlikely_face: price of a face on a content or a tilt: interactions are about places, grips and levels.
        other_object: price of an object that acts or that a gate looks at, beside the child.
        declared: price of an effect that the roles declare; it has no parameter.
        constant: price of a constant effect.
        slope: price of each input of a linear effect: a parameter, and that it was picked from many.
        clip: most that one tick may say: one odd reading decides nothing.
        outliers: share of ticks that no model describes (knocks, drop-outs), anywhere within a variable's range.
        least: log-likelihood on left-out rows that a term must gain, beside its price and the one standard error.
        window: effects that drown in one tick's noise are judged by means over so many; twice as many go together.
        parts: rows are left out in so many parts, dealt in blocks.
        most_terms: gated effects on one object at most.
        most_inputs: inputs of an effect at most, in a sum, or multiplied with each other in a curve's monomials.
        certain: evidence beyond which a tick's status is taken from what was seen there.
        shows: evidence below which nothing shows in a tick, so that its status stays open.
        seen: evidence of ticks in which something was seen to act.
        likely: the same where such ticks are few.
        speaks: evidence of a tick that speaks for or against a face.
        mean: that the mean within an interval must explain for a search to begin there.
        clearly: by which a rest value must be likelier than none.
        more: that a further input of an effect must bring.
        pays: that a gate must gain by looking at other objects.
        pays_share: the same of its own evidence.
        acts: share of the ticks in which it was seen to act that a tightened gate must keep.
        close: of the best, or of the most that is seen: what may be as good, or is of the same kind.
        worth: of the best candidate's evidence, from which on another is judged.
        rest: share of rows that a rest value is read in at least.
        leaves: of a change's square, that a distance from rest has where it is more than readings' noise.
        unturned: weight of the prior that frames are not turned, of the displacements' own.
        sway: ridge penalty on how a turning parent sways its child.
        declared_first: by which what no role declares must be better.
        intervals: of one input that a search begins with.
        starts: inputs that a search for a gate starts from, beside the best.
        looking: candidates whose gates are widened.
        tried: inputs tried for the next place in a line: those that go best with what is left.
        rounds: of alternating between effect and gate.
        left_out_rounds: the same on left-out ticks.
    """

    face: float = setting(4.0, "nat", lower=0)
    unlikely_face: float = setting(16.0, "nat", lower=0)
    other_object: float = setting(8.0, "nat", lower=0)
    declared: float = setting(1.0, "nat", lower=0)
    constant: float = setting(4.0, "nat", lower=0)
    slope: float = setting(10.0, "nat", lower=0)
    clip: float = setting(12.0, "nat", above=0)
    outliers: float = setting(0.005, "share", above=0, below=1)
    least: float = setting(15.0, "nat", lower=0)
    window: int = setting(6, "ticks", lower=1)
    parts: int = setting(4, "parts", lower=2)
    most_terms: int = setting(8, "effects", lower=1)
    most_inputs: int = setting(3, "inputs", lower=0)
    certain: float = setting(6.0, "nat", lower=0)
    shows: float = setting(1.0, "nat", lower=0)
    seen: float = setting(4.0, "nat", lower=0)
    likely: float = setting(1.5, "nat", lower=0)
    speaks: float = setting(0.5, "nat", lower=0)
    mean: float = setting(8.0, "nat", lower=0)
    clearly: float = setting(5.0, "nat", lower=0)
    more: float = setting(3.0, "nat", lower=0)
    pays: float = setting(20.0, "nat", lower=0)
    pays_share: float = setting(0.1, "share", lower=0)
    acts: float = setting(0.7, "share", above=0, below=1)
    close: float = setting(0.5, "share", above=0, below=1)
    worth: float = setting(0.3, "share", above=0, below=1)
    rest: float = setting(0.4, "share", above=0, below=1)
    leaves: float = setting(0.8, "share", above=0)
    unturned: float = setting(0.1, "1", lower=0)
    sway: float = setting(0.01, "1", above=0)
    declared_first: float = setting(1.3, "times", lower=1)
    intervals: int = setting(2, "intervals", lower=0)
    starts: int = setting(3, "inputs", lower=0)
    looking: int = setting(4, "candidates", lower=1)
    tried: int = setting(5, "inputs", lower=1)
    rounds: int = setting(5, "times", lower=1)
    left_out_rounds: int = setting(3, "times", lower=1)


DISCOVERY = DiscoverySettings()
"""The ones in force."""
