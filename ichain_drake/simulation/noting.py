"""What is recorded of a piece goes on, about twice a second, to whoever keeps it while it isn't whole yet."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Protocol

from ichain_drake.demonstrations.table import Demonstration

_EVERY = 0.5  # [s] of the clock: with the tick that is under way, less than a second is lost


class Notebook(Protocol):
    """Keeps the rows of a piece that is being recorded."""

    @property
    def rows(self) -> int:
        """How many it has of the piece that is open."""

    def add(self, piece: Demonstration) -> None:
        """Take the rows that follow."""


# A context variable and no argument, as for watchers: a scenario's own functions lie between.
_notebook: ContextVar[Notebook | None] = ContextVar("notebook", default=None)


@contextmanager
def noted_in(notebook: Notebook) -> Iterator[None]:
    """Let somebody keep the rows of the pieces that are recorded inside."""
    token = _notebook.set(notebook)
    try:
        yield
    finally:
        _notebook.reset(token)


class Noting:
    """When the rows of one piece are due; never where nobody keeps them."""

    def __init__(self) -> None:
        self.notebook = _notebook.get()
        self._last = time.monotonic()

    def due(self) -> Notebook | None:
        """Who is to be given rows now."""
        if self.notebook is None or time.monotonic() < self._last + _EVERY:
            return None
        self._last = time.monotonic()
        return self.notebook
