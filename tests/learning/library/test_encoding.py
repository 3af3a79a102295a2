"""What files hold as lists: refused in one line where it is none of what is needed."""

from typing import Any

import pytest

from ichain_drake.errors import InputError
from ichain_drake.learning.library.encoding import Decoder


def decoded(data: Any) -> Any:
    return Decoder({}, (), "graph.json").decode(dict[str, int], data, "model.low")


def test_a_mapping_is_a_list_of_pairs() -> None:
    assert decoded([["a", 1], ["b", 2]]) == {"a": 1, "b": 2}
    assert decoded([]) == {}


@pytest.mark.parametrize("data", [{"a": 1}, [["a", 1, 2]], [["a"]], [["a", 1], "b"], "ab"])
def test_anything_else_is_refused(data: Any) -> None:
    with pytest.raises(InputError, match=r"model\.low: a list of pairs is needed, found"):
        decoded(data)


def test_a_key_is_there_once() -> None:
    with pytest.raises(InputError, match="'a' is there twice"):
        decoded([["a", 1], ["a", 2]])
