"""Scene, tracks and the meshes they draw."""

import numpy as np
import pytest
import umsgpack
from PIL import Image
from pydrake.geometry import Box, Rgba
from pydrake.math import RigidTransform, RotationMatrix

from ichain_drake.errors import InputError
from ichain_drake.visualization import Drawing, EpisodeDrawing, GameScreen, Scene, linear_rgb
from ichain_drake.visualization.ribbon import ribbon, spaced
from ichain_drake.visualization.sprites import car_sprite, playfield, ship_sprite
from ichain_drake.visualization.tracks import Track, TrackKind, needed_keyframes, pack_animation


@pytest.fixture
def scene(meshcat):
    meshcat.Delete()
    return Scene(meshcat)


def test_changes_are_kept_on_frames_of_a_thirtieth(scene):
    scene.shape("a", Box(1, 1, 1), (1, 0, 0))
    for k in range(301):  # 10 k / 30 is not k / 3 in floating point: every frame must still be its own
        scene.pose("a", RigidTransform([np.sin(k), 0, 0]), k / 30)
    assert scene.tracks["/drake/a"][0].frames == list(range(301))


def test_first_change_shows_at_once_and_later_ones_do_not(scene, meshcat):
    scene.shape("a", Box(1, 1, 1), Rgba(1, 0, 0))
    scene.pose("a", RigidTransform([0, 0, 1.0]), 0.0)
    scene.pose("a", RigidTransform([0, 0, 2.0]), 1.0)
    transform = umsgpack.unpackb(meshcat._GetPackedTransform("a"))
    assert transform["matrix"][14] == 1.0


def test_live_scene_shows_every_change_and_keeps_none(meshcat):
    live = Scene(meshcat, live=True)
    live.shape("a", Box(1, 1, 1), Rgba(1, 0, 0))
    part = live.under("car")
    for z in (1.0, 2.0):
        part.pose("b", RigidTransform([0, 0, z]), z)
        part.visible("b", z < 1.5, z)
    assert umsgpack.unpackb(meshcat._GetPackedTransform("car/b"))["matrix"][14] == 2.0
    assert umsgpack.unpackb(meshcat._GetPackedProperty("car/b", "visible"))["value"] is False
    assert live.tracks == {}


def test_parts_of_a_scene_keep_their_changes_together(scene):
    scene.under("car").under("screen").visible("x", True, 0.0)
    assert list(scene.tracks) == ["/drake/car/screen/x"]


def test_going_back_in_time_is_an_error(scene):
    scene.visible("a", True, 1.0)
    with pytest.raises(ValueError, match="frame 15 comes after frame 30"):
        scene.visible("a", True, 0.5)


def test_a_repeated_value_keeps_its_last_frame_before_a_change():
    track = Track(TrackKind(".x", "number", 1, 1e-6))
    for frame, value in enumerate([1, 1, 1, 1, 5, 5, 5]):
        track.put(frame, (float(value),))
    assert track.frames == [0, 3, 4, 6]


@pytest.mark.parametrize("seed", range(3))
def test_dropped_keyframes_are_given_back_within_the_tolerance(seed):
    frames = np.arange(400)
    noise = np.random.default_rng(seed).normal(0, 0.02, (400, 3))
    values = np.column_stack([np.sin(frames / 30), np.clip(frames / 50, 1, 3), 0 * frames]) + noise
    keep = needed_keyframes(frames, values, 0.05)
    back = np.column_stack([np.interp(frames, frames[keep], column[keep]) for column in values.T])
    assert np.linalg.norm(back - values, axis=1).max() <= 0.05 + 1e-12
    assert keep.sum() < 300


def test_constant_track_keeps_one_keyframe():
    assert needed_keyframes(np.arange(50), np.ones((50, 2)), 1e-6).sum() == 1


def test_packed_animation_is_read_by_meshcats_own_codec():
    number = Track(TrackKind(".x", "number", 1, 1e-6), [0, 300], [(0.5,), (-0.25,)])
    vector = Track(TrackKind(".scale", "vector3", 3, 1e-6), [3, 70000], [(1, 2, 3), (4, 5, 6)])
    boolean = Track(TrackKind(".visible", "boolean", 1, 0.0), [0, 5, 6], [(1.0,), (1.0,), (0.0,)])
    read = umsgpack.unpackb(pack_animation({"/drake/a": [number, vector], "/drake/b": [boolean]}, 30.0, 70000))
    assert read["animations"][0]["clip"] == {
        "fps": 30.0,
        "name": "default",
        "duration": pytest.approx(70000 / 30),
        "tracks": [
            {"name": ".x", "type": "number", "keys": [{"time": 0, "value": 0.5}, {"time": 300, "value": -0.25}]},
            {
                "name": ".scale",
                "type": "vector3",
                "keys": [{"time": 3, "value": [1, 2, 3]}, {"time": 70000, "value": [4, 5, 6]}],
            },
        ],
    }
    keys = read["animations"][1]["clip"]["tracks"][0]["keys"]
    assert [(k["time"], k["value"]) for k in keys] == [(0, True), (6, False)]


def test_ribbon_is_as_wide_as_asked_and_faces_the_normal():
    t = np.linspace(0, 2, 40)
    points = np.column_stack([np.cos(t), np.sin(t), 0 * t + 0.3])
    vertices, triangles = ribbon(points, 0.1, (0, 0, 1))
    a, b = vertices[:, 0::2], vertices[:, 1::2]
    assert np.linalg.norm(a - b, axis=0) == pytest.approx(np.full(40, 0.1), rel=2e-3)
    np.testing.assert_allclose(((a + b) / 2).T, points, atol=1e-12)
    corners = vertices[:, triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0], axis=0)
    assert (normals[2] > 0).all()


def test_spaced_points_are_apart():
    points = np.column_stack([np.linspace(0, 1, 101), np.zeros(101), np.zeros(101)])
    kept = spaced(points, 0.095)
    assert kept[0] == 0 and np.all(np.diff(points[kept, 0]) >= 0.095)


def test_line_of_another_shape_is_refused(scene):
    with pytest.raises(InputError, match=r"points of shape \(n, 3\) with n >= 2 needed; shape \(3, 7\) given"):
        scene.line("l", np.zeros((3, 7)), 0.01, (1, 1, 1))


def test_growing_line_counts_up_and_one_that_never_moves_is_none(scene):
    points = np.column_stack([np.linspace(0, 1, 31), np.zeros(31), np.zeros(31)])
    scene.growing_line("l", points, np.arange(31) / 30, 0.02, (1, 1, 1))
    track = scene.tracks["/drake/l/<object>"][0]
    assert (track.frames[-1], track.values[-1]) == (30, (30.0,))
    scene.growing_line("still", np.zeros((31, 3)), np.arange(31) / 30, 0.02, (1, 1, 1))
    assert "/drake/still/<object>" not in scene.tracks


def test_linear_rgb_of_srgb():
    assert linear_rgb((0.0, 1.0, 0.5)) == pytest.approx([0, 1, 0.2140], abs=1e-4)
    assert linear_rgb(Rgba(0.02, 0.5, 1, 0.3)) == pytest.approx([0.02 / 12.92, 0.2140, 1], abs=1e-4)


@pytest.mark.parametrize("y_down", [True, False])
def test_screen_maps_pixels_and_heading(y_down):
    screen = GameScreen((800, 600), 0.001, RigidTransform(), y_down=y_down)
    flip = -1 if y_down else 1
    assert screen.points([[400, 300], [500, 350]]) == pytest.approx(np.array([[0, 0, 0], [0.1, flip * 0.05, 0]]))
    X = screen.sprite_pose(np.array([500.0, 350.0, 0.3]))
    assert X.rotation().matrix() == pytest.approx(RotationMatrix.MakeZRotation(flip * 0.3).matrix())
    # The sprite looks where the object goes: a step along the heading moves it along its own x.
    step = np.array([500.0 + np.cos(0.3), 350.0 + np.sin(0.3), 0.3])
    moved = screen.sprite_pose(step).translation() - X.translation()
    assert X.rotation().inverse() @ moved == pytest.approx([0.001, 0, 0], abs=1e-12)


def test_screen_that_is_none_is_refused():
    with pytest.raises(InputError, match="must be positive"):
        GameScreen((800, 0), 0.001, RigidTransform())
    with pytest.raises(InputError, match="columns are x, y and"):
        GameScreen((800, 600), 0.001, RigidTransform(), columns=(1,))


def test_only_drawings_that_want_episodes_get_them():
    screen = GameScreen((8, 6), 0.001, RigidTransform())
    assert isinstance(screen, EpisodeDrawing)

    class Plain:
        def setup(self, scene): ...

        def update(self, scene, time, state): ...

    plain: Drawing = Plain()
    assert not isinstance(plain, EpisodeDrawing)


def test_sprites_have_what_they_promise():
    car = np.asarray(car_sprite())
    assert car.shape == (80, 160, 4)
    assert car[0, 0, 3] < 60 and car[40, 80, 3] == 255  # clear corner, solid middle
    nose, tail = car[40, 140, :3].astype(int), car[25, 15, :3].astype(int)
    assert nose.sum() > tail.sum()  # head lights point to +x
    assert np.asarray(car_sprite(opacity=0.3))[40, 80, 3] == pytest.approx(77, abs=2)
    down, up = playfield(200, 100, y_down=True), playfield(200, 100, y_down=False)
    assert isinstance(down, Image.Image) and down.size == (1600, 800)
    # Whatever the unit, there is a grid of the same density.
    assert np.asarray(playfield(20, 10, y_down=True)).std() == pytest.approx(np.asarray(down).std(), rel=0.2)
    ship = np.asarray(ship_sprite(opacity=0.5)).astype(int)
    assert ship.shape == (60, 240, 4) and ship[30, 120, 3] == pytest.approx(127, abs=2)
    assert (ship[:, 225, 3] > 100).sum() < 0.5 * (ship[:, 40, 3] > 100).sum()  # the bow is at the right
    assert np.asarray(down).mean() == pytest.approx(np.asarray(up).mean(), rel=0.05)
