"""One thread of linear algebra where results must not depend on how many there are."""

from __future__ import annotations

from contextlib import AbstractContextManager
from functools import cache
from typing import Any

import numpy.linalg  # noqa: F401 - loads the libraries that are held to one thread
import scipy.linalg  # noqa: F401 - the same
from threadpoolctl import ThreadpoolController


def one_blas_thread() -> AbstractContextManager[Any]:
    """Hold NumPy's and SciPy's linear algebra to one thread; afterwards it has as many as before."""
    return _libraries().limit(limits=1, user_api="blas")


@cache
def _libraries() -> ThreadpoolController:
    """All that is loaded. To look for it takes as long as a small fit, so that it is done once a process."""
    return ThreadpoolController()
