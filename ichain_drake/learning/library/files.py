"""A saved link as files: one folder, read and written as a whole, checked before anything in it is used."""

from __future__ import annotations

import errno
import hashlib
import os
import re
import secrets
import shutil
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

from ichain_drake.errors import InputError
from ichain_drake.files import MOST_BYTES, MOST_JSON, is_folder, read_whole

MANIFEST = "manifest.json"
_WEIGHTS = re.compile(r"[a-z0-9_]+\.npz")
_LINK = re.compile(r"(?:[A-Za-z0-9_]|%[0-9a-f]{2})+-(?:[A-Za-z0-9_]|%[0-9a-f]{2})+")
_GRAPH = re.compile(r"graph\.(?:[A-Za-z0-9_]|%[0-9a-f]{2})+")  # no link's name holds a dot
_NOTES = {".md", ".txt"}


def link_name(parent_type: str, child_type: str) -> str:
    """Name of a link's folder: `<parent type>-<child type>`.

    Every character but letters, digits and `_` is written as `%` and two hexadecimal digits a byte, so that no type
    leads out of the library and no two pairs of types share a folder.

    Raises:
        InputError: on an empty type.
    """
    if not parent_type or not child_type:
        raise InputError(f"link {parent_type!r} to {child_type!r}: an object type is empty; give both a type")
    return f"{safe_name(parent_type)}-{safe_name(child_type)}"


def graph_name(name: str) -> str:
    """Name of a whole graph's folder: `graph.<name>`, characters written as in `link_name`.

    Raises:
        InputError: on an empty name.
    """
    if not name:
        raise InputError("a saved graph needs a name; give the scenario's")
    return f"graph.{safe_name(name)}"


def is_graph_name(name: str) -> bool:
    """Whether a folder's name is that of a whole graph, as `graph_name` makes it."""
    return _GRAPH.fullmatch(name) is not None


def safe_name(name: str) -> str:
    """A name as part of a file's: letters, digits and `_` of ASCII as they are, other bytes as `%` and two digits."""
    plain = (c if c.isascii() and (c.isalnum() or c == "_") else c.encode(errors="surrogatepass") for c in name)
    return "".join(c if isinstance(c, str) else "".join(f"%{byte:02x}" for byte in c) for c in plain)


def link_folder(library: Path, name: str) -> Path:
    """Folder of a link or graph of a library by its name, as `link_name` and `graph_name` make it.

    Raises:
        InputError: if the name is none (a path, say), or there is no such link.
    """
    if not _LINK.fullmatch(name) and not is_graph_name(name):
        raise InputError(
            f"library {library}: {name!r} is no link's name; write it as <parent type>-<child type>, a whole graph's "
            "as graph.<scenario>"
        )
    folder = library / name
    if not is_folder(folder):
        links = ", ".join(found.name for found in item_folders(library)) or "none"
        raise InputError(f"library {library}: it has no link {name!r}; it has {links}")
    return folder


def library_entries(library: Path) -> tuple[list[Path], list[str]]:
    """Folders of a library's links and graphs, sorted by name, and a line on each thing that doesn't belong there.

    Raises:
        InputError: if there is no such folder, or it is a single link or graph.
    """
    found, foreign = [], []
    for entry in _entries(library):
        if entry.name == MANIFEST:
            raise InputError(f"library {library}: it is a single link; give the folder that it is in")
        if entry.is_dir(follow_symlinks=False) and (_LINK.fullmatch(entry.name) or is_graph_name(entry.name)):
            found.append(library / entry.name)
        # Something hidden, such as .git, and texts for people are passed over.
        elif not entry.name.startswith(".") and Path(entry.name).suffix not in _NOTES:
            foreign.append(f"library {library}: {entry.name} is no part of a library and is not opened; remove it")
    return found, foreign


def link_folders(library: Path) -> list[Path]:
    """Folders of the links of a library, sorted by name.

    Raises:
        InputError: if there is no such folder, or it holds anything but links, graphs and notes (`.md`, `.txt`,
            hidden).
    """
    return [folder for folder in item_folders(library) if not is_graph_name(folder.name)]


def item_folders(library: Path) -> list[Path]:
    """Folders of the links and graphs of a library, sorted by name; errors as `link_folders`."""
    found, foreign = library_entries(library)
    if foreign:
        raise InputError(foreign[0])
    return found


def _entries(folder: Path) -> list[os.DirEntry[str]]:
    try:
        with os.scandir(folder) as entries:
            return sorted(entries, key=lambda entry: entry.name)
    except OSError as error:
        raise InputError(f"{folder}: can't be read as a folder ({error.strerror}); give an existing one") from None


def read_files(folder: Path) -> dict[str, bytes]:
    """All files of a link, by name. Nothing is interpreted here.

    Raises:
        InputError: if the folder lacks a manifest, can't be read, or holds anything but a manifest and `.npz` files.
    """
    files = {}
    for entry in _entries(folder):
        # A pipe would block, and a symbolic link may lead anywhere.
        if not entry.is_file(follow_symlinks=False):
            raise InputError(f"{folder / entry.name}: is no ordinary file; a link holds no folders or symbolic links")
        if entry.name != MANIFEST and not is_weights_name(entry.name):
            raise InputError(
                f"{folder / entry.name}: is no part of a link and is not opened: a link is {MANIFEST} and plain "
                "arrays in .npz files; remove it"
            )
        most = MOST_JSON if entry.name == MANIFEST else MOST_BYTES
        files[entry.name] = read_whole(folder / entry.name, "a part of a saved link", most)
    if MANIFEST not in files:
        raise InputError(f"{folder}: holds no {MANIFEST}, so it is no saved link")
    return files


def is_weights_name(name: str) -> bool:
    """Whether a name is that of a weight file: plain, in the link's own folder."""
    return _WEIGHTS.fullmatch(name) is not None


def sha256(data: bytes) -> str:
    """SHA-256 in hexadecimal digits."""
    return hashlib.sha256(data).hexdigest()


def write_files(library: Path, name: str, files: Mapping[str, bytes]) -> Path:
    """Write a link's folder as a whole: it appears when it is complete, in place of an earlier one.

    Args:
        library: made where it doesn't exist.
        name: of the link, from `link_name`.
        files: contents by file name.

    Returns:
        The link's folder.

    Raises:
        InputError: if it can't be written; what was there before is kept.
    """
    target = library / name
    new: Path | None = None
    if is_item(library):
        raise InputError(f"library {library}: it is a single link or graph; give the folder that it is in")
    try:
        library.mkdir(parents=True, exist_ok=True)
        # Beside the target, or renaming it would be copying. A hidden name: nobody takes it for a link.
        new = library / f".new-{secrets.token_hex(8)}"
        new.mkdir()
        for file, data in files.items():
            with (new / file).open("wb") as stream:
                stream.write(data)
                stream.flush()
                os.fsync(stream.fileno())
        _swap(new, target)
    except OSError as error:
        reason = error.strerror or str(error)
        raise InputError(
            f"library {library}: {name} can't be written ({reason}); mend that or give another folder"
        ) from None
    finally:
        if new is not None:
            shutil.rmtree(new, ignore_errors=True)
    return target


def _swap(new: Path, target: Path) -> None:
    """Put a folder where an earlier link may be; that one comes back if it fails."""
    if target.is_symlink() or (target.exists() and not (target.is_dir() and _is_link_or_empty(target))):
        raise FileExistsError(errno.EEXIST, "something that is no saved link is in its place")
    old = new.with_name(new.name.replace(".new-", ".old-", 1))
    with suppress(FileNotFoundError):
        target.rename(old)
    try:
        new.rename(target)
    except OSError:
        if old.exists():
            old.rename(target)
        raise
    shutil.rmtree(old, ignore_errors=True)


def is_item(folder: Path) -> bool:
    """Whether a folder is a saved link or graph itself, in which no other one belongs."""
    try:
        return (folder / MANIFEST).exists()
    except (OSError, ValueError):
        return False


def _is_link_or_empty(folder: Path) -> bool:
    return (folder / MANIFEST).is_file() or not any(folder.iterdir())
