"""The commands `library list`, `show`, `add`, `check` and `export`, without what they import."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import click

from ichain_drake.cli.options import PATH


@click.group()
def library() -> None:
    """Look at saved interactions."""


_LIBRARY = click.option(
    "--library", type=PATH, default=Path("library"), show_default=True, metavar="DIR", help="the library's folder"
)


@library.command("list")
@_LIBRARY
def library_list(library: Path) -> None:
    """List the interactions and graphs of a library."""
    from ichain_drake.cli.library import print_list

    print_list(library)


@library.command("show")
@click.argument("name")
@_LIBRARY
def library_show(name: str, library: Path) -> None:
    """Show what is known about one interaction or graph."""
    from ichain_drake.cli.library import print_link

    print_link(library, name)


@library.command("add")
@click.argument("source", type=PATH)
@_LIBRARY
def library_add(source: Path, library: Path) -> None:
    """Add the interactions of another library."""
    from ichain_drake.cli.library import add

    add(source, library)


@library.command("check")
@click.argument("source", type=PATH)
def library_check(source: Path) -> None:
    """Check a library's files without loading anything from them."""
    from ichain_drake.cli.library import check

    check(source)


@library.command("export")
@click.argument("name")
@_LIBRARY
@click.option("-o", "--output", type=PATH, metavar="DIR", required=True, help="folder for the models")
@click.option("--form", type=click.Choice(["onnx", "c"]), default="onnx", show_default=True, help="of the files")
def library_export(name: str, library: Path, output: Path, form: Literal["onnx", "c"]) -> None:
    """Write the models of an interaction or graph for other programs."""
    from ichain_drake.cli.library import export

    export(library, name, output, form)
