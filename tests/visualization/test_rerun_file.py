"""A recording for rerun, read back: signals to the last bit, and where everything in the scene is."""

import dataclasses
import sys

import numpy as np
import pytest
from pydrake.common import MemoryFile
from pydrake.geometry import Box, Capsule, Cylinder, Ellipsoid, InMemoryMesh, Mesh, MeshcatCone, Sphere
from pydrake.math import RigidTransform, RotationMatrix
from rrd import read_rrd

from ichain_drake.errors import InputError
from ichain_drake.visualization import linear_rgb
from ichain_drake.visualization.noted_scene import Noted
from ichain_drake.visualization.rerun_file import write_rerun
from ichain_drake.visualization.rerun_scene import send_scene
from ichain_drake.visualization.scene import Scene, srgb

rr = pytest.importorskip("rerun", reason="rerun is missing: pip install 'ichain_drake[rerun]'")

SPEED = ("measured", "car", "speed")


@pytest.fixture(scope="module")
def signals(recording):
    return [{SPEED: np.random.default_rng(len(e.times)).standard_normal(len(e.times))} for e in recording.episodes]


@pytest.fixture(scope="module")
def found(recording, drawings, diagram, signals, tmp_path_factory):
    file = tmp_path_factory.mktemp("rerun") / "run.rrd"
    write_rerun(recording, drawings(), file, signals=signals, units={SPEED: "px/s"}, plant=diagram)
    return read_rrd(file)


def numbers(found, entity):
    times, values = found[entity, "Scalars:scalars"]
    return times, np.array(values)[:, 0]


def test_signals_are_the_recordings_to_the_last_bit(recording, signals, found):
    starts = recording.starts()
    times = np.concatenate([s + np.arange(len(e.times)) / 30 for s, e in zip(starts, recording.episodes, strict=True)])
    wanted = {
        f"/true/{name}/{v.name}": [e.states[name][:, i] for e in recording.episodes]
        for name, space in recording.spaces.items()
        for i, v in enumerate(space.variables)
    }
    wanted["/active/lamp->car"] = [e.active["lamp->car"] for e in recording.episodes]
    wanted["/shown/error"] = [e.readouts["error"].values for e in recording.episodes]
    wanted["/measured/car/speed"] = [s[SPEED] for s in signals]
    for entity, values in wanted.items():
        at, got = numbers(found, entity)
        np.testing.assert_allclose(at, times, atol=1e-9, err_msg=entity)
        np.testing.assert_array_equal(got, np.concatenate(values), err_msg=entity)
    assert found["/measured/car/speed", "SeriesLines:names"][1] == [["car/speed [px/s]"]]
    assert found["/true/lamp/on", "SeriesLines:names"][1] == [["lamp/on"]]


def test_texts_are_written_where_they_change(found):
    times, texts = found["/log/mode", "TextLog:text"]
    assert [t[0] for t in texts] == ["drive", "stop"] * 2
    np.testing.assert_allclose(times, [0, 3, 7, 10])
    times, names = found["/log/episode", "TextLog:text"]
    assert ([n[0] for n in names], times.tolist()) == (["eight", "spiral"], [0.0, 7.0])


def test_bodies_of_the_arm_and_the_car_are_where_the_log_says(recording, diagram, found):
    plant = diagram.GetSubsystemByName("plant")
    context = plant.CreateDefaultContext()
    times, places = found["/scene/plant/two_link/lower", "Transform3D:translation"]
    turned, turns = found["/scene/plant/two_link/lower", "Transform3D:quaternion"]
    first = recording.episodes[0]
    for k in (0, 30, 180):
        plant.SetPositions(context, first.plant_positions[k])
        wanted = plant.EvalBodyPoseInWorld(context, plant.GetBodyByName("lower"))
        place = places[np.searchsorted(times, k / 30 + 1e-6) - 1][0]
        np.testing.assert_allclose(place, wanted.translation(), atol=1e-6)
        x, y, z, w = turns[np.searchsorted(turned, k / 30 + 1e-6) - 1][0]
        turn = wanted.rotation().ToQuaternion().wxyz()
        assert abs(np.dot(turn, [w, x, y, z])) == pytest.approx(1, abs=1e-6)
    times, places = found["/scene/car/screen/sprite", "Transform3D:translation"]
    x = first.states["car"][30, 0]
    assert places[np.searchsorted(times, 1 + 1e-6) - 1][0][0] == pytest.approx((x - 400) / 1000, abs=1e-6)


def test_level_light_and_colour_change(recording, found):
    first = recording.episodes[0]
    times, scales = found["/scene/lamp/column", "Transform3D:scale"]
    assert scales[np.searchsorted(times, 2 + 1e-6) - 1][0][2] == pytest.approx(first.states["lamp"][60, 0], abs=1e-6)
    times, scales = found["/scene/lamp/light", "Transform3D:scale"]
    for second, shown in ((0, False), (1.5, True), (2.9, True), (3, False), (5, True), (7, False)):
        scale = scales[np.searchsorted(times, second + 1e-6) - 1][0]
        assert scale == pytest.approx([1.0 if shown else 1e-4] * 3), second
    times, colors = found["/scene/lamp/column/water", "Boxes3D:colors"]
    level = first.states["lamp"][60, 0]
    wanted = srgb(level * linear_rgb((0.9, 0.2, 0.1)) + (1 - level) * linear_rgb((0.1, 0.2, 0.9)))
    packed = colors[np.searchsorted(times, 2 + 1e-6) - 1][0]
    assert [packed >> 24, packed >> 16 & 255, packed >> 8 & 255] == pytest.approx(wanted * 255, abs=1)
    half = found["/scene/lamp/column/water", "Boxes3D:half_sizes"][1][0][0]
    assert half == pytest.approx([0.05, 0.05, 0.1])


def test_of_what_moves_each_row_is_whole(found):
    """The viewer takes the last row of a transform alone: what is not in it counts as not given."""
    moving = [
        entity for entity, name in found if name == "Transform3D:translation" and found[entity, name][0] is not None
    ]
    assert len(moving) > 5
    for entity in moving:
        whole = [found[entity, f"Transform3D:{name}"] for name in ("translation", "quaternion", "scale")]
        assert all(row for _, rows in whole for row in rows), entity
        assert all(np.array_equal(times, whole[0][0]) for times, _ in whole), entity
    light = found["/scene/lamp/light", "Transform3D:translation"][1]
    assert light == [[pytest.approx([0.3, 0, 0.1])]] * len(light)  # where it was put once


def test_commanded_paths_are_drawn_and_growing_ones_left_out(found):
    entities = {entity for entity, _ in found}
    assert "/scene/car/screen/episode0/commanded" in entities
    assert ("/scene/car/screen/episode0/executed", "Mesh3D:vertex_positions") not in found
    corners = found["/scene/car/screen/field", "Mesh3D:vertex_positions"][1][0]
    assert corners[0] == pytest.approx([-0.4, -0.3, 0])
    picture = found["/scene/car/screen/field", "Mesh3D:albedo_texture_format"][1][0][0]
    assert picture["width"] * 3 == picture["height"] * 4
    assert found["/scene/car/screen/field", "Mesh3D:vertex_texcoords"][1][0][0] == [0, 1]
    assert ("/scene/ground", "Boxes3D:half_sizes") in found


def test_every_shape_is_where_drake_has_it(tmp_path):
    noted = Noted()
    scene = Scene(noted)
    obj = Mesh(InMemoryMesh(mesh_file=MemoryFile(b"v 0 0 0", ".obj", "a")), scale3=[1, 2, 3])
    gltf = Mesh(InMemoryMesh(mesh_file=MemoryFile(b"{}", ".gltf", "a")), scale3=[1, 2, 3])
    vtk = Mesh(InMemoryMesh(mesh_file=MemoryFile(b"", ".vtk", "a")))
    pose = RigidTransform(RotationMatrix.MakeZRotation(0.5), [1, 2, 3])
    shapes = {
        "box": Box(1, 2, 3), "ball": Sphere(1), "egg": Ellipsoid(1, 2, 3), "rod": Cylinder(1, 2), "pill": Capsule(1, 2),
        "obj": obj, "gltf": gltf, "vtk": vtk, "cone": MeshcatCone(1, 1, 1),
    }  # fmt: skip
    for name, shape in shapes.items():
        scene.shape(name, shape, (1.0, 0.5, 0.0, 0.5), pose)
    stream = rr.RecordingStream("test")
    content = stream.binary_stream()
    send_scene(rr, stream, noted, scene)
    (tmp_path / "a.rrd").write_bytes(content.read())
    found = {key: values[0][0] if values[0] else None for key, (_, values) in read_rrd(tmp_path / "a.rrd").items()}
    assert found["/scene/box", "Boxes3D:half_sizes"] == [0.5, 1, 1.5]
    assert found["/scene/ball", "Ellipsoids3D:half_sizes"] == [1, 1, 1]
    assert found["/scene/egg", "Ellipsoids3D:half_sizes"] == [1, 2, 3]
    assert (found["/scene/rod", "Cylinders3D:lengths"], found["/scene/rod", "Cylinders3D:radii"]) == (2, 1)
    assert (found["/scene/pill", "Capsules3D:lengths"], found["/scene/pill", "Capsules3D:radii"]) == (2, 1)
    assert found["/scene/pill", "Capsules3D:translations"] == [0, 0, -1]  # from there on, along z
    assert found["/scene/box", "Boxes3D:colors"] == 0xFF800080
    assert found["/scene/obj/mesh", "Transform3D:scale"] == [1, 2, 3]
    assert found["/scene/gltf/mesh", "Transform3D:scale"] == [1, 3, 2]
    assert found["/scene/gltf/mesh", "Transform3D:quaternion"] == pytest.approx([0.5**0.5, 0, 0, 0.5**0.5])
    assert found["/scene/gltf/mesh", "Asset3D:media_type"] == "model/gltf+json"
    assert not [entity for entity, _ in found if entity.startswith("/scene/vtk/")]
    for name in shapes:
        assert found[f"/scene/{name}", "Transform3D:translation"] == [1, 2, 3]


def test_what_can_not_be_written_is_told_in_one_line(recording, drawings, signals, tmp_path, monkeypatch):
    def told(file, **more):
        with pytest.raises(InputError) as error:
            write_rerun(recording, {**drawings(), **more}, file, signals=signals, units={})
        assert "\n" not in str(error.value)
        return str(error.value)

    assert "ends in .rrd" in told(tmp_path / "a.html")
    assert "drawing of 'ghost'" in told(tmp_path / "a.rrd", ghost=drawings()["lamp"])
    assert "no such" in told(tmp_path / "none" / "a.rrd").lower()
    monkeypatch.setitem(sys.modules, "rerun", None)
    assert "pip install 'ichain_drake[rerun]'" in told(tmp_path / "a.rrd")
    assert list(tmp_path.iterdir()) == []


def test_one_sample_without_an_arm_is_written(recording, drawings, tmp_path):
    first = recording.episodes[0]
    one = dataclasses.replace(
        first, times=first.times[:1], states={n: v[:1] for n, v in first.states.items()}, plant_positions=None,
        readouts={}, active={}, strips={},
    )  # fmt: skip
    short = dataclasses.replace(recording, episodes=(one,))
    write_rerun(short, drawings(), tmp_path / "a.rrd", signals=[{}], units={})
    assert numbers(read_rrd(tmp_path / "a.rrd"), "/true/car/x")[1].tolist() == [first.states["car"][0, 0]]
