"""Writing result files whole or not at all."""

import os
from pathlib import Path

from ichain_drake.errors import InputError


def write_whole(file: Path, content: bytes) -> None:
    """Write a file so that a reader sees the old content or the new one, never a part.

    Args:
        file: where to; its folder must exist. An existing file is replaced.
        content: the bytes of the file.

    Raises:
        InputError: if the folder is missing or unwritable, or the disk is full; nothing is left behind then.
    """
    part = file.with_name(f".{file.name}.{os.getpid()}.part")
    try:
        try:
            part.write_bytes(content)
            part.replace(file)
        finally:
            part.unlink(missing_ok=True)
    except OSError as error:
        reason = error.strerror or str(error)
        raise InputError(
            f"{file}: can't write {len(content) / 1e6:.1f} MB there ({reason}); give a writable folder with room"
        ) from error
