"""Ctrl-C for a command in a process of its own."""

import os
import signal
import subprocess
import sys
import time

STATUS = 130

# A shell's background jobs, and some test runners, ignore SIGINT; a child would inherit that.
LISTENING = """
import signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
from ichain_drake.cli.main import main
sys.exit(main())
"""


def interrupt(arguments: list[str], at: str, after: float) -> tuple[int, str, str]:
    """Run `ichain` and send SIGINT some time after it has said something; gives status, stdout and stderr."""
    process = subprocess.Popen(
        [sys.executable, "-c", LISTENING, *arguments],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=os.environ | {"OMP_NUM_THREADS": "1"},
    )  # fmt: skip
    assert process.stderr is not None
    said = ""
    for line in process.stderr:
        said += line
        if at in line:
            time.sleep(after)
            process.send_signal(signal.SIGINT)
            break
    out, err = process.communicate(timeout=60)
    return process.returncode, out, said + err


def errors(stderr: str) -> list[str]:
    return [line for line in stderr.splitlines() if not line.startswith("[")]
