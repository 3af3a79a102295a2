"""Reading YAML that somebody wrote: nothing is executed, and nothing small in the file is large in memory."""

from __future__ import annotations

import re
from typing import Any

import yaml

from ichain_drake.errors import InputError

_MOST_CHARACTERS = 10**5  # half a second of reading; the largest scenario of this package has 2 * 10**3
_MOST_VALUES = 2 * 10**4
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
        loader = yaml.SafeLoader(text)
        try:
            node = loader.get_single_node()
            # Before values are made of it: mappings that are merged into each other are written out then.
            count = _count(node)
            value = loader.construct_document(node) if node is not None and count <= _MOST_VALUES else None
        finally:
            loader.dispose()
    except RecursionError:
        raise InputError(f"{where}: malformed value: it is nested too deeply") from None
    except Exception as error:  # dates and numbers that can't be come out as errors of any kind
        raise InputError(f"{where}: malformed value: {one_line(error)[:300]}") from None
    if count > _MOST_VALUES:
        raise InputError(f"{where}: malformed value: with its aliases written out it has over {_MOST_VALUES} values")
    return value


def _count(root: yaml.Node | None) -> int:
    """How many values there are with aliases written out, up to a little over the most that are allowed."""
    count, left = 0, [root]
    while left and count <= _MOST_VALUES:
        node = left.pop()
        count += 1
        if isinstance(node, yaml.MappingNode):
            left += [part for pair in node.value for part in pair]
        elif isinstance(node, yaml.SequenceNode):
            left += node.value
    return count


def one_line(error: BaseException) -> str:
    """An error's text without line breaks."""
    return re.sub(r"\s+", " ", str(error)).strip()
