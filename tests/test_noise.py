"""Noise is a function of its key and the frame, and of nothing else."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ichain_drake.noise import NoiseRows, NoiseStream


def values(stream: NoiseStream, frames: int = 2000) -> np.ndarray:
    return np.array([stream.at(k) for k in range(frames)])


@settings(max_examples=20)
@given(st.lists(st.integers(0, 5000), min_size=1, max_size=20))
def test_a_value_does_not_depend_on_the_order_of_reading(frames: list[int]) -> None:
    stream = NoiseStream(3, 1, "process", (0, 1))
    forward = {k: stream.at(k).copy() for k in sorted(frames)}
    again = NoiseStream(3, 1, "process", (0, 1))
    for k in reversed(frames):
        np.testing.assert_array_equal(again.at(k), forward[k])


def test_a_variable_keeps_its_stream_whatever_its_neighbours() -> None:
    both, second = NoiseStream(3, 1, "process", (0, 7)), NoiseStream(3, 1, "process", (7,))
    np.testing.assert_array_equal(values(both)[:, 1], values(second)[:, 0])


def test_streams_of_different_keys_are_independent() -> None:
    """Seed, object, purpose and variable each make another stream: all correlations within sampling error."""
    keys = [(0, 0, "process"), (1, 0, "process"), (0, 1, "process"), (0, 0, "measurement")]
    columns = np.concatenate([values(NoiseStream(*key, (0, 1))) for key in keys], axis=1)  # type: ignore[arg-type]
    off_diagonal = np.corrcoef(columns.T) - np.eye(8)
    assert np.abs(off_diagonal).max() < 0.1


def test_values_are_standard_normal() -> None:
    sample = values(NoiseStream(0, 0, "process", tuple(range(10))))
    assert sample.shape == (2000, 10)
    assert sample.mean() == pytest.approx(0.0, abs=0.03)
    assert sample.var() == pytest.approx(1.0, abs=0.05)
    # Successive frames are independent, across the borders of cached blocks too.
    assert abs(np.mean(sample[1:] * sample[:-1])) < 0.03
    assert not np.array_equal(sample[511], sample[512])


@given(st.lists(st.integers(0, 5000), max_size=20))
def test_the_noise_of_several_frames_is_that_of_each(frames: list[int]) -> None:
    stream = NoiseStream(3, 1, "measurement", (0, 4))
    expected = np.array([stream.at(k) for k in frames]).reshape(-1, 2)
    np.testing.assert_array_equal(stream.rows(frames), expected)
    assert NoiseStream(0, 0, "measurement", ()).rows(frames).shape == (len(frames), 0)


def test_an_object_without_noise_has_an_empty_stream() -> None:
    stream = NoiseStream(0, 0, "process", ())
    assert len(stream) == 0
    assert stream.at(7).shape == (0,)


def test_the_shared_cache_can_not_be_changed_through_a_value() -> None:
    with pytest.raises(ValueError, match="read-only"):
        NoiseStream(0, 0, "process", (0,)).at(0)[0] = 1.0


def test_rows_are_the_streams_of_their_runs_also_when_some_end() -> None:
    streams = [NoiseStream(seed, 1, "process", (0, 4)) for seed in range(3)]
    rows = NoiseRows(streams)
    for frame in (0, 511, 512, 3):
        np.testing.assert_array_equal(rows.at(frame), [s.at(frame) for s in streams])
    rows.keep(np.array([True, False, True]))
    for frame in (3, 700):
        np.testing.assert_array_equal(rows.at(frame), [s.at(frame) for s in streams[::2]])
    assert NoiseRows([NoiseStream(0, 1, "process", ())] * 3).at(7).shape == (3, 0)
