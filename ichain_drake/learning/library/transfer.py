"""Copying saved links and graphs from one library to another."""

from __future__ import annotations

from pathlib import Path

from ichain_drake.errors import InputError
from ichain_drake.learning.library.files import is_graph_name, is_item, item_folders, write_files
from ichain_drake.learning.library.saved import SavedLink
from ichain_drake.learning.library.saved_graph import SavedGraph


def copy_link(source: Path, name: str, library: Path) -> Path:
    """Copy a link as it is, in place of an earlier one.

    Args:
        source: the library that has it.
        name: of the link.
        library: where it shall be; nothing is done where that is the same folder.

    Returns:
        The link's folder in `library`.

    Raises:
        InputError: if it isn't there any more, is damaged, or can't be written.
    """
    if not (source / name).is_dir():
        raise InputError(
            f"link {name}: the library that it came from, {source}, doesn't have it any more; learn it anew"
        )
    saved = SavedLink.read(source / name)
    saved.verify()
    if (library / name).resolve() == (source / name).resolve():
        return library / name
    return write_files(library, name, saved.files)


def add_to_library(source: Path, library: Path) -> list[str]:
    """Add a link or graph, or all of another library, to a library; each replaces an earlier one of the same name.

    Args:
        source: a link's folder, a graph's or a library's.
        library: where they shall be; made where it doesn't exist.

    Returns:
        Their names.

    Raises:
        InputError: if the source holds none, or any of them is damaged or unsafe: then none is added; or if the
            library can't be written.
    """
    folders = [source] if is_item(source) else item_folders(source)
    if not folders:
        raise InputError(f"{source}: holds no saved link; give a library's folder or a link's")
    links = [
        SavedGraph.read(folder) if is_graph_name(folder.resolve().name) else SavedLink.read(folder)
        for folder in folders
    ]
    for link in links:
        link.verify()
    return [write_files(library, link.folder.resolve().name, link.files).name for link in links]
