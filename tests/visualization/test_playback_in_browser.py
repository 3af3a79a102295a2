"""The playback in a real browser: at any time, also after going back, the scene is what the log says."""

import io

import numpy as np
import pytest
from PIL import Image
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RotationMatrix

from ichain_drake.visualization import linear_rgb
from ichain_drake.visualization.ribbon import spaced

HOT, COLD = np.array(linear_rgb((0.9, 0.2, 0.1))), np.array(linear_rgb((0.1, 0.2, 0.9)))


@pytest.fixture(scope="module")
def opened(browser, page):
    browser.complaints()
    browser.open(page.as_uri())
    return browser


def at(recording, time):
    """Index of the episode and fractional sample that the playback shows at a time."""
    starts = recording.starts()
    index = max(i for i, start in enumerate(starts) if start <= time)
    return index, min((time - starts[index]) * 30, len(recording.episodes[index].times) - 1)


def rotation(quaternion):
    x, y, z, w = quaternion
    return RotationMatrix(Quaternion(np.array([w, x, y, z]) / np.linalg.norm(quaternion)))


def angle(a, b):
    return abs(float((a.inverse() @ b).ToAngleAxis().angle()))


# Mid-frame, so that what switches at a frame is unambiguous; forwards, backwards and across episodes.
@pytest.mark.parametrize("time", [0.55, 4.05, 9.35, 1.25, 7.55])
def test_scene_equals_log_at_any_seek(opened, recording, diagram, time):
    opened.seek(time)
    i, sample = at(recording, time)
    episode, k = recording.episodes[i], int(sample)
    share = sample - k

    def logged(values):
        return values[k] if share == 0 else (1 - share) * values[k] + share * values[k + 1]

    # The car's sprite: px to metres, y downward, seen in the screen's frame.
    x, y, _ = logged(episode.states["car"])
    sprite = opened.node("drake/car/screen/sprite")
    assert sprite["position"][:2] == pytest.approx([(x - 400) * 1e-3, -(y - 300) * 1e-3], abs=2e-4)
    heading = 0.5 * sample / 30 + (0.0, 1.0)[i]  # as the recording was made
    assert angle(rotation(sprite["quaternion"]), RotationMatrix.MakeZRotation(-heading)) < np.deg2rad(0.15)

    # The path driven so far, of this episode only.
    xy = episode.states["car"][:, :2]
    kept = spaced(np.column_stack([xy * 1e-3, 0 * xy[:, 0]]), 2.5e-3 / 4)
    driven = opened.node(f"drake/car/screen/episode{i}/executed/<object>")["drawn"] // 6
    assert abs(driven - (np.searchsorted(kept, sample, side="right") - 1)) <= 1
    assert opened.node(f"drake/car/screen/episode{i}")["visible"]
    assert not opened.node(f"drake/car/screen/episode{1 - i}")["visible"]

    # Level, color, light.
    level = logged(episode.states["lamp"])[0]
    assert opened.node("drake/lamp/column")["scale"][2] == pytest.approx(level, abs=2e-3)
    color = opened.node("drake/lamp/column/water/<object>")["color"]
    assert color == pytest.approx(list(level * HOT + (1 - level) * COLD), abs=8e-3)
    assert opened.node("drake/lamp/light")["visible"] == bool(episode.states["lamp"][k, 1])

    # A body of the arm.
    plant = diagram.GetSubsystemByName("plant")
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, logged(episode.plant_positions))
    X_WB = plant.EvalBodyPoseInWorld(context, plant.GetBodyByName("lower"))
    lower = opened.node("drake/plant/two_link/lower")
    assert lower["position"] == pytest.approx(list(X_WB.translation()), abs=2e-4)
    assert angle(rotation(lower["quaternion"]), X_WB.rotation()) < np.deg2rad(0.15)

    # The read-out holds the last sample.
    lines = [line.split("\t") for line in opened.hud().splitlines()]
    shown = {line[0]: line[1] for line in lines if len(line) > 1}
    assert f"{episode.name} ({i + 1} of 2)" in [line[0] for line in lines]
    assert float(shown["time"]) == pytest.approx(episode.times[k], abs=6e-3)
    assert float(shown["error"]) == pytest.approx(episode.readouts["error"].values[k], abs=1e-3)
    assert shown["mode"] == episode.readouts["mode"].values[k]


def test_between_two_episodes_everything_stands_still(opened, recording):
    opened.seek(6.5)  # the first ends at 6 s, the second starts at 7 s
    x, y, _ = recording.episodes[0].states["car"][-1]
    position = opened.node("drake/car/screen/sprite")["position"]
    assert position[:2] == pytest.approx([(x - 400) * 1e-3, -(y - 300) * 1e-3], abs=2e-4)
    assert "eight" in opened.hud()


def test_plays_to_the_end_and_again_from_the_start(opened, recording):
    opened.seek(recording.duration() - 0.2)
    opened.driver.execute_async_script(
        "const done = arguments[0]; viewer.animator.mixer.timeScale = 4; ichain.play();"
        "const wait = () => viewer.animator.playing ? setTimeout(wait, 20) : done(1); wait()"
    )
    opened.frames("viewer.animator.mixer.timeScale = 0.01; ichain.play()")
    assert opened.js("return viewer.animator.time") < 1.0
    assert opened.js("return viewer.animator.playing")
    opened.frames("ichain.pause(); viewer.animator.mixer.timeScale = 1")


def test_deep_link_opens_at_a_time_and_stands_still(browser, page):
    browser.open(f"{page.as_uri()}#t=3.5")
    assert browser.js("return viewer.animator.time") == pytest.approx(3.5)
    assert not browser.js("return viewer.animator.playing")
    browser.frames("location.hash = 't=8'")
    browser.frames()
    assert browser.js("return viewer.animator.time") == pytest.approx(8.0)


def test_something_is_drawn_and_no_script_fails(opened):
    opened.seek(3.0)
    opened.frames()
    image = Image.open(io.BytesIO(opened.driver.get_screenshot_as_png())).convert("RGB")
    pixels = np.asarray(image).astype(int).reshape(-1, 3)
    assert len(np.unique(pixels // 16, axis=0)) > 40  # noise-free, an empty scene has a handful of colors
    orange = (pixels[:, 0] - pixels[:, 2] > 90) & (pixels[:, 0] > 150)
    assert orange.mean() > 5e-4  # the arm's upper link and the path driven
    loaded = opened.js("return performance.getEntriesByType('resource').map(entry => entry.name)")
    assert [name for name in loaded if not name.startswith(("data:", "blob:", "file:"))] == []
    assert opened.complaints() == []
