"""Reading what may be anything: nothing but a result or one line may come of it, soon, in little memory."""

from __future__ import annotations

import os
import random
import time
import warnings
from collections.abc import Callable
from pathlib import Path

from peak import taking_less_than

from ichain_drake.errors import InputError

MANY = int(os.environ.get("ICHAIN_MANY", "100"))
SLOWEST = 2.0  # [s] of this process's work; how long it waited for a busy machine says nothing
LARGEST = 2**30  # [bytes] beyond what the process had before


def tried(read: Callable[[], object]) -> None:
    """Nothing but a result or one line, soon."""
    began = time.process_time()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            read()
    except InputError as error:
        assert str(error)
        assert len(str(error).splitlines()) == 1, str(error)
    assert time.process_time() - began < SLOWEST


def survives(reader: Callable[[random.Random, Path], None], place: Path, many: int = MANY) -> None:
    """Tries a reader so many times, each with a generator of its own; a failure names it."""
    with taking_less_than(LARGEST):
        for number in range(many):
            try:
                reader(random.Random(number), place)
            except BaseException as error:
                error.add_note(f"{reader.__name__}(random.Random({number}), place)")
                raise
