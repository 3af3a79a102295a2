"""Signals for a command in a process of its own: at a frame of an episode, or once it has said something."""

import os
import signal
import subprocess
import sys

from patience import PATIENCE

STATUS = 130

# A shell's background jobs, and some test runners, ignore SIGINT; a child would inherit that.
LISTENING = """
import signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
from ichain_drake.cli.start import main
sys.exit(main())
"""
IMPATIENT = """
import os, signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
from ichain_drake.cli.start import main
from ichain_drake.simulation.watching import watched_by

class Impatient:
    frames, following = int(os.environ["PRESS_AT_FRAME"]), bool(int(os.environ["PRESS_WHILE_FOLLOWING"]))
    count = 0

    def begin(self, episode):
        pass

    def frame(self, episode):
        self.count += (episode.path is not None) == self.following
        if self.count == self.frames:
            os.kill(os.getpid(), int(os.environ["PRESS"]))
        return False

with watched_by(Impatient()):
    sys.exit(main())
"""


def interrupt(
    arguments: list[str],
    frame: int = 0,
    *,
    following: bool = False,
    at: str | None = None,
    number: signal.Signals = signal.SIGINT,
) -> tuple[int, str, str]:
    """Run `ichain` and send it a signal; gives status, stdout and stderr.

    Args:
        arguments: of the command.
        frame: in which it gets the signal, counted from the first of an episode's; 0 for in none.
        following: whether frames count in which a path is followed, or those of all others.
        at: a text that it says before it gets the signal, in place of a frame.
        number: the signal.
    """
    environment = {
        "PRESS_AT_FRAME": str(frame),
        "PRESS_WHILE_FOLLOWING": str(int(following)),
        "PRESS": str(int(number)),
    }
    process = subprocess.Popen(
        [sys.executable, "-c", IMPATIENT, *arguments],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        env=os.environ | {"OMP_NUM_THREADS": "1"} | environment,
    )  # fmt: skip
    assert process.stderr is not None
    said = ""
    if at is not None:
        for line in process.stderr:
            said += line
            if at in line:
                process.send_signal(number)
                break
    out, err = process.communicate(timeout=PATIENCE)
    return process.returncode, out, said + err


def errors(stderr: str) -> list[str]:
    return [line for line in stderr.splitlines() if not line.startswith("[")]
