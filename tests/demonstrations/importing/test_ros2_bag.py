"""ROS 2 bags in SQLite, as rosbags writes them; and SQLite that is not meant well."""

import sqlite3
from pathlib import Path

import numpy as np
import pytest
from small_bag import write_bag

from ichain_drake.demonstrations.importing import import_logs, parse_map
from ichain_drake.errors import InputError

pytest.importorskip("mcap_ros2", reason="mcap-ros2-support is missing: pip install 'ichain_drake[logs]'")
pytest.importorskip("rosbags", reason="rosbags is missing: pip install 'ichain_drake[dev]'")

COLUMNS = {"/cup:point.x": "cup.x [m]", "/level:data": "cup.level"}
MAP = parse_map({"columns": COLUMNS, "rate": 3}, "m")


@pytest.fixture
def bag(tmp_path: Path) -> Path:
    return write_bag(tmp_path / "bag", "SQLITE3")


def told(source: Path) -> str:
    with pytest.raises(InputError) as error:
        import_logs("ros2", source, MAP)
    assert "\n" not in str(error.value)
    return str(error.value)


@pytest.mark.parametrize("storage", ["SQLITE3", "MCAP"])
def test_a_bag_is_a_piece(tmp_path: Path, storage: str) -> None:
    (piece,) = import_logs("ros2", write_bag(tmp_path / "bag", storage), MAP)
    np.testing.assert_array_equal(piece.table["time"], [0, 1, 2])
    np.testing.assert_array_equal(piece.table["cup.x"], [0, 1, 2])
    np.testing.assert_array_equal(piece.table["cup.level"], [0, 0.5, 1])
    assert piece.units == {"cup.x": "m"}


def test_bags_without_definitions_or_with_views_for_tables_are_refused(bag: Path) -> None:
    (file,) = bag.glob("*.db3")
    with sqlite3.connect(file) as opened:
        opened.execute("ALTER TABLE message_definitions RENAME TO other")
    assert "it holds no message definitions" in told(bag)
    with sqlite3.connect(file) as opened:
        opened.execute("CREATE VIEW message_definitions AS SELECT * FROM other")
    assert "it holds no message definitions" in told(bag)


def test_what_is_no_bag_is_told(bag: Path, tmp_path: Path) -> None:
    (file,) = bag.glob("*.db3")
    with sqlite3.connect(file) as opened:
        opened.execute("UPDATE messages SET data = x'00'")
    assert "can't read it as a bag" in told(bag)
    file.write_bytes(b"SQLite format 3\0" + b"\xff" * 5000)
    assert "can't read it as a bag" in told(file)
    (tmp_path / "empty").mkdir()
    assert "name the folder of a ROS 2 bag" in told(tmp_path / "empty")
    assert "there is no such file of a bag" in told(tmp_path / "none.db3")
