"""Ctrl-C, or a request to end, at a moment when nothing is half done."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

held_back: list[int] = []
"""Numbers of the signals that were held back, in order; who ends the process tells its status by the last."""


@contextmanager
def deferred_interrupt() -> Iterator[Callable[[], bool]]:
    """Hold Ctrl-C (and SIGTERM, where it raises) back while a simulation steps; whoever steps asks between ticks.

    Raised at once, it may come while Drake's bindings convert an argument, which then say that its type is wrong: one
    in about eighty did, and took the recording with it. A second one is not held back; one that nobody asked for any
    more is raised at the end.

    Yields:
        Whether there was one since. Always false outside the main thread, and where the signals do not raise.
    """
    usual = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    raising = {number: handler for number, handler in usual.items() if callable(handler)}
    if threading.current_thread() is not threading.main_thread() or not raising:
        yield lambda: False
        return
    pressed: list[int] = []
    told = False

    def note(number: int, frame: FrameType | None) -> None:
        pressed.append(number)
        held_back.append(number)
        if len(pressed) > 1:
            raising[signal.Signals(number)](number, frame)

    def ask() -> bool:
        nonlocal told
        told = bool(pressed)
        return told

    for number in raising:
        signal.signal(number, note)
    try:
        yield ask
    finally:
        for number, handler in raising.items():
            signal.signal(number, handler)
    if pressed and not told:
        raise KeyboardInterrupt
