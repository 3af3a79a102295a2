"""Recordings: what they refuse, and that a file gives back what was saved."""

import dataclasses
import io
import json
import zipfile

import numpy as np
import pytest

from ichain_drake.errors import InputError
from ichain_drake.state import Role, StateSpace, Variable
from ichain_drake.visualization import Readout, load_recording, save_recording

GOOD = "record it again"


def rewritten(file, change):
    """The same file with its arrays changed by a function of the dict of them."""
    with np.load(file) as archive:
        arrays = {name: archive[name] for name in archive.files}
    change(arrays)
    np.savez_compressed(file, **arrays)


def test_round_trip_gives_everything_back(recording, tmp_path):
    space = StateSpace(
        "lamp", (Variable("level", "m", -1, 2, role=Role("level")), Variable("on", kind="binary", hidden=True))
    )
    recording = dataclasses.replace(recording, spaces={**recording.spaces, "lamp": space})
    save_recording(recording, tmp_path / "run.npz")
    loaded = load_recording(tmp_path / "run.npz")
    assert loaded.spaces == recording.spaces
    assert (loaded.scenario, loaded.physics, loaded.seed) == ("test_game", "ideal", 7)
    for a, b in zip(loaded.episodes, recording.episodes, strict=True):
        assert a.name == b.name
        np.testing.assert_array_equal(a.times, b.times)
        np.testing.assert_array_equal(a.plant_positions, b.plant_positions)
        for name in b.states:
            np.testing.assert_array_equal(a.states[name], b.states[name])
        np.testing.assert_array_equal(a.lines["car"], b.lines["car"])
        np.testing.assert_array_equal(a.readouts["error"].values, b.readouts["error"].values)
        assert (a.readouts["error"].unit, a.readouts["mode"].values) == ("px", b.readouts["mode"].values)


def test_same_recording_gives_same_bytes(recording, tmp_path):
    save_recording(recording, tmp_path / "a.npz")
    save_recording(recording, tmp_path / "b.npz")
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


def test_episodes_follow_each_other_with_a_gap(recording):
    assert recording.starts(gap=1.0) == (0.0, 7.0)
    assert recording.duration(gap=1.0) == pytest.approx(11.0)
    assert recording.starts(gap=0.0) == pytest.approx((0.0, 6 + 1 / 30))  # two episodes never share a frame


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"times": np.arange(121) / 10}, "episode spiral: times must step by 1/30 s"),
        ({"times": np.array([0.0, np.nan])}, "episode spiral: times must be finite"),
        ({"states": {}}, "missing lamp, car"),
        ({"plant_positions": np.zeros((3, 2))}, r"plant_positions must be finite, shape \(121, n_positions\)"),
        ({"readouts": {"error": Readout(np.zeros(4), "px")}}, "readout 'error' needs 121 values"),
        ({"lines": {"car": np.zeros((5, 3))}}, r"line 'car' must be finite, shape \(m, 2\)"),
    ],
)
def test_misfitting_episode_is_refused(recording, change, message):
    bad = dataclasses.replace(recording.episodes[1], **change)
    with pytest.raises(InputError, match=message):
        dataclasses.replace(recording, episodes=(recording.episodes[0], bad))


def test_states_of_another_shape_or_with_nan_are_refused(recording):
    last = recording.episodes[1]
    short = dataclasses.replace(last, states={**last.states, "car": last.states["car"][:-1]})
    with pytest.raises(InputError, match=r"states of car have shape \(120, 3\), \(121, 3\) needed"):
        dataclasses.replace(recording, episodes=(short,))
    holes = last.states["car"].copy()
    holes[5, 2] = np.nan
    with pytest.raises(InputError, match="episode spiral: states of car: heading is not a finite number"):
        dataclasses.replace(recording, episodes=(dataclasses.replace(last, states={**last.states, "car": holes}),))


def test_recording_without_episodes_is_refused(recording):
    with pytest.raises(InputError, match="it has no episodes"):
        dataclasses.replace(recording, episodes=())


def test_file_cut_short_anywhere_is_refused(recording, tmp_path):
    file = tmp_path / "run.npz"
    save_recording(recording, file)
    whole = file.read_bytes()
    for size in (0, 10, len(whole) // 2, len(whole) - 5):
        file.write_bytes(whole[:size])
        with pytest.raises(InputError, match=GOOD):
            load_recording(file)


def test_damaged_array_is_named(recording, tmp_path):
    file = tmp_path / "run.npz"
    save_recording(recording, file)
    with zipfile.ZipFile(file) as archive:
        entry = archive.getinfo("episode0.state1.npy")
    data = bytearray(file.read_bytes())
    middle = entry.header_offset + 60 + entry.compress_size // 2
    data[middle : middle + 20] = b"\xff" * 20
    file.write_bytes(bytes(data))
    with pytest.raises(InputError, match="field episode0.state1 is damaged"):
        load_recording(file)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda a: a.pop("episode1.times"), "field episode1.times is missing"),
        (lambda a: a.pop("contents"), "field contents is missing"),
        (lambda a: a.update({"episode0.times": np.array(["x"])}), "field episode0.times has values of type <U1"),
        (lambda a: a.update(contents=np.array("{")), "field contents is malformed"),
        (lambda a: a.update(contents=np.array(json.dumps({"format": "x"}))), "field contents is of format 'x'"),
        (lambda a: a.update({"episode0.state0": np.zeros((2, 2))}), r"states of lamp have shape \(2, 2\)"),
    ],
)
def test_malformed_field_is_named(recording, tmp_path, change, message):
    save_recording(recording, tmp_path / "run.npz")
    rewritten(tmp_path / "run.npz", change)
    with pytest.raises(InputError, match=message):
        load_recording(tmp_path / "run.npz")


def test_pickles_are_never_opened(tmp_path):
    stream = io.BytesIO()
    np.savez(stream, contents=np.array([{"format": "x"}], dtype=object))
    (tmp_path / "run.npz").write_bytes(stream.getvalue())
    with pytest.raises(InputError, match="field contents is damaged"):
        load_recording(tmp_path / "run.npz")


def test_other_files_are_refused(recording, tmp_path):
    with pytest.raises(InputError, match="there is no such recording"):
        load_recording(tmp_path / "none.npz")
    np.save(tmp_path / "array.npy", np.zeros(3))
    with pytest.raises(InputError, match="a bare array"):
        load_recording(tmp_path / "array.npy")
    with pytest.raises(InputError, match="a recording ends in .npz"):
        save_recording(recording, tmp_path / "run.zip")
