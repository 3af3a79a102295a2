"""Demonstrations: tables of measured states at 3 Hz, and what learning reads out of them."""

from ichain_drake.demonstrations.columns import COMMAND, TIME, column
from ichain_drake.demonstrations.reading import prepare, read_demonstration, read_demonstrations, read_folder
from ichain_drake.demonstrations.resampling import Resampled, resample
from ichain_drake.demonstrations.table import Demonstration, data_hash
from ichain_drake.demonstrations.transitions import Transitions, collect_commands, collect_transitions
from ichain_drake.demonstrations.writing import write_demonstration, write_demonstrations

__all__ = [
    "COMMAND",
    "TIME",
    "Demonstration",
    "Resampled",
    "Transitions",
    "collect_commands",
    "collect_transitions",
    "column",
    "data_hash",
    "prepare",
    "read_demonstration",
    "read_demonstrations",
    "read_folder",
    "resample",
    "write_demonstration",
    "write_demonstrations",
]
