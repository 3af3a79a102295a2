"""Mapping files: their form, and what is refused."""

import pytest

from ichain_drake.demonstrations.importing import Source, parse_map
from ichain_drake.errors import InputError


def test_sources_targets_and_units() -> None:
    mapping = parse_map({"columns": {"state[0]": "cup.x [mm]", "/a:b.c": "hand->cup"}, "rate": 20, "time": "t[1]"}, "m")
    assert mapping.columns == {Source("state[0]", "state", "0"): "cup.x", Source("/a:b.c", "/a:b.c"): "hand->cup"}
    assert mapping.units == {"cup.x": "mm"}
    assert mapping.rate == 20.0
    assert mapping.time == Source("t[1]", "t", "1")
    assert [s.text for s in mapping.sources] == ["state[0]", "/a:b.c", "t[1]"]


@pytest.mark.parametrize(
    ("plain", "what"),
    [
        (None, "a map has columns"),
        ({"columns": {}}, "a map has columns"),
        ({"columns": {"a": "cup.x"}, "speed": 3}, "'speed' is unknown"),
        ({"columns": {"a": "cup"}}, "'cup' is no target"),
        ({"columns": {"a": "time"}}, "'time' is no target"),
        ({"columns": {"a": "../x.y"}}, "is no target"),
        ({"columns": {1: "cup.x"}}, "write texts on both sides"),
        ({"columns": {"a": {"cup": "x"}}}, "write texts on both sides"),
        ({"columns": {"a": "cup.x", "b": "cup.x [m]"}}, "cup.x is named twice"),
        ({"columns": {"[0]": "cup.x"}}, "is no source"),
        ({"columns": {"a": "cup.x"}, "rate": 0}, "rate '0': give rows a second"),
        ({"columns": {"a": "cup.x"}, "rate": True}, "rate 'True'"),
        ({"columns": {"a": "cup.x"}, "time": 3}, "time '3': give the source"),
    ],
)
def test_what_is_no_map_is_refused_in_one_line(plain: object, what: str) -> None:
    with pytest.raises(InputError, match=what) as told:
        parse_map(plain, "m.yaml")
    assert "\n" not in str(told.value)
