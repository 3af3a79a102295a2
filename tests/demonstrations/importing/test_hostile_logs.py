"""Logs of other tools, made to break their readers; see `test_hostile_files.py`."""

from __future__ import annotations

import json
import random
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
from damage import altered, damaged, hdf5_bytes, mcap_bytes, minari_bytes
from hostile import survives, tried
from lerobot_set import data_set
from small_bag import write_bag

from ichain_drake.demonstrations.importing import import_logs, parse_map
from ichain_drake.scenarios.yaml_text import read_yaml

LOG_MAP = parse_map({"columns": {"obs/x[0]": "arm.x", "actions[1]": "command.x"}, "rate": 3}, "map")
EPISODES = parse_map({"columns": {"observations/x[0]": "arm.x", "actions[1]": "command.x"}, "rate": 3}, "map")
TOPICS = parse_map({"columns": {"/arm:x": "arm.x", "/kart:list[0]": "kart.place"}}, "map")
STATE = parse_map({"columns": {"observation.state[y]": "cup.y [mm]", "done": "cup.full"}}, "map")
CUP = parse_map({"columns": {"/cup:point.x": "cup.x [m]", "/level:data": "cup.level"}}, "map")
MAP = {"columns": {"obs/x[0]": "arm.x [mm]", "/kart:list[0]": "kart.place"}, "rate": 3, "time": "header.stamp"}
MAP["rotations"] = [{"xyzw": ["a[0]", "a[1]", "a[2]", "a[3]"], "roll": "arm.roll [rad]", "yaw": "arm.yaw [deg]"}]


def hdf5(rng: random.Random, place: Path) -> None:
    (place / "a.hdf5").write_bytes(damaged(rng, hdf5_bytes()))
    tried(lambda: import_logs("robomimic", place / "a.hdf5", LOG_MAP))


def minari(rng: random.Random, place: Path) -> None:
    (place / "a.hdf5").write_bytes(damaged(rng, minari_bytes()))
    tried(lambda: import_logs("minari", place / "a.hdf5", EPISODES))


def mcap(rng: random.Random, place: Path) -> None:
    (place / "a.mcap").write_bytes(damaged(rng, mcap_bytes()))
    tried(lambda: import_logs("mcap", place / "a.mcap", TOPICS))


def lerobot(rng: random.Random, place: Path) -> None:
    """A data set whose description, or one of whose tables, is damaged."""
    good, folder = place / "good", place / "set"
    if not good.exists():
        data_set(good)
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(good, folder)
    info = folder / "meta" / "info.json"
    if rng.random() < 0.3:
        file = rng.choice([info, *folder.glob("data/*/*")])
        file.write_bytes(damaged(rng, file.read_bytes()))
    else:
        about = json.loads(info.read_text())
        altered(rng, about, "observation.state", "names", "motors", "shape", "x")
        info.write_text(json.dumps(about))
    tried(lambda: import_logs("lerobot", folder, STATE))


def bags(rng: random.Random, place: Path) -> None:
    """A bag in SQLite, damaged."""
    pytest.importorskip("mcap_ros2", reason="mcap-ros2-support is missing: pip install 'ichain_drake[logs]'")
    pytest.importorskip("rosbags", reason="rosbags is missing: pip install 'ichain_drake[dev]'")
    if not (place / "bag").exists():
        write_bag(place / "bag", "SQLITE3")
    (good,) = (place / "bag").glob("*.db3")
    (place / "a.db3").write_bytes(damaged(rng, good.read_bytes()))
    tried(lambda: import_logs("ros2", place / "a.db3", CUP))


def maps(rng: random.Random, place: Path) -> None:
    tree = json.loads(json.dumps(MAP))
    altered(rng, tree, "columns", "rotations", "wxyz", "arm.x", "a[0]", "[", "x [mm]", "rate")
    data = damaged(rng, json.dumps(tree).encode()) if rng.random() < 0.5 else json.dumps(tree).encode()
    tried(lambda: parse_map(read_yaml(data.decode(errors="replace"), "map"), "map"))


@pytest.mark.parametrize("reader", [hdf5, minari, mcap, lerobot, bags, maps], ids=lambda r: r.__name__)
def test_nothing_but_a_result_or_one_line(reader: Callable[[random.Random, Path], None], tmp_path: Path) -> None:
    survives(reader, tmp_path)
    assert {f.name for f in tmp_path.iterdir()} <= {"a.hdf5", "a.mcap", "good", "set", "bag", "a.db3"}
