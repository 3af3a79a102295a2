"""How much memory something takes at its peak, as Linux counts it; elsewhere it counts as none."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

_STATUS, _RESET = Path("/proc/self/status"), Path("/proc/self/clear_refs")


def _bytes(key: str) -> int:
    lines = _STATUS.read_text().splitlines() if _STATUS.exists() else []
    return next((1024 * int(line.split()[1]) for line in lines if line.startswith(f"{key}:")), 0)


@contextmanager
def taking_less_than(most: int) -> Iterator[None]:
    """Fails where the process holds at any moment so many bytes more than at the start."""
    with suppress(OSError):
        _RESET.write_text("5")
    before = _bytes("VmRSS")
    yield
    taken = _bytes("VmHWM") - before
    assert taken < most, f"{taken / 1e6:.0f} MB, {most / 1e6:.0f} allowed"
