"""How long tests wait for something in another process or in a browser.

They wait for conditions, so that the ceiling costs nothing where the condition comes true; it only ends a test that
hangs. It is long because a browser that draws without a graphics card shares the machine with whatever else runs there.
"""

import time
from collections.abc import Callable
from typing import TypeVar

T = TypeVar("T")

PATIENCE = 180.0
"""[s]"""


def until(condition: Callable[[], T], seconds: float = PATIENCE) -> T:
    """Wait for something that is true, and return it."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        found = condition()
        if found:
            return found
        time.sleep(0.05)
    raise AssertionError(f"it did not happen within {seconds} s")
