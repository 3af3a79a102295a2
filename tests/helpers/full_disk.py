"""Files that may not grow, as on a full disk."""

import os
import resource
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from unittest.mock import patch


@contextmanager
def room_for(size: int) -> Iterator[None]:
    """Meanwhile no file of this process and its children gets larger than `size` bytes.

    Bytecode of what is imported meanwhile isn't written: Python would leave cut files, and read them ever after.
    """
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    with patch.object(sys, "dont_write_bytecode", True), patch.dict(os.environ, {"PYTHONDONTWRITEBYTECODE": "1"}):  # noqa: FBT003
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
        try:
            yield
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
