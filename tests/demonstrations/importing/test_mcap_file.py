"""MCAP with messages of JSON and of ROS 2, as their own libraries write them; and MCAP that is not meant well."""

from pathlib import Path

import numpy as np
import pytest
from small_mcap import write_json

from ichain_drake.demonstrations.importing import import_logs, mcap_file, parse_map
from ichain_drake.errors import InputError

pytest.importorskip("mcap", reason="mcap is missing: pip install 'ichain_drake[logs]'")
pytest.importorskip("mcap_ros2", reason="mcap-ros2-support is missing: pip install 'ichain_drake[logs]'")

POSE = """\
std_msgs/Header header
geometry_msgs/Point position
float64[] joints
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
================================================================================
MSG: geometry_msgs/Point
float64 x
float64 y
"""


def write_ros2(file: Path) -> Path:
    from mcap_ros2.writer import Writer

    with file.open("wb") as stream, Writer(stream) as writer:
        schema = writer.register_msgdef("demo/Pose", POSE)
        for i in range(3):
            stamp = {"sec": 100 + i, "nanosec": 500_000_000}
            pose = {"header": {"stamp": stamp}, "position": {"x": i, "y": -i}, "joints": [0.5, i]}
            writer.write_message("/cup", schema, pose, log_time=2 * i * 10**9, publish_time=0)
    return file


def told(file: Path, columns: dict[str, str], **more: object) -> str:
    with pytest.raises(InputError) as error:
        import_logs("mcap", file, parse_map({"columns": columns, **more}, "m"))
    assert "\n" not in str(error.value)
    return str(error.value)


@pytest.mark.parametrize("compression", ["NONE", "LZ4", "ZSTD"])
def test_topics_of_different_rates_leave_cells_empty(tmp_path: Path, compression: str) -> None:
    from mcap.writer import CompressionType

    messages = [("/a", k * 10**8, {"v": {"x": k}}) for k in range(5)] + [
        ("/b", k * 2 * 10**8, [7, k]) for k in range(3)
    ]
    messages.append(("/other", 0, b"not even json"))
    file = write_json(tmp_path / "log.mcap", messages, compression=CompressionType[compression], chunk_size=64)
    mapping = parse_map({"columns": {"/a:v.x": "cup.x [mm]"}}, "m")
    (piece,) = import_logs("mcap", file, mapping)
    assert piece.name == "log"
    np.testing.assert_allclose(piece.table["time"], np.arange(5) / 10)
    np.testing.assert_array_equal(piece.table["cup.x"], np.arange(5))
    assert "no number; a message there has" in told(file, {"/b:x": "cup.x"})


def test_two_topics_become_one_table(tmp_path: Path) -> None:
    messages = [("/a", k * 10**9, {"x": k}) for k in range(3)] + [("/b", 10**9, {"list": [7, 8]})]
    folder = tmp_path / "bag"
    folder.mkdir()
    write_json(folder / "one.mcap", messages)
    (piece,) = import_logs("mcap", folder, parse_map({"columns": {"/a:x": "a.x", "/b:list[1]": "b.x"}}, "m"))
    np.testing.assert_array_equal(piece.table["b.x"], [np.nan, 8, np.nan])


def test_messages_of_ros_2_by_their_own_definitions(tmp_path: Path) -> None:
    file = write_ros2(tmp_path / "bag.mcap")
    columns = {"/cup:position.y": "cup.y [m]", "/cup:joints[1]": "arm.joint"}
    for form in ("mcap", "ros2"):
        (logged,) = import_logs(form, file, parse_map({"columns": columns}, "m"))
        (stamped,) = import_logs(form, file, parse_map({"columns": columns, "time": "header.stamp"}, "m"))
        np.testing.assert_array_equal(logged.table["cup.y"], [0, -1, -2])
        np.testing.assert_array_equal(logged.table["arm.joint"], [0, 1, 2])
        np.testing.assert_allclose(logged.table["time"], [0, 2, 4])
        np.testing.assert_allclose(stamped.table["time"], [0, 1, 2])


def test_fields_are_those_of_the_message_and_nothing_of_python(tmp_path: Path) -> None:
    file = write_ros2(tmp_path / "bag.mcap")
    assert "is no number; a message there has header, position, joints" in told(file, {"/cup:__class__": "cup.x"})
    assert "is no number" in told(file, {"/cup:joints[9]": "cup.x"})
    assert "has no time in header.frame_id" in told(file, {"/cup:position.x": "cup.x"}, time="header.frame_id")
    assert "there is no message of /cap; it has /cup" in told(file, {"/cap:position.x": "cup.x"})
    assert "is no source here; write /topic:field" in told(file, {"/cup": "cup.x"})


def test_what_is_no_mcap_or_in_another_encoding_is_told(tmp_path: Path) -> None:
    assert "there is no such file" in told(tmp_path / "none.mcap", {"/a:x": "a.x"})
    (tmp_path / "empty").mkdir()
    assert "there is no .mcap file in it" in told(tmp_path / "empty", {"/a:x": "a.x"})
    file = write_json(tmp_path / "log.mcap", [("/a", 0, b"\x08\x01")], encoding="protobuf")
    assert "/a: messages in 'protobuf' described by 'nothing' can't be read" in told(file, {"/a:x": "a.x"})
    file = write_json(tmp_path / "log.mcap", [("/a", 0, {"x": 1})] * 50)
    whole = file.read_bytes()
    file.write_bytes(whole[: len(whole) // 2])
    assert "can't read it as MCAP" in told(file, {"/a:x": "a.x"})
    file = write_json(tmp_path / "log.mcap", [("/a", 0, b"[" * 10**5)])
    assert "can't read it as MCAP: RecursionError" in told(file, {"/a:x": "a.x"})
    file = write_json(tmp_path / "log.mcap", [("/a", 0, {"x": 10**400})])
    assert "a number too large" in told(file, {"/a:x": "a.x"})


@pytest.mark.parametrize("compression", ["LZ4", "ZSTD"])
def test_a_chunk_is_unpacked_no_further_than_a_bound(
    tmp_path: Path, compression: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    from mcap.writer import CompressionType

    message = ("/a", 0, {"x": 1, "rest": "0" * 10**6})
    file = write_json(tmp_path / "bomb.mcap", [message], compression=CompressionType[compression])
    monkeypatch.setattr(mcap_file, "_MOST_RECORD", 10**5)
    assert file.stat().st_size < 10**5
    assert "a chunk unpacks to over 0 MB" in told(file, {"/a:x": "a.x"})


def test_without_the_extra_it_says_what_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = write_json(tmp_path / "log.mcap", [("/a", 0, {"x": 1})])
    for module in ("mcap", "mcap.records", "h5py"):
        monkeypatch.setitem(__import__("sys").modules, module, None)
    assert "reading MCAP needs mcap" in told(file, {"/a:x": "a.x"})
    with pytest.raises(InputError, match=r"reading HDF5 needs h5py.*pip install 'ichain_drake\[logs\]'"):
        import_logs("robomimic", file, parse_map({"columns": {"a": "a.x"}}, "m"))
