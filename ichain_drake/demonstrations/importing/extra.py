"""Readers and writers of others' formats need the extra `logs`, imported where they are used."""

from __future__ import annotations

import importlib
from types import ModuleType

from ichain_drake.errors import InputError

HINT = "install it with `pip install 'ichain_drake[logs]'`"


def require(module: str, what: str) -> ModuleType:
    """A module of the extra.

    Args:
        module: its name.
        what: needs it, for the error.

    Raises:
        InputError: if it is not installed; says what to install.
    """
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise InputError(f"{what} needs {error.name or module}, which is missing; {HINT}") from None
