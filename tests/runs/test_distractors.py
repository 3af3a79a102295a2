"""Objects that act on nothing, beside those of a system."""

from dataclasses import replace

import bath_log
import numpy as np

from ichain_drake.runs.distractors import FOLLOWER, LAMP, MOVER, SPACES, STONE, distracted

PIECES = bath_log.pieces(2)


def test_four_objects_stand_beside_the_others() -> None:
    raw, spaces = distracted(PIECES, bath_log.GRAPH, 0)
    assert set(spaces) == {*bath_log.GRAPH.objects, *SPACES}
    for piece, found in zip(PIECES, raw, strict=True):
        assert set(found.states) == set(spaces)
        assert all(x.shape == (len(piece), len(spaces[n])) for n, x in found.states.items())
        np.testing.assert_array_equal(found.states[LAMP][:, 0], piece.table["lever->tank"])
        assert np.ptp(found.states[STONE], axis=0).max() < 0.01 < np.ptp(found.states[MOVER], axis=0).min()
        robot = found.states["hand"][:, :2]
        ways = [np.linalg.norm(found.states[n] - robot, axis=1).mean() for n in (FOLLOWER, STONE)]
        assert ways[0] < ways[1]
        follower = found.states[FOLLOWER]  # a third of the way to where the robot is
        np.testing.assert_allclose(np.diff(follower, axis=0), (robot[1:] - follower[:-1]) / 3.0, atol=0.01)


def test_seeds_differ_and_repeat() -> None:
    first, again, other = (distracted(PIECES, bath_log.GRAPH, seed)[0][0].states[MOVER] for seed in (0, 0, 1))
    np.testing.assert_array_equal(first, again)
    assert np.abs(first - other).max() > 0.01
    unlit = [replace(p, table=p.table.drop(columns="lever->tank")) for p in PIECES]
    assert LAMP not in distracted(unlit, bath_log.GRAPH, 0)[0][1].states


def test_what_moves_by_itself_swings_and_what_nothing_acts_on_stays() -> None:
    (raw, *_), _ = distracted(PIECES, bath_log.GRAPH, 3)
    mover, stone = raw.states[MOVER], raw.states[STONE]
    np.testing.assert_allclose(stone, np.tile([0.7, -0.2], (len(stone), 1)), atol=0.01)
    assert 0.0005 < stone.std(axis=0).min() <= stone.std(axis=0).max() < 0.002, "but for the noise of readings"
    bend = np.diff(mover, n=2, axis=0)
    middle = mover[1:-1] - mover.mean(axis=0)
    slope = (bend * middle).sum(axis=0) / (middle**2).sum(axis=0)
    np.testing.assert_allclose(slope, 2.0 * np.cos(0.3) - 2.0, rtol=0.3)
    assert (np.ptp(mover, axis=0) < 0.21).all()
