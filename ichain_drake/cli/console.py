"""What the command says while it works: a status on a terminal, plain lines in a log. All of it on stderr."""

from __future__ import annotations

import sys
import time
from types import TracebackType

from rich.console import Console
from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

Line = str


class Reporter:
    """Shows progress. A context manager; call it with a line, or with a line and a fraction done.

    Args:
        quiet: say nothing.
    """

    def __init__(self, *, quiet: bool = False) -> None:
        self._quiet = quiet
        self._start = time.monotonic()
        console = Console(stderr=True)
        self._progress: Progress | None = None
        if not quiet and sys.stderr.isatty():
            columns = (SpinnerColumn(), TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
            self._progress = Progress(*columns, console=console, transient=True)
            self._task = self._progress.add_task("starting", total=None)

    def __enter__(self) -> Reporter:
        if self._progress:
            self._progress.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._progress:
            self._progress.stop()

    def __call__(self, line: Line, fraction: float | None = None) -> None:
        """Say what is being done.

        Args:
            line: in words.
            fraction: how much of the whole is done, 0 to 1; unknown if not given.
        """
        if self._quiet:
            return
        if self._progress:
            total = None if fraction is None else 1.0
            self._progress.update(self._task, description=line, total=total, completed=fraction or 0.0)
            return
        done = "" if fraction is None else f" ({100 * fraction:.0f} %)"
        print(f"[{time.monotonic() - self._start:6.1f} s] {line}{done}", file=sys.stderr, flush=True)

    def note(self, line: Line) -> None:
        """Say something that stays to be read, on a terminal too."""
        if self._progress and not self._quiet:
            self._progress.console.print(line, highlight=False, soft_wrap=True)
        else:
            self(line)
