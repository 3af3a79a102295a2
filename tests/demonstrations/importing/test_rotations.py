"""Quaternions of logs as angles: Drake's, from every format, and what is none."""

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RollPitchYaw, RotationMatrix
from small_mcap import write_json

from ichain_drake.demonstrations.importing import import_logs, parse_map
from ichain_drake.demonstrations.overview import inferred_graph
from ichain_drake.demonstrations.reading import prepare
from ichain_drake.errors import InputError

ANGLES = {"roll": "cup.roll [rad]", "pitch": "cup.pitch [rad]", "yaw": "cup.yaw [deg]"}


def turned(count: int, seed: int = 0) -> np.ndarray:
    """Unit quaternions x, y, z, w of either sign, shape (count, 4)."""
    numbers = np.random.default_rng(seed).standard_normal((count, 4))
    return numbers / np.linalg.norm(numbers, axis=1, keepdims=True)


def drake(quaternions: np.ndarray) -> np.ndarray:
    """Roll, pitch, yaw by Drake [rad], shape (n, 3)."""
    return np.array([RollPitchYaw(Quaternion(wxyz=np.roll(q / np.linalg.norm(q), 1))).vector() for q in quaternions])


def hdf5_file(folder: Path, numbers: np.ndarray) -> Path:
    """As robomimic keeps rows."""
    h5py = pytest.importorskip("h5py", reason="h5py is missing: pip install 'ichain_drake[logs]'")
    with h5py.File(folder / "a.hdf5", "w") as file:
        file["data/demo_0/obs/turned"] = numbers
    return folder / "a.hdf5"


def minari_file(folder: Path, numbers: np.ndarray) -> Path:
    h5py = pytest.importorskip("h5py", reason="h5py is missing: pip install 'ichain_drake[logs]'")
    with h5py.File(folder / "main_data.hdf5", "w") as file:
        file["episode_0/obs/turned"] = numbers
    return folder


def lerobot_set(folder: Path, numbers: np.ndarray) -> Path:
    import pandas as pd

    (folder / "meta").mkdir()
    (folder / "data" / "chunk-000").mkdir(parents=True)
    (folder / "meta" / "info.json").write_text(json.dumps({"codebase_version": "v3.0", "fps": 10}))
    count = np.arange(len(numbers))
    table = pd.DataFrame({"obs/turned": list(numbers), "episode_index": 0 * count, "frame_index": count})
    table.to_parquet(folder / "data" / "chunk-000" / "file-000.parquet")
    return folder


def mcap_file(folder: Path, numbers: np.ndarray) -> Path:
    """A topic with rotations, and one of another rate."""
    pytest.importorskip("mcap", reason="mcap is missing: pip install 'ichain_drake[logs]'")
    sent: list[tuple[str, int, object]] = []
    for i, (x, y, z, w) in enumerate(numbers.tolist()):
        sent.append(("/cup", 10**8 * i, {"turned": {"x": x, "y": y, "z": z, "w": w}}))
        sent.append(("/level", 10**8 * i + 10**7, {"data": i}))
    return write_json(folder / "a.mcap", sent)


ROWS = [f"obs/turned[{i}]" for i in range(4)]
FIELDS = [f"/cup:turned.{n}" for n in "xyzw"]
FORMATS: Mapping[str, tuple[Callable[[Path, np.ndarray], Path], list[str]]] = {
    "robomimic": (hdf5_file, ROWS),
    "minari": (minari_file, ROWS),
    "lerobot": (lerobot_set, ROWS),
    "mcap": (mcap_file, FIELDS),
    "ros2": (mcap_file, FIELDS),
}


def mapped(sources: list[str], **more: Any) -> Any:
    return parse_map({"rotations": [{"xyzw": sources, **ANGLES}], "rate": 10, **more}, "m")


@pytest.mark.parametrize("form", FORMATS)
def test_angles_are_drakes_in_every_format(form: str, tmp_path: Path) -> None:
    write, sources = FORMATS[form]
    numbers = turned(40)
    source = write(tmp_path, numbers)
    (piece,) = import_logs(form, source, mapped(sources, columns={sources[3]: "cup.raw"}))
    assert piece.units == {"cup.roll": "rad", "cup.pitch": "rad", "cup.yaw": "deg"}
    np.testing.assert_array_equal(piece.table["cup.raw"], numbers[:, 3])
    found = piece.table[["cup.roll", "cup.pitch", "cup.yaw"]] * [1, 1, np.pi / 180]
    np.testing.assert_allclose(found, drake(numbers), atol=1e-12)
    swapped = {"wxyz": [sources[3], *sources[:3]], "yaw": "cup.heading"}
    (other,) = import_logs(form, source, parse_map({"rotations": [swapped], "rate": 10}, "m"))
    np.testing.assert_allclose(other.table["cup.heading"], drake(numbers)[:, 2], atol=1e-12)
    assert other.units == {"cup.heading": "rad"}


@pytest.mark.parametrize("form", FORMATS)
@pytest.mark.parametrize("bad", [(0, 0, 0, 0), (0, 0, 0, 1.01), (np.nan, 0, 0, 1), (1e200, 0, 0, 0), (np.inf, 0, 0, 1)])
def test_what_is_no_rotation_is_refused_with_its_row(form: str, bad: tuple, tmp_path: Path) -> None:
    write, sources = FORMATS[form]
    numbers = turned(4)
    numbers[2] = bad
    with pytest.raises(InputError, match=r"the quaternion of .*row 3 .* a unit quaternion is needed") as error:
        import_logs(form, write(tmp_path, numbers), mapped(sources))
    assert "\n" not in str(error.value)


def test_topics_of_other_rates_leave_empty_cells_and_topics_are_not_mixed(tmp_path: Path) -> None:
    file = mcap_file(tmp_path, turned(3))
    (piece,) = import_logs("mcap", file, mapped(FIELDS, columns={"/level:data": "cup.level"}))
    assert piece.table["cup.yaw"].isna().tolist() == [False, True] * 3
    assert piece.table["cup.level"].isna().tolist() == [True, False] * 3
    with pytest.raises(InputError, match="the quaternion of /level:data is of /cup, /level; a rotation comes in one"):
        import_logs("mcap", file, mapped(["/level:data", *FIELDS[1:]]))


def test_a_full_turn_is_interpolated_by_the_short_way_and_rounding_is_borne(tmp_path: Path) -> None:
    yaw = np.linspace(0, 4 * np.pi, 101)  # ten seconds
    numbers = np.stack([0 * yaw, 0 * yaw, np.sin(yaw / 2), np.cos(yaw / 2)], axis=1).round(3)
    (piece,) = import_logs("robomimic", hdf5_file(tmp_path, numbers), mapped(ROWS))
    (taken,) = prepare([piece], inferred_graph([piece]), resampled=True, say=lambda _: None)
    assert len(taken) == 31
    turn = {"rad": 2 * np.pi, "deg": 360.0}[taken.units["cup.yaw"]]
    off = taken.table["cup.yaw"] / turn - taken.table["time"] / 5
    assert np.abs((off + 0.5) % 1 - 0.5).max() < 5e-4


@pytest.mark.parametrize("sign", [-1, 1])
def test_a_pitch_of_a_right_angle_is_the_same_rotation(sign: int, tmp_path: Path) -> None:
    wanted = RollPitchYaw(0.3, sign * np.pi / 2, 0.7).ToQuaternion()
    numbers = np.array([np.roll(wanted.wxyz(), -1)])
    (piece,) = import_logs("robomimic", hdf5_file(tmp_path, numbers), mapped(ROWS))
    roll, pitch, yaw = (piece.table[["cup.roll", "cup.pitch", "cup.yaw"]] * [1, 1, np.pi / 180]).iloc[0]
    found = RotationMatrix(RollPitchYaw(roll, pitch, yaw))
    np.testing.assert_allclose(found.matrix(), RotationMatrix(wanted).matrix(), atol=1e-7)
    assert roll == 0


@pytest.mark.parametrize(
    ("plain", "what"),
    [
        ({"xyzw": ROWS}, "write {xyzw:"),
        ({"yaw": "cup.yaw"}, "write {xyzw:"),
        ({"xyzw": ROWS, "wxyz": ROWS, "yaw": "cup.yaw"}, "write {xyzw:"),
        ({"xyzw": ROWS, "heading": "cup.yaw"}, "write {xyzw:"),
        ("xyzw", "write {xyzw:"),
        ({"xyzw": ROWS[:3], "yaw": "cup.yaw"}, "xyzw is a list of four sources"),
        ({"wxyz": "obs/turned", "yaw": "cup.yaw"}, "wxyz is a list of four sources"),
        ({"xyzw": [*ROWS[:3], 3], "yaw": "cup.yaw"}, "xyzw is a list of four sources"),
        ({"xyzw": [*ROWS[:3], ROWS[0]], "yaw": "cup.yaw"}, "a source stands twice"),
        ({"xyzw": ROWS, "yaw": "cup"}, "'cup' is no target"),
        ({"xyzw": ROWS, "yaw": ["cup.yaw"]}, "is no target"),
        ({"xyzw": ROWS, "yaw": "hand->cup"}, "hand->cup is an interaction and no angle"),
        ({"xyzw": ROWS, "yaw": "cup.yaw [mm]"}, "cup.yaw is an angle; there is no way from rad to mm"),
        ({"xyzw": ROWS, "yaw": "cup.yaw", "roll": "cup.yaw"}, "cup.yaw is named twice"),
    ],
)
def test_what_is_no_rotation_of_a_map_is_refused_in_one_line(plain: object, what: str) -> None:
    with pytest.raises(InputError, match=what) as told:
        parse_map({"columns": {"a": "cup.x"}, "rotations": [plain]}, "m.yaml")
    assert "\n" not in str(told.value)


def test_a_map_is_of_columns_or_rotations() -> None:
    with pytest.raises(InputError, match="rotations is a list of"):
        parse_map({"rotations": {"xyzw": ROWS, "yaw": "cup.yaw"}}, "m")
    with pytest.raises(InputError, match="a map has columns"):
        parse_map({"rotations": []}, "m")
    with pytest.raises(InputError, match="a map has columns"):
        parse_map({"rotations": [{"xyzw": ROWS, "yaw": "cup.yaw"}], "columns": 3}, "m")
