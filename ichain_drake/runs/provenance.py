"""What a result came from: versions of what was used, what was given, and a hash of the demonstrations."""

from __future__ import annotations

import contextlib
import hashlib
import importlib.metadata
import inspect
import platform
from collections.abc import Collection
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from ichain_drake import rules
from ichain_drake.control.settings import constants
from ichain_drake.scenarios.config import as_plain


def versions() -> dict[str, str]:
    """Versions that a result may depend on."""
    names = ("ichain_drake", "drake", "numpy", "scipy", "scikit-learn", "pandas")
    found = {"python": platform.python_version()}
    for name in names:
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            found[name] = "not installed"
    for name in ("gymnasium", "box2d"):  # an extra
        with contextlib.suppress(importlib.metadata.PackageNotFoundError):
            found[name] = importlib.metadata.version(name)
    return found


def printed(text: str, command: str) -> dict[str, Any]:
    """What a report says of its table, so that pages can show it: the text, the command, the date and the versions.

    Args:
        text: of the table.
        command: that prints it.
    """
    return {"text": text, "command": command, "date": datetime.now(UTC).date().isoformat(), "versions": versions()}


def given_of(scenario: Any) -> dict[str, Any]:
    """What a scenario declares instead of learning, the constants of learning and control, and rules switched off.

    The latter are `constants`, by part, and `without`, if any.
    """
    off = rules.switched_off()
    return {**scenario.given(), "constants": as_plain(constants()), **({"without": sorted(off)} if off else {})}


def code_hash(kinds: Collection[type] = ()) -> str:
    """A hash of this package's code and of the files that define other classes, to tell rows of changed code apart.

    Args:
        kinds: classes of systems; those of this package are in its hash already.
    """
    files = set(Path(rules.__file__).parent.rglob("*.py"))
    for kind in kinds:
        with contextlib.suppress(TypeError, OSError):  # a class without a file, of a notebook say
            files.add(Path(inspect.getsourcefile(kind) or ""))
    digest = hashlib.sha256()
    for file in sorted(f for f in files if f.is_file()):
        digest.update(file.name.encode() + b"\0" + file.read_bytes())
    return digest.hexdigest()[:12]
