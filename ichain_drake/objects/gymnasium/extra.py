"""Gymnasium is an extra: it is imported when a game is opened, and its absence is said in one line."""

from __future__ import annotations

import importlib
from types import ModuleType

from ichain_drake.errors import InputError

HINT = "install it with `pip install 'ichain_drake[games]'`"


def require_gymnasium(part: str = "") -> ModuleType:
    """Gymnasium, or one of its modules.

    Args:
        part: such as `spaces`; empty for the package itself.

    Raises:
        InputError: if it, or what that module needs, is not installed; says what to install.
    """
    try:
        return importlib.import_module(f"gymnasium.{part}" if part else "gymnasium")
    except ImportError as error:  # Gymnasium's own complaint about a missing physics engine is one too
        missing = getattr(error, "name", None) or str(error).split(",")[0]
        raise InputError(f"this needs Gymnasium ({missing} is missing); {HINT}") from None
