"""What files hold as lists: refused in one line where it is none of what is needed."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import pytest
from numpy.typing import NDArray

from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction
from ichain_drake.learning.library.encoding import Decoder, encode


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


@dataclass(frozen=True)
class Part:
    """One of two kinds that may stand in a place."""

    size: float
    edge: Interaction | None


@dataclass(frozen=True)
class Other:
    name: str


@dataclass(frozen=True)
class Whole:
    kind: Literal["small", "large"]
    on: bool
    count: int
    table: NDArray[np.float64]
    rows: NDArray[np.intp]
    parts: tuple[Part | Other, ...]
    pair: tuple[int, str]
    by_edge: Mapping[Interaction, float]


EDGE = Interaction("a", "b")
WHOLE = Whole(
    "small", True, 3, np.array([[0.5, 1.0]]), np.array([2, 1]), (Part(1.5, EDGE), Other("x"), Part(2.0, None)),
    (7, "seven"), {EDGE: 0.25},
)  # fmt: skip


def encoded() -> tuple[Any, dict[str, Any]]:
    arrays: dict[str, Any] = {}
    return encode(WHOLE, "model", arrays), arrays


def test_what_is_taken_apart_is_built_again_by_its_types_alone() -> None:
    data, arrays = encoded()
    assert sorted(arrays) == ["model.rows", "model.table"]
    decoder = Decoder(arrays, (EDGE,), "graph.json")
    again = decoder.decode(Whole, json.loads(json.dumps(data)), "model")
    decoder.finish()
    for name in ("kind", "on", "count", "parts", "pair", "by_edge"):
        assert getattr(again, name) == getattr(WHOLE, name), name
    np.testing.assert_array_equal(again.table, WHOLE.table)
    np.testing.assert_array_equal(again.rows, WHOLE.rows)
    assert isinstance(again.count, int) and isinstance(again.parts, tuple)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, np.float64("nan"), 1j, b"bytes", object()])
def test_what_is_no_plain_value_or_no_number_can_not_be_saved(value: Any) -> None:
    with pytest.raises(InputError, match=r"model\[1\]: .* can't be saved; it is no plain value or no finite number"):
        encode((1, value), "model", {})
    assert encode((np.float64(2.5), np.int64(3), np.bool_(True), None, "x"), "m", {}) == [2.5, 3, True, None, "x"]


def changed(path: str, value: Any) -> tuple[Any, dict[str, Any]]:
    data, arrays = encoded()
    *way, last = [int(k) if k.isdigit() else k for k in path.split("/")]
    at = data
    for step in way:
        at = at[step]
    if value is KeyError:
        del at[last]
    else:
        at[last] = value
    return data, arrays


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        ("kind", "huge", r"model\.kind"),
        ("on", 1, r"model\.on"),
        ("count", 2.5, r"model\.count"),
        ("count", True, r"model\.count"),
        ("table", "model.rows", r"model\.table: its array is missing"),
        ("parts", {"a": 1}, r"model\.parts: a list is needed"),
        ("pair", [7], r"model\.pair: a list is needed"),
        ("pair", [7, "seven", 8], r"model\.pair: a list is needed"),
        ("pair/1", 7, r"model\.pair\[1\]"),
        ("parts/0/is", "Other", r"model\.parts\[0\]\.size: unknown field|model\.parts\[0\]\.name: missing"),
        ("parts/0/is", "Whole", r"model\.parts\[0\]\.is: 'Whole' can't stand here"),
        ("parts/0", None, r"model\.parts\[0\]"),
        ("parts/0/edge", "a->c", r"model\.parts\[0\]\.edge"),
        ("parts/1/name", KeyError, r"model\.parts\[1\]\.name: missing"),
        ("more", 1, r"model\.more: unknown field"),
        ("is", "Part", r"model\.is"),
        ("is", KeyError, r"model\.is"),
    ],
)
def test_what_is_of_another_form_is_refused_with_its_place(path: str, value: Any, message: str) -> None:
    data, arrays = changed(path, value)
    with pytest.raises(InputError, match=f"graph.json.*({message})"):
        Decoder(arrays, (EDGE,), "graph.json").decode(Whole, data, "model")


def test_arrays_are_of_their_type_finite_and_all_of_the_model() -> None:
    data, arrays = encoded()
    for name, array, message in (
        ("model.table", np.array([1, 2]), "an array of int64, float64 is needed"),
        ("model.table", np.array([[np.nan, 0.0]]), "a number in its array is not finite"),
        ("model.rows", np.array([0.5]), "an array of float64, int64 is needed"),
    ):
        with pytest.raises(InputError, match=f"{name}: {message}"):
            Decoder({**arrays, name: array}, (EDGE,), "graph.json").decode(Whole, data, "model")
    more = Decoder({**arrays, "b": np.zeros(1), "a": np.zeros(1)}, (EDGE,), "graph.json")
    more.decode(Whole, data, "model")
    with pytest.raises(InputError, match="a: an array that is no part of the model"):
        more.finish()
    with pytest.raises(TypeError, match="is no type that is saved"):
        Decoder({}, (), "graph.json").decode(bytes, b"", "model")
