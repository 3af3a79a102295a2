"""Which objects act on one: gated effects added while they pay on left-out ticks, then what isn't needed taken away."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import ndtr

from ichain_drake.learning.discovery.log import Log
from ichain_drake.learning.discovery.passive_kind import constant_values
from ichain_drake.learning.discovery.residual import Residual
from ichain_drake.learning.discovery.settings import DISCOVERY
from ichain_drake.learning.discovery.term import Term
from ichain_drake.learning.discovery.term_fit import fit_passive, fit_term, judged
from ichain_drake.learning.selection import by_part, clearly
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import FloatArray


@dataclass(frozen=True)
class Rival:
    """Another object that explains the same ticks.

    Attributes:
        parent: the object.
        probability: that it is the cause instead, by the one standard error of the difference on left-out ticks.
    """

    parent: str
    probability: float


@dataclass(frozen=True, eq=False)
class Explained:
    """What was found about one object.

    Attributes:
        residual: its motion beyond the passive one, as the last step left it.
        terms: gated effects on it, its own among them.
        rivals: per term, other parents that explain the same ticks.
    """

    residual: Residual
    terms: tuple[Term, ...]
    rivals: tuple[tuple[Rival, ...], ...]


def explain(log: Log, child: str, parents: Sequence[str], required: Sequence[str] = ()) -> Explained:
    """Gated effects on an object.

    Args:
        log: the ticks.
        child: the object.
        parents: that may act on it.
        required: of these, those that surely do.
    """
    residual = Residual(log, child, constant_values(log, child, parents))
    terms: list[Term] = []
    rivals: list[tuple[Rival, ...]] = []
    own = _passive_motion(residual)
    if own is not None:
        terms.append(own)
        rivals.append(())
    while len(terms) < DISCOVERY.most_terms:
        best, others = _next(residual, terms, parents, required)
        if best is None:
            break
        terms.append(best)
        rivals.append(others)
        _learn_turn(log, best)
        for _ in range(2 if len(terms) > 1 else 1):
            for k in range(len(terms)):
                terms[k] = _refitted(residual, terms, k)
        if terms[-1].value <= 0:  # what it explained, the others explain with it
            terms.pop()
            rivals.pop()
            break
    _take_back(residual, terms, rivals, required)
    return Explained(residual, tuple(terms), tuple(rivals))


def certainty(left_out: FloatArray, log: Log) -> float:
    """Probability that gains on left-out ticks, shape (n_ticks,), are above zero in truth, by their standard error."""
    gains = by_part(left_out, log.block)
    return float(ndtr(gains.sum() / max(float(np.sqrt(np.sum(gains**2))), 1e-12)))


def score(term: Term, log: Log) -> float:
    """Evidence on left-out ticks less its price [nat]."""
    return term.gain - term.price()


def _passive_motion(residual: Residual) -> Term | None:
    """What the object does all the time by itself, if anything: an interaction perturbs it, and doesn't replace it."""
    for window in (1, DISCOVERY.window):
        residual.leave((), window)
        term = fit_passive(residual)
        if term is not None and _pays(term, residual.log, 2) and _goes_on(term, residual.log):
            return term
    return None


def _goes_on(term: Term, log: Log) -> bool:
    """Whether hardly a tick, and hardly a stretch of them, speaks against what an object is said to do all the time.

    What is done to it half of the time is half of that on average, which no single tick may tell from either.
    """
    ticks, stretches = term.evidence < -DISCOVERY.shows, by_part(term.evidence, log.block) < -DISCOVERY.seen
    return bool(max(np.mean(ticks), np.mean(stretches)) <= LEARNING.near)


def _next(
    residual: Residual, terms: Sequence[Term], parents: Sequence[str], required: Sequence[str]
) -> tuple[Term | None, tuple[Rival, ...]]:
    """The term that pays most on what others leave, and its rivals."""
    log = residual.log
    missing = set(required) - {t.parent for t in terms}
    candidates = []
    for window in (1, DISCOVERY.window):
        residual.leave(terms, window)
        for parent in (residual.child, *parents):
            term = fit_term(residual, parent)
            if term is not None and (term.value > DISCOVERY.least or parent in missing):
                candidates.append(term)
    if not candidates:
        return None, ()
    top = max(t.value for t in candidates)
    tried = len(candidates)
    paying: list[Term] = []
    for term in candidates:
        if term.value < DISCOVERY.worth * top and term.parent not in missing:
            continue
        residual.leave(terms, term.window)
        found = judged(residual, term)
        if _pays(found, log, tried) or (found.parent in missing and found.gain > 0):
            paying.append(found)
    if not paying:
        return None, ()
    paying.sort(key=lambda t: -score(t, log))
    near = [t for t in paying[: DISCOVERY.looking] if score(t, log) > DISCOVERY.close * score(paying[0], log)]
    widened = [_looking_around(residual, terms, t, parents) for t in near or paying[:1]]
    best = _most_direct(max(widened, key=lambda t: score(t, log)), widened, log)
    best = _alone(best, [t for t in paying if t.parent == residual.child], log)
    same = [
        Rival(t.parent, 1.0 - certainty(best.left_out - t.left_out, log))
        for t in (*widened, *paying[len(widened) :])
        if t.parent not in (best.parent, residual.child)
        and _same(t, best)
        and score(t, log) > DISCOVERY.close * score(best, log)
    ]
    return best, tuple(same)


def _most_direct(best: Term, others: Sequence[Term], log: Log) -> Term:
    """Of terms that explain the same ticks, none clearly better, rather another object's than the robot's.

    Whatever a robot presses or turns is where the robot is; so its places tell about as much as what they switch, and
    the nearer cause says it with less chance.
    """
    if best.parent != log.root:
        return best
    nearer = [
        t
        for t in others
        if t.parent not in (log.root, t.child)
        and _same(t, best)
        and not clearly(by_part(best.left_out - t.left_out, log.block))
    ]
    return max(nearer, key=lambda t: score(t, log), default=best)


def _alone(best: Term, own: Sequence[Term], log: Log) -> Term:
    """What an object does by itself, unless another's action adds as much to it as any term must gain."""
    alike = [t for t in own if _same(t, best) and score(best, log) < score(t, log) + DISCOVERY.least]
    return max(alike, key=lambda t: score(t, log), default=best)


def _pays(term: Term, log: Log, tried: int) -> bool:
    return term.gain > DISCOVERY.least and clearly(by_part(term.left_out, log.block), tried)


def _same(a: Term, b: Term) -> bool:
    """Whether two terms explain the same ticks: a lamp that lights with the heater."""
    said_a, said_b = a.on & (a.evidence > 1.0), b.on & (b.evidence > 1.0)
    return bool((said_a & said_b).sum() > 0.7 * max(said_a.sum(), said_b.sum(), 1))


def _looking_around(residual: Residual, terms: Sequence[Term], term: Term, parents: Sequence[str]) -> Term:
    """The same effect with a gate that looks at other objects too, where that pays a lot."""
    if len(parents) < 2:
        return term
    log = residual.log
    residual.leave(terms, term.window)
    best = term
    for start in (term.on, None):
        wider = fit_term(residual, term.parent, parents, start)
        if wider is None or not wider.objects - {term.parent, residual.child}:
            continue
        if wider.value <= term.value + DISCOVERY.other_object:
            continue
        wider = judged(residual, wider)
        least, share = DISCOVERY.pays, DISCOVERY.pays_share
        if score(wider, log) > score(best, log) + max(least, share * best.gain):
            best = wider
    return best


def _learn_turn(log: Log, term: Term) -> None:
    """How the child's frame is turned, from its motion with the robot."""
    a = term.alignment
    if a is None or term.parent != log.root or a.child.frame in log.turns or not any(e.declared for e in term.effects):
        return
    turn = log.turns[a.parent.frame]
    if a.turn.shape == turn.shape:
        log.turns[a.child.frame] = a.turn @ turn


def _refitted(residual: Residual, terms: Sequence[Term], k: int) -> Term:
    """A term fitted anew to what the others leave, from its own ticks."""
    old = terms[k]
    residual.leave([t for i, t in enumerate(terms) if i != k], old.window)
    passive = old.parent == residual.child and not old.gate.faces
    new = fit_passive(residual) if passive else fit_term(residual, old.parent, old.others, old.on)
    return old if new is None else replace(new, left_out=old.left_out)


def _take_back(residual: Residual, terms: list[Term], rivals: list[tuple[Rival, ...]], required: Sequence[str]) -> None:
    """Remove terms that the others make superfluous."""
    k = 0
    while len(terms) > 1 and k < len(terms):
        residual.leave([t for i, t in enumerate(terms) if i != k], terms[k].window)
        if terms[k].gate.faces or terms[k].parent != residual.child:
            terms[k] = judged(residual, terms[k])
        gains = by_part(terms[k].left_out, residual.log.block)
        if (terms[k].gain < DISCOVERY.least or not clearly(gains)) and terms[k].parent not in required:
            terms.pop(k)
            rivals.pop(k)
            for i in range(len(terms)):
                terms[i] = _refitted(residual, terms, i)
            k = 0
        else:
            k += 1
