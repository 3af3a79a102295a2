"""Jobs of the runner that take no time: they note that they ran, raise, hang, crash, or kill their process."""

import faulthandler
import os
import signal
import sys
import time
from dataclasses import dataclass
from pathlib import Path

from ichain_drake import rules


@dataclass(frozen=True)
class ToyJob:
    """Finds its number; what else it does is in `deeds`, by id."""

    ids: tuple[str, ...]
    folder: Path
    deeds: tuple[tuple[str, str], ...] = ()

    def run(self, ids):
        for name in ids:
            with (self.folder / "ran").open("a") as stream:
                stream.write(f"{name}\n")
            self._do(dict(self.deeds).get(name, ""), name)
            yield name, {"name": name, "off": sorted(rules.switched_off())}

    def _do(self, deed, name):
        if deed == "raise":
            raise ZeroDivisionError("by nought")
        if deed == "interrupt":
            raise KeyboardInterrupt
        if deed == "crash":
            faulthandler.disable()
            os.kill(os.getpid(), signal.SIGABRT)
        if deed == "exit":
            sys.exit(3)
        if deed == "hang":
            time.sleep(600)
        if deed == "release":
            (self.folder / "others are done").touch()
        if deed in ("die", "die once", "kill worker once"):
            once = self.folder / f"{name} died"
            if deed != "die" and once.exists():
                return
            once.touch()
            while not (self.folder / "others are done").exists():
                time.sleep(0.05)
            time.sleep(0.3)
            os.kill(os.getppid() if deed == "kill worker once" else os.getpid(), signal.SIGKILL)
            time.sleep(600)  # dies with its worker

    def failed(self, name, reason):
        return {"name": name, "reason": reason}

    def ran(self):
        file = self.folder / "ran"
        return file.read_text().split() if file.exists() else []


def exhaust(job):
    return list(job.run(job.ids))
