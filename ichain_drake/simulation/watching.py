"""Somebody watches episodes while they run; nothing in an episode depends on it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any, Protocol, TypeVar

EpisodeT_contra = TypeVar("EpisodeT_contra", contravariant=True)


class Watcher(Protocol[EpisodeT_contra]):
    """Sees every frame of every logged episode; `EpisodeT_contra` is the class of episodes."""

    def begin(self, episode: EpisodeT_contra) -> None:
        """An episode is about to run."""

    def frame(self, episode: EpisodeT_contra) -> bool:
        """A frame is done; true ends the run as Ctrl-C does."""


# A context variable and no argument: between who wants to look and the episodes lie scenarios' own functions, which
# have nothing to do with it.
_watcher: ContextVar[Watcher[Any] | None] = ContextVar("watcher", default=None)


@contextmanager
def watched_by(watcher: Watcher[Any] | None) -> Iterator[None]:
    """Let somebody watch the episodes that run inside; None for nobody."""
    token = _watcher.set(watcher)
    try:
        yield
    finally:
        _watcher.reset(token)


def present_watcher() -> Watcher[Any] | None:
    """Who watches now."""
    return _watcher.get()
