"""A small bag of ROS 2, written by rosbags."""

from pathlib import Path


def write_bag(folder: Path, storage: str) -> Path:
    """Three points of a cup and three levels, a second apart; `storage` is SQLITE3 or MCAP."""
    from rosbags import rosbag2  # noqa: PLC0415
    from rosbags.typesys import Stores, get_typestore  # noqa: PLC0415

    store = get_typestore(Stores.ROS2_HUMBLE)
    types = store.types
    point, level = types["geometry_msgs/msg/PointStamped"], types["std_msgs/msg/Float64"]
    header = types["std_msgs/msg/Header"](types["builtin_interfaces/msg/Time"](5, 0), "world")
    with rosbag2.Writer(folder, version=9, storage_plugin=rosbag2.StoragePlugin[storage]) as writer:
        cup = writer.add_connection("/cup", point.__msgtype__, typestore=store)
        water = writer.add_connection("/level", level.__msgtype__, typestore=store)
        for i in range(3):
            place = point(header, types["geometry_msgs/msg/Point"](float(i), 0.0, 0.0))
            writer.write(cup, i * 10**9, store.serialize_cdr(place, point.__msgtype__))
            writer.write(water, i * 10**9, store.serialize_cdr(level(i / 2), level.__msgtype__))
    return folder
