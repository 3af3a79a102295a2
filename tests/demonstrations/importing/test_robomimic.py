"""HDF5 as robomimic writes it, and HDF5 that is not meant well."""

import json
from pathlib import Path

import numpy as np
import pytest

from ichain_drake.demonstrations.importing import import_logs, parse_map
from ichain_drake.errors import InputError

h5py = pytest.importorskip("h5py", reason="h5py is missing: pip install 'ichain_drake[logs]'")

MAP = parse_map({"columns": {"obs/object[1]": "cube.y [m]", "actions[0]": "command.x"}}, "m")


@pytest.fixture
def file(tmp_path: Path) -> Path:
    name = tmp_path / "low_dim.hdf5"
    with h5py.File(name, "w") as f:
        data = f.create_group("data")
        data.attrs["env_args"] = json.dumps({"env_name": "Lift", "env_kwargs": {"control_freq": 20}})
        for i in range(11):
            demo = data.create_group(f"demo_{i}")
            demo.attrs["num_samples"] = 3
            demo.create_dataset("actions", data=np.full((3, 7), i, dtype=np.float64), compression="gzip")
            demo.create_dataset("obs/object", data=np.arange(6).reshape(3, 2) + i)
        f.create_group("mask")
    return name


def told(file: Path, columns: dict[str, str], **more: object) -> str:
    with pytest.raises(InputError) as error:
        import_logs("robomimic", file, parse_map({"columns": columns, **more}, "m"))
    assert "\n" not in str(error.value)
    return str(error.value)


def test_every_demonstration_is_a_piece_in_order_of_its_number(file: Path) -> None:
    pieces = import_logs("robomimic", file, MAP)
    assert [p.name for p in pieces] == [f"demo_{i}" for i in range(11)]
    np.testing.assert_allclose(pieces[10].table["time"], [0, 0.05, 0.1])
    np.testing.assert_array_equal(pieces[10].table["cube.y"], [11, 13, 15])
    np.testing.assert_array_equal(pieces[10].table["command.x"], [10, 10, 10])
    assert pieces[10].units == {"cube.y": "m"}


def test_times_come_from_the_map_where_the_file_is_silent(file: Path) -> None:
    with h5py.File(file, "a") as f:
        f["data"].attrs["env_args"] = "no json"
    assert "nothing tells how far apart its rows are; give rate" in told(file, {"actions[0]": "cube.y"})
    timed = parse_map({"columns": {"actions[0]": "command.x"}, "time": "obs/object[0]"}, "m")
    np.testing.assert_array_equal(import_logs("robomimic", file, timed)[2].table["time"], [0, 2, 4])
    rated = parse_map({"columns": {"actions[0]": "command.x"}, "rate": 4}, "m")
    assert import_logs("robomimic", file, rated)[0].period == 0.25


def test_what_is_not_there_is_told(file: Path, tmp_path: Path) -> None:
    assert "demo_0: it has no data set obs/eef; it has actions, obs" in told(file, {"obs/eef": "cube.y"})
    assert "it has no data set obs/../actions" in told(file, {"obs/../actions[0]": "cube.y"})
    assert "actions has 7 numbers; say which" in told(file, {"actions": "cube.y"})
    assert "places 0 to 6" in told(file, {"actions[7]": "cube.y"})
    assert "there is no such file" in told(tmp_path / "none.hdf5", {"actions": "cube.y"})
    with h5py.File(file, "w") as f:
        f.create_group("data").attrs["env_args"] = json.dumps({"env_kwargs": {"control_freq": 20}})
    assert "holds no demonstration" in told(file, {"actions": "cube.y"})
    with h5py.File(file, "w") as f:
        f["data"] = 1.0
    assert "it has no group data" in told(file, {"actions": "cube.y"})
    file.write_bytes(b"\x89HDF\r\n\x1a\n and no more")
    assert "can't read it as HDF5" in told(file, {"actions": "cube.y"})


def test_links_and_files_elsewhere_are_not_followed(file: Path, tmp_path: Path) -> None:
    secret = tmp_path / "secret.hdf5"
    with h5py.File(secret, "w") as f:
        f["d"] = np.ones(3)
    (tmp_path / "raw").write_bytes(b"\0" * 24)
    with h5py.File(file, "a") as f:
        demo = f["data/demo_0"]
        demo["outside"] = h5py.ExternalLink(str(secret), "/d")
        demo["soft"] = h5py.SoftLink("/data/demo_1/actions")
        demo.create_dataset("raw", (3,), "f8", external=[(str(tmp_path / "raw"), 0, 24)])
        layout = h5py.VirtualLayout((3,), "f8")
        layout[:] = h5py.VirtualSource(str(secret), "d", (3,))
        demo.create_virtual_dataset("virtual", layout)
    for name in ("outside", "soft"):
        assert f"{name} is a link to somewhere else" in told(file, {name: "cube.y"})
    for name in ("raw", "virtual"):
        assert f"{name} is kept in other files" in told(file, {name: "cube.y"})


def test_what_claims_too_much_or_holds_no_numbers_is_not_read(file: Path) -> None:
    with h5py.File(file, "a") as f:
        demo = f["data/demo_0"]
        demo.create_dataset("huge", (10**12,), "f8", chunks=(1000,))
        demo["text"] = np.array([b"a", b"b", b"c"])
        demo["short"] = np.ones(2)
        demo["one"] = 1.0
    assert "huge claims 1000000000000 numbers" in told(file, {"huge": "cube.y"})
    for name in ("text", "one"):
        assert f"{name} holds no rows of numbers" in told(file, {name: "cube.y"})
    assert "its data sets have 2, 3 rows" in told(file, {"short": "cube.y", "actions[0]": "cube.x"})
