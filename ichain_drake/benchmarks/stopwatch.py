"""Which Python system takes how long: a stopwatch around every callback that a LeafSystem declares."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

from pydrake.systems.framework import LeafSystem

_DECLARATIONS = (
    "DeclareVectorOutputPort",
    "DeclareAbstractOutputPort",
    "DeclarePeriodicUnrestrictedUpdateEvent",
    "DeclarePeriodicDiscreteUpdateEvent",
    "DeclarePeriodicPublishEvent",
)


@dataclass
class Stopwatch:
    """Time spent in each system's own callbacks, without that of the callbacks they call by evaluating ports.

    Attributes:
        seconds: per system [s].
        calls: per system.
        names: of the systems that were called, with their place in the Diagram.
    """

    seconds: dict[LeafSystem, float] = field(default_factory=dict)
    calls: dict[LeafSystem, int] = field(default_factory=dict)
    names: dict[LeafSystem, str] = field(default_factory=dict)
    _inner: list[float] = field(default_factory=list)

    def reset(self) -> None:
        """Start over."""
        self.seconds = dict.fromkeys(self.seconds, 0.0)
        self.calls = dict.fromkeys(self.calls, 0)

    def by_name(self) -> dict[str, tuple[float, int]]:
        """Seconds and calls, the most expensive system first; systems of several Diagrams at one place are one."""
        found: dict[str, tuple[float, int]] = {}
        for system, name in self.names.items():
            seconds, calls = found.get(name, (0.0, 0))
            found[name] = (seconds + self.seconds[system], calls + self.calls[system])
        return dict(sorted(found.items(), key=lambda item: -item[1][0]))

    def timed(self, system: LeafSystem, callback: Callable[..., Any]) -> Callable[..., Any]:
        """The callback, timed on the system's account."""
        self.seconds.setdefault(system, 0.0)
        self.calls.setdefault(system, 0)

        def run(*args: Any) -> Any:
            if system not in self.names:  # its Diagram may be gone when somebody asks
                self.names[system] = _place(system)
            begin = time.thread_time()
            self._inner.append(0.0)
            try:
                return callback(*args)
            finally:
                whole = time.thread_time() - begin
                self.seconds[system] += whole - self._inner.pop()
                self.calls[system] += 1
                if self._inner:
                    self._inner[-1] += whole

        return run


def _place(system: LeafSystem) -> str:
    name = system.GetSystemPathname()
    for outer in ("::", "_::", "world::", "controller::"):
        name = name.removeprefix(outer)
    return name.replace("::", "/")


@contextmanager
def timed_callbacks() -> Iterator[Stopwatch]:
    """A stopwatch on every Python system that is constructed within the `with` block.

    Drake offers no hook around callbacks, so the methods that declare them are wrapped for as long as the block lasts.
    """
    watch = Stopwatch()
    originals = {name: getattr(LeafSystem, name) for name in _DECLARATIONS}

    def wrapped(original: Callable[..., Any]) -> Callable[..., Any]:
        def declare(system: LeafSystem, *args: Any, **kwargs: Any) -> Any:
            def watched(value: Any) -> Any:
                return watch.timed(system, value) if callable(value) and not isinstance(value, type) else value

            return original(system, *map(watched, args), **{k: watched(v) for k, v in kwargs.items()})

        return declare

    try:
        for name, original in originals.items():
            setattr(LeafSystem, name, wrapped(original))
        yield watch
    finally:
        for name, original in originals.items():
            setattr(LeafSystem, name, original)
