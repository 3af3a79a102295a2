"""The playback file, decoded without a browser, and what writing one refuses."""

import dataclasses
import json
import re
import weakref

import numpy as np
import pytest
from full_disk import room_for
from pydrake.geometry import Meshcat
from pydrake.math import RigidTransform
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ZeroOrderHold

from ichain_drake.errors import InputError
from ichain_drake.files import write_whole
from ichain_drake.visualization import HandDrawing, load_recording, playback, save_recording, write_playback


def interpolate(keys, frames):
    times = [key["time"] for key in keys]
    return np.array([np.interp(frames, times, column) for column in np.array([key["value"] for key in keys]).T]).T


def test_page_needs_no_network_and_no_server(page):
    text = page.read_text(encoding="utf-8")
    assert "<title>test_game: playback</title>" in text
    assert re.search(r"<(script|link|img|iframe)[^>]*\s(src|href)=", text) is None
    assert text.count("handle_command_bytearray(new Uint8Array(buffer))") == 0  # all inside the compressed part


def test_car_track_reproduces_every_logged_sample(recording, tracks):
    keys = tracks["/drake/car/screen/sprite"][".position"]
    samples = sum(len(e.times) for e in recording.episodes)
    assert len(keys) < samples  # thinned
    for episode, start in zip(recording.episodes, recording.starts(), strict=True):
        frames = round(start * 30) + np.arange(len(episode.times))
        want = (episode.states["car"][:, :2] - [400, 300]) * [1e-3, -1e-3]
        assert np.abs(interpolate(keys, frames)[:, :2] - want).max() < 1.2e-4


def test_arm_track_reproduces_every_logged_sample(recording, diagram, tracks):
    plant = diagram.GetSubsystemByName("plant")
    context = plant.CreateDefaultContext()
    keys = tracks["/drake/plant/two_link/lower"][".position"]
    episode, first = recording.episodes[1], round(recording.starts()[1] * 30)
    for k in range(len(episode.times)):
        plant.SetPositions(context, episode.plant_positions[k])
        want = plant.EvalBodyPoseInWorld(context, plant.GetBodyByName("lower")).translation()
        assert np.abs(interpolate(keys, first + k) - want).max() < 1.2e-4


def test_fixed_bodies_have_no_track(tracks):
    assert sorted(path for path in tracks if path.startswith("/drake/plant")) == [
        "/drake/plant/two_link/lower",
        "/drake/plant/two_link/upper",
    ]


def test_light_switches_at_the_logged_frame(tracks):
    assert [(k["time"], k["value"]) for k in tracks["/drake/lamp/light"][".visible"][:3]] == [
        (0, False),
        (45, True),
        (90, False),
    ]


def test_quaternions_take_the_short_way(tracks):
    q = np.array([key["value"] for key in tracks["/drake/car/screen/sprite"][".quaternion"]])
    assert (np.sum(q[1:] * q[:-1], axis=1) >= 0).all()
    assert np.abs(np.linalg.norm(q, axis=1) - 1).max() < 1e-4


def test_log_in_the_page_is_the_recording(recording, records):
    log = json.loads(records[0])
    assert [(e["name"], e["start"], e["time"]) for e in log["episodes"]] == [("eight", 0.0, 2.0), ("spiral", 7.0, 0.0)]
    assert [entry["label"] for entry in log["legend"]] == ["lamp", "commanded path", "executed path"]
    car = next(o for o in log["objects"] if o["name"] == "car")
    assert car["variables"][0]["values"][1] == pytest.approx(recording.episodes[1].states["car"][:, 0], abs=1e-3)


def test_same_recording_gives_same_page(recording, drawings, diagram, page, tmp_path):
    write_playback(recording, drawings(), tmp_path / "again.html", plant=diagram)
    assert (tmp_path / "again.html").read_bytes() == page.read_bytes()


def test_loaded_recording_gives_same_page(recording, drawings, diagram, page, tmp_path):
    save_recording(recording, tmp_path / "run.npz")
    write_playback(load_recording(tmp_path / "run.npz"), drawings(), tmp_path / "again.html", plant=diagram)
    assert (tmp_path / "again.html").read_bytes() == page.read_bytes()


def test_one_sample_without_arm_and_with_a_hand_is_written(recording, drawings, inflated, tmp_path):
    first = recording.episodes[0]
    one = dataclasses.replace(
        first,
        times=first.times[:1],
        states={name: value[:1] for name, value in first.states.items()},
        plant_positions=None,
        readouts={},
        active={},
        strips={},
    )
    hand = HandDrawing(lambda state: (RigidTransform([state[0], 0, 0.2]), 0.04))
    file = tmp_path / "one.html"
    write_playback(dataclasses.replace(recording, episodes=(one,)), {**drawings(), "lamp": hand}, file)
    paths = [a for a in inflated(file) if b"/drake/lamp/hand/left/finger" in a]
    assert paths and file.stat().st_size > 1e6


def test_unwritable_places_are_refused(recording, drawings, tmp_path):
    with pytest.raises(InputError, match="there is no folder"):
        write_playback(recording, drawings(), tmp_path / "none" / "run.html")
    with pytest.raises(InputError, match="a playback ends in .html"):
        write_playback(recording, drawings(), tmp_path / "run.htm")
    (tmp_path / "taken.html").mkdir()
    with pytest.raises(InputError, match=r"taken.html: can't write .* kB there \(Is a directory\)"):
        write_playback(recording, {}, tmp_path / "taken.html")
    assert [p.name for p in tmp_path.iterdir()] == ["taken.html"]


def test_full_disk_leaves_the_old_file_and_nothing_else(tmp_path):
    file = tmp_path / "run.html"
    file.write_bytes(b"old")
    with room_for(1000), pytest.raises(InputError, match=r"run.html: can't write .* kB there \(File too large\)"):
        write_whole(file, bytes(100_000))
    assert [p.name for p in tmp_path.iterdir()] == ["run.html"]
    assert file.read_bytes() == b"old"


def test_who_keeps_the_error_keeps_no_scene(recording, drawings, tmp_path, monkeypatch):
    """Any thread may delete an error; Meshcat ends the process if that is not the main one."""
    held = []

    class Noted(Meshcat):
        def __init__(self, *given):
            super().__init__(*given)
            held.append(weakref.ref(self))

    monkeypatch.setattr(playback, "Meshcat", Noted)
    with pytest.raises(InputError, match="drawing of 'boat'") as error:
        write_playback(recording, {"boat": drawings()["car"]}, tmp_path / "run.html")
    assert [scene() for scene in held] == [None], error


def test_misfits_are_refused(recording, drawings, diagram, tmp_path):
    file = tmp_path / "run.html"
    with pytest.raises(InputError, match="drawing of 'boat': the recording's objects are lamp, car"):
        write_playback(recording, {"boat": drawings()["car"]}, file)
    with pytest.raises(InputError, match="one MultibodyPlant needed, it has 0"):
        builder = DiagramBuilder()
        builder.AddSystem(ZeroOrderHold(0.1, 1))
        write_playback(recording, {}, file, plant=builder.Build())
    wide = dataclasses.replace(recording.episodes[0], plant_positions=np.zeros((181, 5)))
    with pytest.raises(InputError, match="episode eight: plant_positions have 5 columns, the plant 2"):
        write_playback(dataclasses.replace(recording, episodes=(wide,)), {}, file, plant=diagram)
    none = dataclasses.replace(recording.episodes[0], plant_positions=None)
    with pytest.raises(InputError, match="episode eight: a plant is to be drawn, but no plant_positions"):
        write_playback(dataclasses.replace(recording, episodes=(none,)), {}, file, plant=diagram)
    assert not file.exists()
