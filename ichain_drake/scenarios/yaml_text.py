"""Reading YAML that somebody wrote: nothing is executed, and nothing small in the file is large in memory."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import yaml

from ichain_drake.errors import InputError

_MOST_CHARACTERS = 10**6
_MOST_VALUES = 10**5
"""Of a file with its aliases written out; the largest scenario of this package has some hundred."""


def read_yaml(text: str, where: str) -> Any:
    """The value of a YAML text.

    Args:
        text: of a file, or of one setting.
        where: what to call it in errors.

    Raises:
        InputError: on malformed YAML, or one that is too large or too deep, aliases written out.
    """
    if len(text) > _MOST_CHARACTERS:
        raise InputError(f"{where}: {len(text)} characters are no settings; give at most {_MOST_CHARACTERS}")
    try:
        value = yaml.safe_load(text)
        count = _count(value)
    except RecursionError:
        raise InputError(f"{where}: malformed value: it is nested too deeply") from None
    except (yaml.YAMLError, ValueError, OverflowError) as error:  # dates and numbers that can't be
        raise InputError(f"{where}: malformed value: {one_line(error)[:300]}") from None
    if count > _MOST_VALUES:
        raise InputError(f"{where}: malformed value: with its aliases written out it has over {_MOST_VALUES} values")
    return value


def _count(value: Any) -> int:
    """How many values there are with aliases written out, up to a little over the most that are allowed."""
    count, left = 0, [value]
    while left and count <= _MOST_VALUES:
        node = left.pop()
        count += 1
        if isinstance(node, Mapping):
            left += [*node.keys(), *node.values()]
        elif isinstance(node, list | tuple | set):
            left += list(node)
    return count


def one_line(error: BaseException) -> str:
    """An error's text without line breaks."""
    return re.sub(r"\s+", " ", str(error)).strip()
