"""Simulation of drives with the learned models: many at once, since one row costs as much as a hundred."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ichain_drake.control.planning.borders import Border
from ichain_drake.control.planning.drive_option import DriveOption
from ichain_drake.control.planning.drive_run import Run
from ichain_drake.control.planning.model import (
    Batch,
    BoolArray,
    is_change,
    row,
    take,
)
from ichain_drake.control.planning.motion_run import MotionRun
from ichain_drake.control.planning.plan import Condition, States
from ichain_drake.control.planning.stops import Stop, find_stops
from ichain_drake.control.planning.travel import jumping
from ichain_drake.graph import Interaction
from ichain_drake.learning.model import InteractionModel
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import FloatArray


@dataclass(frozen=True, eq=False)
class Outcome:
    """Where a drive ends.

    Attributes:
        states: predicted once everything is let go.
        end: value of the driven variable at which the drive stops.
        ticks: from the drive's beginning on.
        lost: the interaction of the chain that was or became inactive, if it did not drive at all.
        met: index of the condition for which it stops, if there is one.
        margin: decision value of the interaction that was lost.
        probability: that all interactions of the chain are active where it begins to drive.
    """

    states: Batch
    end: float
    ticks: int
    lost: Interaction | None = None
    met: int | None = None
    margin: float = 0.0
    probability: float = 1.0


def settle(model: InteractionModel, batch: Batch, parked: FloatArray) -> tuple[Batch, dict[Interaction, BoolArray]]:
    """What becomes of states with the robot away, or wherever it is, and what is active then.

    Args:
        model: the learned graph.
        batch: states, shape (n, n_variables) each.
        parked: state of the robot, shape (n_root,), or (n, n_root).
    """
    root = model.graph.root
    now = {**batch, root: np.array(np.broadcast_to(parked, batch[root].shape))}
    status: dict[Interaction, BoolArray] = {}
    for _ in range(LEARNING.ticks):
        now, status = model.step(now, now[root], strict=False)
    for n in model.passive:
        now[n][:, is_change(model, n)] = 0.0
    return now, status


def simulate(
    model: InteractionModel,
    rows: Sequence[tuple[States, DriveOption]],
    parked: FloatArray,
    conditions: Sequence[Condition],
    borders: Sequence[Border] = (),
) -> list[list[Outcome]]:
    """Drive each row until its variable stops changing; also stop where a condition or an interaction's chance begins.

    Args:
        model: the learned graph.
        rows: start states with the robot away, and the drive.
        parked: state of the robot once it lets go, shape (n_root,).
        conditions: of the goal, at which a drive may end early.
        borders: values at which it may end early.

    Returns:
        Outcomes of each row: that of the full drive last. A row whose chain can't be active has one outcome that
        names the interaction.
    """
    out: list[list[Outcome]] = [[] for _ in rows]
    for kind in (Run, MotionRun):
        mine = [r for r, (_, d) in enumerate(rows) if (d.motion is None) == (kind is Run)]
        if mine:
            run = kind(model, [rows[r] for r in mine], parked)
            for r, outcomes in zip(mine, _outcomes(run, conditions, borders), strict=True):
                out[r] = outcomes
    return out


def _outcomes(run: Run, conditions: Sequence[Condition], borders: Sequence[Border]) -> list[list[Outcome]]:
    run.drive()
    stops = find_stops(run, conditions, borders)
    ends = _states_at(run, stops)
    settled, _ = settle(run.model, run.undo(ends, stops), run.parked)
    out: list[list[Outcome]] = [[] for _ in run.rows]
    likely = _likely(run)
    for k, s in enumerate(stops):
        drive = run.rows[s.row][1]
        value = float(ends[drive.chain[-1].child][k, drive.variable])
        ticks = int(run.ticks_at[s.step][s.row] + run.ramp[s.row])
        lost = run.lost[s.row]
        margin = 0.0 if lost is None else float(run.model.decide(lost, row(ends, k)))
        out[s.row].append(Outcome(row(settled, k), value, ticks, lost, s.condition, margin, float(likely[s.row])))
    return out


def _likely(run: Run) -> FloatArray:
    """Probability that the whole chain is active once it is activated, in each row, shape (n,)."""
    begins = [Stop(r, int(min(run.last[r], run.ramp[r] + len(d.chain)))) for r, d in enumerate(run.drives)]
    states, out = _states_at(run, begins), np.ones(run.n)
    for e in dict.fromkeys(e for d in run.drives for e in d.chain):
        mine = [r for r, d in enumerate(run.drives) if e in d.chain]
        out[mine] *= run.model.probability(e, take(states, mine))
    return out


def _states_at(run: Run, stops: Sequence[Stop]) -> Batch:
    """States at the stops; between two steps where a value was passed between them."""
    out = {}
    for n, space in run.model.graph.objects.items():
        after = np.array([run.history[s.step][n][s.row] for s in stops])
        before = np.array([run.history[max(s.step - 1, 0)][n][s.row] for s in stops])
        share = np.array([s.share for s in stops])[:, None]
        between = before + share * space.observable.difference(after, before)
        out[n] = np.where((share < 1.0) & ~jumping(space.observable), between, after)
    return out
