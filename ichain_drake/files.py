"""Files of others, read without trusting their names or kinds, and files of ours, written whole or not at all."""

from __future__ import annotations

import fcntl
import json
import os
import secrets
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO

from ichain_drake.errors import InputError

MOST_BYTES = 2**28
"""Larger files are refused unread [bytes]."""

MOST_CELLS = 10**7
"""Rows times columns of a table [1]: an hour of fifty columns at 50 Hz, 80 MB as numbers."""

MOST_JSON = 2**23
"""Larger JSON files are refused unread [bytes]: as lists in lists they take a hundred times as much memory."""


def shown(file: Path) -> str:
    """A file's name as text that any terminal and page takes: bytes that are no UTF-8 in hexadecimal digits."""
    return printable(os.fsencode(file.name).decode(errors="backslashreplace"))


def printable(text: str) -> str:
    """A text from outside in one line: what would move a terminal's cursor is written as an escape."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape", "surrogatepass").decode() for c in text)


def reason_of(error: OSError | ValueError) -> str:
    """Why the system refused, in its words."""
    return (error.strerror if isinstance(error, OSError) else None) or str(error)


def is_folder(path: Path) -> bool:
    """Whether a path is a folder; False too where it can't even be asked (a name too long, a loop of links).

    `Path.is_dir` raises there.
    """
    try:
        return path.is_dir()
    except (OSError, ValueError):
        return False


def is_file(path: Path) -> bool:
    """Whether a path is an ordinary file; False too where it can't even be asked."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def check_folder(folder: Path, what: str) -> None:
    """Refuse what is no folder.

    Args:
        folder: that should exist.
        what: is in it, in the plural, such as `demonstrations`.

    Raises:
        InputError: with the system's reason, if it has one beside the folder not being there.
    """
    try:
        if folder.is_dir():
            return
    except (OSError, ValueError) as error:
        raise InputError(f"{folder}: can't be looked at ({reason_of(error)}); give a folder of {what}") from None
    raise InputError(f"{folder}: no such folder of {what}")


def read_whole(file: Path, what: str, most: int = MOST_BYTES) -> bytes:
    """The bytes of an ordinary file. A named pipe or a device is refused: reading it could last for ever.

    Args:
        file: which.
        what: it should be, for errors: `the demonstration`.
        most: bytes that are read at most.

    Raises:
        InputError: if it can't be read, is no ordinary file, or is larger.
    """
    with opened(file, what) as stream:
        size = os.fstat(stream.fileno()).st_size
        if size > most:
            raise InputError(
                f"{file}: can't read {what}: {size / 1e6:.0f} MB, and {most / 1e6:.0f} are read at most; "
                "split it into pieces"
            )
        return stream.read(size)  # a larger number would be asked for as memory at once


@contextmanager
def opened(file: Path, what: str) -> Iterator[BinaryIO]:
    """An ordinary file, open for reading. A named pipe or a device is refused: reading it could last for ever.

    Args:
        file: which.
        what: it should be, for errors.

    Raises:
        InputError: if it is no ordinary file, or it or what is done with it meets an error of the system.
    """
    try:
        # Opening a pipe waits for somebody at its other end, unless asked not to.
        with os.fdopen(os.open(file, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC), "rb") as stream:
            if not stat.S_ISREG(os.fstat(stream.fileno()).st_mode):
                raise InputError(f"{file}: can't read {what}: it is a pipe or a device; give an ordinary file")
            yield stream
    except InputError:
        raise
    except (OSError, ValueError) as error:  # a name with a zero byte is a ValueError
        raise InputError(f"{file}: can't read {what}: {reason_of(error)}") from None


class FileBytes:
    """The bytes of an open file as those of a text in memory, of which only what is asked for is read.

    Args:
        stream: of an ordinary file.
    """

    def __init__(self, stream: BinaryIO) -> None:
        self._number = stream.fileno()
        self._size = os.fstat(self._number).st_size

    def __len__(self) -> int:
        return self._size

    def __getitem__(self, part: slice) -> bytes:
        first, end, _ = part.indices(self._size)
        return os.pread(self._number, max(0, end - first), first)


def read_json(file: Path, what: str, most: int = MOST_JSON) -> Any:
    """What a JSON file holds.

    Args:
        file: which.
        what: it should be, for errors: `the earlier scoreboard`.
        most: bytes that are read at most.

    Raises:
        InputError: as `read_whole`, and if it is no JSON, or nested too deeply.
    """
    return json_value(read_whole(file, what, most), f"{file}: can't read {what}")


def json_value(data: bytes, where: str) -> Any:
    """What JSON in UTF-8 holds; numbers that are not finite are no JSON.

    Args:
        data: the bytes.
        where: begins the error.

    Raises:
        InputError: if it is none, or nested too deeply.
    """
    try:
        return json.loads(data.decode(), parse_constant=_no_constant)
    except RecursionError:
        raise InputError(f"{where}: it is nested too deeply") from None
    except ValueError as error:  # UnicodeDecodeError is one
        raise InputError(f"{where}: it is no complete JSON ({error})") from None


def _no_constant(name: str) -> float:
    raise ValueError(f"{name} is no number")


def write_whole(file: Path, content: bytes, *, new: bool = False) -> None:
    """Write a file so that a reader sees the old content or the new one, never a part, also after a kill.

    Args:
        file: where to; its folder must exist.
        content: the bytes of the file.
        new: refuse to replace a file that exists, whoever made it and however shortly before.

    Raises:
        InputError: if the folder is missing or unwritable, the name is too long, the disk is full, or the file exists
            and must be new; nothing is left behind then.
    """
    part = file.with_name(f".{os.getpid()}-{secrets.token_hex(4)}.part")  # not by its name, which may be long
    try:
        try:
            part.write_bytes(content)
            if new:
                _name_anew(part, file)
            else:
                part.replace(file)
        finally:
            part.unlink(missing_ok=True)
    except FileExistsError:
        raise InputError(f"{file}: is there already and is not overwritten; give another name or folder") from None
    except (OSError, ValueError) as error:
        raise InputError(
            f"{file}: can't write {len(content) / 1e3:.0f} kB there ({reason_of(error)}); give a writable folder with "
            "room"
        ) from error


def _name_anew(part: Path, file: Path) -> None:
    """Give a finished file its name, unless that is taken. A second link, unlike renaming, never replaces."""
    try:
        os.link(part, file)
    except FileExistsError:
        raise
    except OSError:  # a file system without links
        os.close(os.open(file, os.O_CREAT | os.O_EXCL | os.O_WRONLY))
        part.replace(file)


@contextmanager
def held(folder: Path) -> Iterator[None]:
    """Keep other processes of this library from writing into a folder meanwhile; the system lets go if this one dies.

    Raises:
        InputError: if another one holds it, or it can't be opened.
    """
    try:
        handle = os.open(folder, os.O_RDONLY | os.O_CLOEXEC)
    except (OSError, ValueError) as error:
        raise InputError(f"{folder}: can't be opened ({reason_of(error)}); give a writable folder") from None
    try:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise InputError(f"{folder}: another run writes there now; wait for it, or give another folder") from None
        except OSError:  # a file system without locks
            pass
        yield
    finally:
        os.close(handle)


def real_path(path: Path) -> Path:
    """Where a path leads; itself where that can't be told (a loop of links)."""
    try:
        return path.resolve()
    except (OSError, ValueError, RuntimeError):
        return path


def unused_folder(folder: Path) -> Path:
    """A folder of this name, or with a number behind it, in which nothing is yet; it isn't made."""
    number, found = 1, folder
    while found.exists() and (not found.is_dir() or any(found.iterdir())):
        number += 1
        found = folder.with_name(f"{folder.name}-{number}")
    return found
