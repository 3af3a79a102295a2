"""Which experiment would tell most about a graph that was found so far: what to touch next, and why."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from ichain_drake.learning.discovery.edges import DiscoveredGraph


@dataclass(frozen=True)
class Experiment:
    """What a robot does in a piece.

    Attributes:
        touched: objects that it takes one after the other, over and over, and leaves; of several, each is left as it
            is while the next is moved, so that what one of them does shows by itself. None: the hand moves freely.
    """

    touched: tuple[str, ...] = ()

    def __str__(self) -> str:
        return f"touch {', then '.join(self.touched)}" if self.touched else "move freely"


@dataclass(frozen=True)
class Question:
    """What is not known yet.

    Attributes:
        text: in words.
        bits: how uncertain it is.
        answers: experiments that would tell.
    """

    text: str
    bits: float
    answers: tuple[Experiment, ...]


def questions(found: DiscoveredGraph | None, objects: Sequence[str], reached: Collection[str]) -> list[Question]:
    """What is open about a graph.

    Args:
        found: what earlier pieces showed; None if there are none.
        objects: all but the robot.
        reached: those that the robot can touch.
    """
    able = [n for n in objects if n in reached]
    singles = [Experiment((n,)) for n in able]
    pairs = [Experiment((a, b)) for k, a in enumerate(able) for b in able[k + 1 :]]
    every = (*singles, *pairs) or (Experiment(),)
    edges = () if found is None else found.found
    explained = {f.edge.child for f in edges}

    def about(*names: str) -> tuple[Experiment, ...]:
        """Experiments that move some objects, by themselves or through others: all of them, if they can be moved."""
        moved = {d for n in names if (d := _driver(n, found, reached))}
        if len(moved) > 1:
            return tuple(e for e in pairs if moved >= set(e.touched))
        return tuple(e for e in every if moved <= set(e.touched))

    out = [Question(f"what acts on {n}?", 1.0, every) for n in objects if n not in explained]
    for f in edges:
        parent, child = f.edge.parent, f.edge.child
        out.append(Question(f"does {parent} act on {child}?", bits(f.confidence), about(parent) or every))
        for rival in f.rivals:
            # Of two causes each is moved while the other stays as it was left. The robot itself stays out by leaving.
            text = f"is it {parent} or {rival.parent} that acts on {child}?"
            out.append(Question(text, bits(rival.probability), about(parent, rival.parent)))
    return out


def choose(open_questions: Sequence[Question], done: Sequence[Experiment]) -> tuple[Experiment, str]:
    """The experiment that promises most, and the question that it is for.

    An answer is the less likely the more often it was sought in vain.

    Args:
        open_questions: at least one.
        done: earlier experiments.
    """
    worth: dict[Experiment, float] = {}
    best: dict[Experiment, Question] = {}
    for q in open_questions:
        for e in q.answers:
            worth[e] = worth.get(e, 0.0) + q.bits / (1 + done.count(e))
            if e not in best or q.bits > best[e].bits:
                best[e] = q
    chosen = max(worth, key=lambda e: worth[e])
    return chosen, best[chosen].text


def _driver(name: str, found: DiscoveredGraph | None, reached: Collection[str]) -> str | None:
    """The nearest object through which the robot moves one: itself, if it can be touched."""
    layer, seen = [name], {name}
    while layer:
        for n in layer:
            if n in reached:
                return n
        parents = [] if found is None else [f.edge.parent for n in layer for f in found.found if f.edge.child == n]
        layer = [p for p in dict.fromkeys(parents) if p not in seen]
        seen |= set(layer)
    return None


def bits(probability: float) -> float:
    """How uncertain a yes or no of some probability is."""
    p = float(np.clip(probability, 1e-9, 1.0 - 1e-9))
    return float(-p * np.log2(p) - (1.0 - p) * np.log2(1.0 - p))
