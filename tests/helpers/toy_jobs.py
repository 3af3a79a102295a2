"""Jobs of the runner that take no time: they note that they ran, raise, or kill their process."""

import os
import signal
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
            deed = dict(self.deeds).get(name, "")
            if deed == "raise":
                raise ZeroDivisionError("by nought")
            if deed == "interrupt":
                raise KeyboardInterrupt
            if deed == "die":
                while not (self.folder / "others are done").exists():
                    time.sleep(0.05)
                time.sleep(0.3)
                os.kill(os.getpid(), signal.SIGKILL)
            if deed == "release":
                (self.folder / "others are done").touch()
            yield name, {"name": name, "off": sorted(rules.switched_off())}

    def failed(self, name, reason):
        return {"name": name, "reason": reason}

    def ran(self):
        file = self.folder / "ran"
        return file.read_text().split() if file.exists() else []


def exhaust(job):
    return list(job.run(job.ids))
