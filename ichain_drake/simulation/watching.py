"""Somebody watches episodes while they run; nothing in an episode depends on it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from ichain_drake.simulation.episode import Episode


class Watcher(Protocol):
    """Sees every frame of every logged episode."""

    def begin(self, episode: Episode) -> None:
        """An episode is about to run."""

    def frame(self, episode: Episode) -> bool:
        """A frame is done; true ends the run as Ctrl-C does."""


# A context variable and no argument: between who wants to look and the episodes lie scenarios' own functions, which
# have nothing to do with it.
_watcher: ContextVar[Watcher | None] = ContextVar("watcher", default=None)


@contextmanager
def watched_by(watcher: Watcher | None) -> Iterator[None]:
    """Let somebody watch the episodes that run inside; None for nobody."""
    token = _watcher.set(watcher)
    try:
        yield
    finally:
        _watcher.reset(token)


def present_watcher() -> Watcher | None:
    """Who watches now."""
    return _watcher.get()
