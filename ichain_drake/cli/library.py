"""The commands `library list`, `show`, `add` and `check`."""

from __future__ import annotations

from pathlib import Path

from rich.console import Console
from rich.table import Table

from ichain_drake.errors import InputError
from ichain_drake.learning.library import add_to_library, check_library, list_library, show_link


def print_list(library: Path) -> None:
    """One line an interaction.

    Raises:
        InputError: if there is no such library, or a link in it is damaged.
    """
    table = Table("name", "interaction", "samples", "score", "learned in", box=None)
    for link in list_library(library):
        table.add_row(link.name, link.interaction, str(link.samples), f"{link.forward_score:.4f}", link.source)
    Console().print(table)


def print_link(library: Path, name: str) -> None:
    """Everything known about one interaction, a line a field.

    Raises:
        InputError: if there is none of that name, or it is damaged.
    """
    for key, value in vars(show_link(library, name)).items():
        print(f"{key:20} {value}")


def add(source: Path, library: Path) -> None:
    """Copy all interactions of a library, or one, into another.

    Raises:
        InputError: if one is damaged, or the library can't be written; nothing is copied then.
    """
    for name in add_to_library(source, library):
        print(f"added: {name}")


def check(source: Path) -> None:
    """Print the problems of a library's files.

    Raises:
        InputError: if there are any.
    """
    problems = check_library(source)
    for problem in problems:
        print(problem)
    if problems:
        raise InputError(f"{source}: {len(problems)} problem(s); learn the interactions again, or restore their files")
    print(f"{source}: good")
