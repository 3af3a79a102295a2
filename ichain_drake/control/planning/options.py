"""Options of a learned interaction graph, generated from its models and demonstrated samples alone.

Two kinds: carry an object that follows the robot somewhere and let it go; activate a chain of interactions from the
robot on, drive a variable of its last object until it stops changing, and let go.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import networkx as nx
import numpy as np

from ichain_drake.control.planning.carries import CarryOption
from ichain_drake.control.planning.drive_option import DriveOption, beside
from ichain_drake.control.planning.frames import Frames
from ichain_drake.control.planning.model import (
    Batch,
    BoolArray,
    is_change,
    keeps,
    row,
    span,
    take,
)
from ichain_drake.control.planning.travel import jumping
from ichain_drake.control.settings import PLANNING
from ichain_drake.graph import Interaction
from ichain_drake.learning.model import InteractionModel
from ichain_drake.learning.settings import LEARNING
from ichain_drake.rules import enabled
from ichain_drake.state import FloatArray, IntArray


def chains(model: InteractionModel) -> tuple[tuple[Interaction, ...], ...]:
    """All chains of interactions from the robot to an object, short ones first."""
    graph = model.graph
    found = []
    for target in graph.objects:
        if target == graph.root:
            continue
        for path in nx.all_simple_paths(graph.digraph, graph.root, target):
            found.append(tuple(Interaction(a, b) for a, b in zip(path[:-1], path[1:], strict=True)))
    return tuple(sorted(found, key=len))


def find_drives(model: InteractionModel, carries: tuple[CarryOption, ...]) -> tuple[DriveOption, ...]:
    """Chains with the variables that they drive, as predicted from demonstrated samples of all the chain active."""
    by_edge = {c.edge: c for c in carries}
    samples, owner, every = [], [], chains(model)
    for number, chain in enumerate(every):
        joint = _joint_samples(model, chain)
        n = len(next(iter(joint.values())))
        samples.append(joint)
        owner += [number] * n
    if not owner:
        return ()
    batch = {n: np.concatenate([s[n] for s in samples]) for n in model.graph.objects}
    margins = {e: model.decide(e, batch) for e in model.graph.interactions}
    change, further = _probe(model, batch, PLANNING.probe), _probe(model, batch, PLANNING.long)
    frames, ways = Frames(model), list[_Way]()
    for number, chain in enumerate(every):
        rows = np.flatnonzero(np.array(owner) == number)
        if len(rows):
            sure = np.min([margins[e][rows] for e in chain], axis=0)
            shown, soon, later = (take(part, rows) for part in (batch, change, further))
            ways += _ways_of(model, frames, chain, by_edge.get(chain[0]), shown, soon, later, sure)
    totals = _probe_each(model, [w.poses for w in ways], PLANNING.long)
    going = [(w, total) for w, total in zip(ways, totals, strict=True) if w.gain(total).max() >= w.least]
    out = [_drive(model, w, w.gain(total)) for w, total in going]
    return tuple(d for d in out if not _subsumed(model, d, out))


@dataclass(frozen=True, eq=False)
class _Way:
    """A chain that may drive a variable in a direction.

    Attributes:
        chain, variable, direction, rate, carry, anchor: as of the option.
        poses: the robot and the chain's first object as in each sample of it, all else as in one.
        sure: how surely all of the chain is active in each sample, shape (n,).
        least: change that is worth an option.
    """

    chain: tuple[Interaction, ...]
    variable: int
    direction: int
    rate: float
    carry: CarryOption | None
    anchor: str | None
    poses: Batch
    sure: FloatArray
    least: float

    def gain(self, change: Batch) -> FloatArray:
        """What a change of all objects is to the variable, in the direction, shape (n,)."""
        return self.direction * change[self.chain[-1].child][:, self.variable]


def _subsumed(model: InteractionModel, drive: DriveOption, every: list[DriveOption]) -> bool:
    """Whether a carried object drives more than the chain says, and a longer chain says so."""
    if not enabled("subsumed"):
        return False
    longer = [
        d.chain[len(drive.chain)]
        for d in every
        if len(d.chain) > len(drive.chain) and d.chain[: len(drive.chain)] == drive.chain
    ]
    return drive.carry is not None and any(float(model.decide(e, drive.hold)) >= 0 for e in longer)


def _joint_samples(model: InteractionModel, chain: tuple[Interaction, ...]) -> Batch:
    """Demonstrated states in which every interaction of a chain is active, by the classifiers."""
    parts = [dict(model.edges[e].examples.active) for e in chain]
    latched = _latched(model, chain[-1])
    if len(latched):
        # What an interaction does at once is done in all of these: the child as it was before shows that it does it.
        target, begun = chain[-1].child, model.edges[chain[-1]].examples.activations
        first = {n: v.copy() for n, v in begun.after.items()}
        first[target][:, latched] = begun.before[target][:, latched]
        parts.append(first)
    batch = {n: np.concatenate([p[n] for p in parts]) for n in model.graph.objects}
    on = np.ones(len(batch[chain[0].parent]), dtype=bool)
    for e in chain:
        on &= model.decide(e, batch) >= 0
    rows = np.flatnonzero(on)
    if len(rows) > PLANNING.poses:
        rows = rows[np.linspace(0, len(rows) - 1, PLANNING.poses).round().astype(int)]
    return take(batch, rows)


def _latched(model: InteractionModel, edge: Interaction) -> IntArray:
    """Variables of a child that an interaction changes and that can't change gradually."""
    jumps = jumping(model.graph.objects[edge.child].observable)
    return np.array([f.variable for f in model.edges[edge].effects if jumps[f.variable]], dtype=np.intp)


def _probe(model: InteractionModel, batch: Batch, ticks: int) -> Batch:
    """Change of every object over some ticks with the robot held still, shape (n, n_variables) each."""
    now = {n: v.copy() for n, v in batch.items()}
    status = None
    for tick in range(ticks):
        known = status if tick % (2 * PLANNING.probe) > 1 else None
        now, status = model.step(now, batch[model.graph.root], known, strict=False)
    return {n: model.graph.objects[n].observable.difference(now[n], batch[n]) for n in batch}


def _probe_each(model: InteractionModel, batches: Sequence[Batch], ticks: int) -> list[Batch]:
    """The same of several batches, as one: one row costs as much as a hundred."""
    if not batches:
        return []
    ends = np.cumsum([len(b[model.graph.root]) for b in batches])[:-1]
    change = _probe(model, {n: np.concatenate([b[n] for b in batches]) for n in model.graph.objects}, ticks)
    parts = {n: np.split(v, ends) for n, v in change.items()}
    return [{n: v[k] for n, v in parts.items()} for k in range(len(batches))]


def _anchor(frames: Frames, chain: tuple[Interaction, ...], carry: CarryOption | None) -> str | None:
    """What samples of a chain are relative to: what is pressed or turned, or what the carried object acts on.

    What is held but stays at its place, as a knob, is beside nothing that it could be brought to: others come to it.
    """
    if carry is None:
        return chain[0].child if frames.goes_with(chain[0]) else None
    if len(chain) == 1 or not frames.is_relative(chain[1]) or not frames.has_place(chain[0].child, carry.follow):
        return None
    return chain[1].child


def _ways_of(
    model: InteractionModel,
    frames: Frames,
    chain: tuple[Interaction, ...],
    carry: CarryOption | None,
    batch: Batch,
    change: Batch,
    further: Batch,
    sure: FloatArray,
) -> Iterator[_Way]:
    target = chain[-1].child
    follow = carry.follow if carry is not None and len(chain) == 1 else ()
    least = np.maximum(PLANNING.least * span(model, target), PLANNING.noises * model.noise[target])
    usable = keeps(model, target) & ~is_change(model, target)
    anchor = _anchor(frames, chain, carry)
    for v in np.flatnonzero(usable):
        if v in follow or not any(f.variable == v for f in model.edges[chain[-1]].effects):
            continue
        largest = float(np.abs(change[target][:, v]).max())
        for direction in (1, -1):
            fastest = float((direction * change[target][:, v]).max())
            if fastest < max(PLANNING.hardly * least[v], LEARNING.slight * largest):
                continue
            # How far each way of holding the chain gets, all from the same contents: those that leave most room for it.
            roomy = int(np.argmax(direction * further[target][:, v]))
            poses = _in_context(model, frames, chain, carry, batch, roomy, anchor)
            rate = fastest / PLANNING.probe
            yield _Way(chain, int(v), direction, rate, carry, anchor, poses, sure, float(least[v]))


def _drive(model: InteractionModel, way: _Way, total: FloatArray) -> DriveOption:
    """The option of the pose that gets far and is surest.

    Args:
        model: the learned graph.
        way: the chain and its poses.
        total: how far each gets, shape (n,).
    """
    best, poses, carry = float(total.max()), way.poses, way.carry
    nearly = np.flatnonzero(total >= PLANNING.nearly * best)
    if carry is not None and enabled("turned_where_shown"):
        shown = _shown(model, carry, poses[carry.edge.child][nearly][:, carry.follow])
        nearly = nearly[shown] if shown.any() else nearly
    nearly = nearly[np.argsort(-way.sure[nearly], kind="stable")]
    before = hold = int(nearly[0])
    if carry is not None:
        before = _quiet_row(model, carry, poses, np.abs(total) < LEARNING.near * best, hold)
    held = row(poses, hold)
    quietly = held if before == hold else row(poses, before)
    others = take(poses, nearly[1:] if before == hold else nearly[:0])
    return DriveOption(
        way.chain, way.variable, way.direction, way.rate, carry, held, quietly, anchor=way.anchor, others=others
    )


def _in_context(
    model: InteractionModel,
    frames: Frames,
    chain: tuple[Interaction, ...],
    carry: CarryOption | None,
    batch: Batch,
    context: int,
    anchor: str | None,
) -> Batch:
    """The robot and the pose of the chain's first object of each sample, everything else of one of them."""
    first, target, latched = chain[0].child, chain[-1].child, _latched(model, chain[-1])
    if carry is not None and anchor is not None:
        batch = beside(frames, batch, model.graph.root, first, anchor, batch[anchor][context])
    out = {n: np.repeat(v[context][None], len(v), axis=0) for n, v in batch.items()}
    out[model.graph.root] = batch[model.graph.root].copy()
    part = slice(None) if carry is None else carry.follow
    out[first][:, part] = batch[first][:, part]
    out[target][:, latched] = batch[target][context, latched]
    return out


def _quiet_row(model: InteractionModel, carry: CarryOption, batch: Batch, quiet: BoolArray, hold: int) -> int:
    """The quiet sample from which a drive begins; the driving one itself if there is none.

    Near the driving sample, and in each variable near a value at which the object was let go.
    """
    rows = np.flatnonzero(quiet)
    if not len(rows):
        return hold
    root, obj = model.graph.root, carry.edge.child
    width = span(model, obj)[carry.follow]
    pose = batch[obj][:, carry.follow]
    away = np.abs(pose[rows, None, :] - carry.places[None]).min(axis=1) / width
    distance = 2.0 * away.sum(axis=1) + (np.abs(pose[rows] - pose[hold]) / width).sum(axis=1)
    if enabled("unseen"):
        distance += PLANNING.unseen * _unseen(model, carry, pose[rows], width)
    turned = model.graph.objects[root].observable.difference(batch[root][rows], batch[root][hold])
    return int(rows[np.argmin(distance + (np.abs(turned) / span(model, root)).sum(axis=1))])


def _unseen(model: InteractionModel, carry: CarryOption, poses: FloatArray, width: FloatArray) -> FloatArray:
    """How far poses, not turned yet, are from demonstrated ones, in demonstrated ranges, shape (n,).

    Passed through once, on the way to somewhere else, is not enough: several demonstrated poses must be near.
    """
    before = _unturned(model, carry, poses)
    if before is None:
        return np.zeros(len(poses))
    return _several((np.abs(_off(model, carry, before)) / width).sum(axis=2))


def _shown(model: InteractionModel, carry: CarryOption, poses: FloatArray) -> BoolArray:
    """Whether poses, not turned yet, were demonstrated, by all that readings tell, shape (n,).

    What is carried is turned where it was brought to. Where it was only ever turned, something may be below.
    """
    before = _unturned(model, carry, poses)
    if before is None:
        return np.ones(len(poses), dtype=bool)
    noise = np.sqrt(2.0) * np.maximum(model.noise[carry.edge.child][carry.follow], 1e-12)
    away = np.abs(_off(model, carry, before) / noise).max(axis=2)
    return np.asarray(_several(away) <= LEARNING.surely)


def _unturned(model: InteractionModel, carry: CarryOption, poses: FloatArray) -> FloatArray | None:
    """Poses turned as the object was let go, shape (n, n_follow); None where it has no place, or nothing turns."""
    variables = model.graph.objects[carry.edge.child].observable.variables
    turned = [k for k, i in enumerate(carry.follow) if (r := variables[i].role) is None or r.kind != "position"]
    if len(turned) in (0, len(carry.follow)):
        return None
    before = poses.copy()
    before[:, turned] = np.median(carry.places[:, turned], axis=0)
    return before


def _off(model: InteractionModel, carry: CarryOption, poses: FloatArray) -> FloatArray:
    """Differences from poses in which the object was carried, shape (n, n_shown, n_follow)."""
    seen = model.edges[carry.edge].examples.active[carry.edge.child][:, carry.follow]
    return np.asarray(poses[:, None, :] - seen[None])


def _several(away: FloatArray) -> FloatArray:
    """Of distances, shape (n, n_shown), within which several demonstrated poses lie, shape (n,)."""
    return np.sort(away, axis=1)[:, min(LEARNING.few, away.shape[1]) - 1]
