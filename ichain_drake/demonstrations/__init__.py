"""Demonstrations: tables of measured states at 3 Hz, and what learning reads out of them."""

from ichain_drake.demonstrations.table import (
    COMMAND,
    TIME,
    Demonstration,
    column,
    read_demonstration,
    read_demonstrations,
    read_folder,
    write_demonstration,
    write_demonstrations,
)
from ichain_drake.demonstrations.transitions import Transitions, collect_commands, collect_transitions

__all__ = [
    "COMMAND",
    "TIME",
    "Demonstration",
    "Transitions",
    "collect_commands",
    "collect_transitions",
    "column",
    "read_demonstration",
    "read_demonstrations",
    "read_folder",
    "write_demonstration",
    "write_demonstrations",
]
