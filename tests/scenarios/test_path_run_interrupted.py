"""Ctrl-C between two logs of one frame leaves whole frames."""

import numpy as np

from ichain_drake.scenarios.episode import EpisodeLog
from ichain_drake.scenarios.recorder import whole_frames


def test_a_frame_that_only_some_ports_have_is_dropped():
    def rows(count: int) -> np.ndarray:
        return np.arange(2.0 * count).reshape(count, 2)

    log = EpisodeLog(
        np.arange(5.0), {"a": rows(5), "b": rows(4)}, {"a": rows(5), "b": rows(5)}, {"b": rows(5)}, rows(5), rows(5),
        {"progress": rows(4)},
    )  # fmt: skip
    cut = whole_frames(log)
    parts = [cut.times, cut.command, cut.plant_positions, *cut.states.values(), *cut.measured.values()]
    parts += [*cut.active.values(), *cut.extra.values()]
    assert {len(p) for p in parts if p is not None} == {4}
    np.testing.assert_array_equal(cut.states["a"], rows(5)[:4])
    whole = EpisodeLog(np.arange(3.0), {"a": rows(3)}, {"a": rows(3)}, {}, rows(3))
    assert len(whole_frames(whole).times) == 3
    assert whole_frames(whole).plant_positions is None
