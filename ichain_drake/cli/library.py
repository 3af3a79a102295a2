"""What the commands `library list`, `show`, `add`, `check` and `export` do."""

from __future__ import annotations

from pathlib import Path

from rich.console import Console
from rich.table import Table

from ichain_drake.errors import InputError
from ichain_drake.learning.library import (
    GraphSummary,
    LinkSummary,
    add_to_library,
    check_library,
    is_graph_name,
    list_graphs,
    list_library,
    show_graph,
    show_link,
)
from ichain_drake.learning.portable import Form, export_item

_LAST = ("robot_seconds", "versions", "demonstrations_sha256", "size")  # fields about how it came about


def print_list(library: Path) -> None:
    """One line an interaction, and one a graph.

    Raises:
        InputError: if there is no such library, or anything in it is damaged.
    """
    table = Table("name", "interaction", "samples", "score", "learned in", box=None)
    for link in list_library(library):
        table.add_row(link.name, link.interaction, str(link.samples), f"{link.forward_score:.4f}", link.source)
    for graph in list_graphs(library):
        what = f"{len(graph.interactions)} interactions"
        table.add_row(graph.name, what, str(graph.samples), f"{graph.score:.4f}", graph.source)
    Console().print(table)


def print_link(library: Path, name: str) -> None:
    """Everything known about one interaction or graph, a line a field.

    Raises:
        InputError: if there is none of that name, or it is damaged.
    """
    shown: GraphSummary | LinkSummary = (show_graph if is_graph_name(name) else show_link)(library, name)
    for key, value in sorted(vars(shown).items(), key=lambda item: item[0] in _LAST):
        if isinstance(shown, GraphSummary) and key in ("objects", "interactions"):
            print(key)
            for inner, text in value.items():
                print(f"    {inner:16} {text}")
        else:
            print(f"{key:20} {value}")


def add(source: Path, library: Path) -> None:
    """Copy all interactions of a library, or one, into another.

    Raises:
        InputError: if one is damaged, or the library can't be written; nothing is copied then.
    """
    for name in add_to_library(source, library):
        print(f"added: {name}")


def export(library: Path, name: str, folder: Path, form: Form) -> None:
    """Write the models of one interaction or graph as ONNX or C.

    Raises:
        InputError: see `export_item`.
    """
    for file in export_item(library, name, folder, form):
        print(f"written: {file}")


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
