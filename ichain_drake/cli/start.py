"""Where the command `ichain` begins: signals and streams are put in order before anything large is imported."""

from __future__ import annotations

import atexit
import gc
import signal
import sys
from collections.abc import Sequence
from types import FrameType

from ichain_drake.cli.streams import guard_streams

_INTERRUPTED = 130
_UNLOOKED = 100_000  # objects that are made before garbage is looked for; imports make 370 000 that all stay


class Stop:
    """Turns SIGINT and SIGTERM into `KeyboardInterrupt`, and remembers which it was.

    Attributes:
        number: of the signal; 0 as long as there was none.
    """

    def __init__(self) -> None:
        self.number = 0
        for number in (signal.SIGINT, signal.SIGTERM):
            # Who starts a program with a signal ignored, as `nohup` and background jobs of a shell, means it.
            if signal.getsignal(number) is not signal.SIG_IGN:
                signal.signal(number, self._stop)

    def _stop(self, number: int, frame: FrameType | None) -> None:
        self.number = number
        raise KeyboardInterrupt

    @property
    def status(self) -> int:
        """Exit status, as a shell gives it."""
        stepping = sys.modules.get("ichain_drake.simulation.interruption")
        number = self.number or (stepping.held_back[-1] if stepping and stepping.held_back else signal.SIGINT)
        return 128 + int(number)


def main(arguments: Sequence[str] | None = None) -> int:
    """Entry point of `ichain`; returns the exit status.

    Args:
        arguments: in place of the command line's.
    """
    gc.set_threshold(_UNLOOKED)
    atexit.register(gc.freeze)  # the process ends: its memory need not be searched once more
    stop = Stop()
    streams = guard_streams()
    try:
        from ichain_drake.cli.main import main as run  # noqa: PLC0415

        status = run(arguments)
    except BaseException:
        # A signal in the middle of an import may come out of it as any error.
        if not stop.number and not isinstance(sys.exc_info()[1], KeyboardInterrupt):
            raise
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # a second one has nothing left to stop
        print("ichain: interrupted", file=sys.stderr)
        status = _INTERRUPTED
    return streams.finish(stop.status if status == _INTERRUPTED else status)
