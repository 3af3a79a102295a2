"""Many runs of `ichain` in processes of their own, without the imports of each: a process that has them is forked."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from patience import PATIENCE

_SERVER = """
import gc, importlib, json, os, pkgutil, sys
import ichain_drake
for module in pkgutil.walk_packages(ichain_drake.__path__, "ichain_drake."):
    if ".gymnasium" not in module.name and not module.name.endswith(("__main__", "car_racing")):
        try:
            importlib.import_module(module.name)
        except ImportError:
            pass
from ichain_drake.cli.start import main
gc.collect()
gc.freeze()  # else each process copies what it searches for garbage
print("ready", flush=True)
for line in sys.stdin:
    asked = json.loads(line)
    pid = os.fork()
    if pid == 0:
        status = 3
        try:
            os.dup2(os.open(os.devnull, os.O_RDWR), 0)
            os.dup2(os.open(asked["said"], os.O_CREAT | os.O_WRONLY | os.O_TRUNC), 1)
            os.dup2(1, 2)
            status = main(asked["arguments"])
        finally:
            os._exit(status)
    print(pid, flush=True)
    _, status, used = os.wait4(pid, 0)
    print(json.dumps([os.waitstatus_to_exitcode(status), used.ru_utime + used.ru_stime]), flush=True)
"""


@dataclass(frozen=True)
class Ended:
    """How a run ended: status (negative: by that signal), processor time [s], what it printed."""

    status: int
    seconds: float
    said: str


class Forks:
    """Runs commands one after the other.

    Args:
        place: for what they print.
    """

    def __init__(self, place: Path) -> None:
        self._said = place / "said.txt"
        self._server = subprocess.Popen(
            [sys.executable, "-c", _SERVER], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
            env=os.environ | {"OMP_NUM_THREADS": "1"},
        )  # fmt: skip
        assert self._line() == "ready"

    def _line(self) -> str:
        assert self._server.stdout is not None
        return self._server.stdout.readline().strip()

    def run(self, arguments: list[str], kill_after: float | None = None) -> Ended:
        """Run a command.

        Args:
            arguments: of `ichain`.
            kill_after: processor time after which it gets SIGKILL [s].
        """
        asked: dict[str, Any] = {"arguments": arguments, "said": str(self._said)}
        assert self._server.stdin is not None
        self._server.stdin.write(json.dumps(asked) + "\n")
        self._server.stdin.flush()
        pid = int(self._line())
        end = time.monotonic() + PATIENCE
        while kill_after is not None:
            assert time.monotonic() < end
            used = _used(pid)
            if used is None:
                break
            if used >= kill_after:
                os.kill(pid, signal.SIGKILL)
                break
            time.sleep(0.002)
        status, seconds = json.loads(self._line())
        return Ended(status, seconds, self._said.read_text(errors="replace"))

    def close(self) -> None:
        """End the process that forks."""
        self._server.communicate(timeout=PATIENCE)


def _used(pid: int) -> float | None:
    """Processor time of a process so far [s]; None if it has ended."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return None
    return None if fields[0] == "Z" else (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
