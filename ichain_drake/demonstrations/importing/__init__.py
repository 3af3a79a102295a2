"""Other people's logs as demonstrations (extra `logs`): LeRobot, robomimic, Minari, MCAP, ROS 2 bags."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from ichain_drake.demonstrations.importing.lerobot import read_lerobot
from ichain_drake.demonstrations.importing.log_map import LogMap, parse_map
from ichain_drake.demonstrations.importing.mcap_file import read_mcap
from ichain_drake.demonstrations.importing.minari import read_minari
from ichain_drake.demonstrations.importing.robomimic import read_robomimic
from ichain_drake.demonstrations.importing.ros2_bag import read_ros2
from ichain_drake.demonstrations.importing.sources import Source
from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.errors import InputError

FORMATS: dict[str, Callable[[Path, LogMap], list[Demonstration]]] = {
    "lerobot": read_lerobot,
    "mcap": read_mcap,
    "minari": read_minari,
    "robomimic": read_robomimic,
    "ros2": read_ros2,
}
"""Readers by name: a folder or file and a mapping in, pieces out, at the log's own rate and in the log's units."""


def import_logs(form: str, source: Path, mapping: LogMap) -> list[Demonstration]:
    """Read somebody's log.

    Args:
        form: a name of `FORMATS`.
        source: its folder or file.
        mapping: see `parse_map`.

    Raises:
        InputError: on an unknown format, a log that can't be read, or a source of the map that it doesn't have.
    """
    if form not in FORMATS:
        raise InputError(f"format {form!r:.40}: unknown; there are {', '.join(FORMATS)}")
    return FORMATS[form](Path(source), mapping)


__all__ = ["FORMATS", "LogMap", "Source", "import_logs", "parse_map"]
