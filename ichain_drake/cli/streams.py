"""Standard streams as they may be: closed, full, read by nobody, or of an encoding that lacks characters."""

from __future__ import annotations

import errno
import io
import os
import sys
from typing import TextIO


class _Patient(io.FileIO):
    """A stream that goes on when nobody reads it or there is no room: the work behind it is worth more than its words.

    Attributes:
        full: why nothing can be written, in words; empty as long as it can, and where a reader has left.
    """

    full = ""

    def write(self, data: object) -> int:  # type: ignore[override]
        """As much as there is room for; what can't be written is given up."""
        try:
            return int(super().write(data))  # type: ignore[arg-type]
        except OSError as error:
            if error.errno not in (errno.EPIPE, errno.ENOSPC, errno.EIO, errno.EDQUOT, errno.EBADF):
                raise
            if error.errno != errno.EPIPE:
                self.full = error.strerror or str(error)
            return memoryview(data).nbytes  # type: ignore[arg-type]


class GuardedStreams:
    """What stands in for stdout and stderr until the process ends.

    Args:
        out: what stdout writes to.
    """

    def __init__(self, out: _Patient) -> None:
        self._out = out

    def finish(self, status: int) -> int:
        """Write out what is left; gives the exit status, which is 2 if stdout could not take what was printed.

        Args:
            status: of the command.
        """
        sys.stdout.flush()
        if self._out.full:
            print(f"ichain: stdout: {self._out.full}; what was printed is lost", file=sys.stderr)
            status = status or 2
        sys.stderr.flush()
        return status


def guard_streams() -> GuardedStreams:
    """Make stdout and stderr such that no `print` fails."""
    while (spare := os.open(os.devnull, os.O_RDWR)) <= 2:
        pass  # a closed stream's number must not go to the first file that is opened
    os.close(spare)
    out = _Patient(1, "w", closefd=False)
    sys.stdout = _text(out, sys.stdout)
    sys.stderr = _text(_Patient(2, "w", closefd=False), sys.stderr)
    return GuardedStreams(out)


def _text(raw: _Patient, old: TextIO | None) -> TextIO:
    encoding = getattr(old, "encoding", None) or "utf-8"
    lines = raw.isatty() or old is sys.stderr
    return io.TextIOWrapper(io.BufferedWriter(raw), encoding, "backslashreplace", line_buffering=lines)
