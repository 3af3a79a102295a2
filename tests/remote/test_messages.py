"""What goes over the line, what comes over it that is none of it, and a bad line on purpose."""

import numpy as np
import pytest
import small_world
from hypothesis import given
from hypothesis import strategies as st

from ichain_drake.errors import InputError
from ichain_drake.remote.lossy import Lossy
from ichain_drake.remote.messages import Message, command_names, opened, other_names, world_names

NAMES = st.lists(st.text(st.characters(codec="ascii", exclude_characters="\0"), max_size=12), max_size=6)


@given(NAMES, st.integers(0, 2**62), st.data())
def test_what_is_sent_is_what_comes(names: list[str], count: int, data: st.DataObject) -> None:
    values = np.array([data.draw(st.floats(allow_nan=False, allow_infinity=False)) for _ in names])
    got = Message.decode(Message(count, tuple(names), values).encode())
    assert got is not None
    assert (got.count, got.names) == (count, tuple(names))
    np.testing.assert_array_equal(got.values, values)


@given(st.binary(max_size=200))
def test_what_is_no_message_is_none(data: bytes) -> None:
    assert Message.decode(data) is None


@given(st.integers(0, 200), st.integers(1, 255))
def test_a_damaged_message_is_none_or_has_a_value_for_each_name(place: int, change: int) -> None:
    whole = bytearray(Message(3, ("hand.x", "hand.y"), np.array([1.0, 2.0])).encode())
    whole[place % len(whole)] ^= change
    for data in (bytes(whole), bytes(whole[: place % len(whole)])):
        got = Message.decode(data)
        assert got is None or (len(got.values) == len(got.names) and np.isfinite(got.values).all())


@pytest.mark.parametrize("wrong", [np.nan, np.inf])
def test_numbers_that_are_none_are_not_taken(wrong: float) -> None:
    assert Message.decode(Message(1, ("hand.x",), np.array([wrong])).encode()) is None


def test_a_world_says_of_each_object_what_is_measured_and_what_is_true() -> None:
    names = world_names(small_world.GRAPH)
    assert len(set(names)) == len(names)
    for obj, space in small_world.GRAPH.objects.items():
        assert {f"{obj}.{v}" for v in space.observable.names} | {f"{obj} valid"} <= set(names)
        assert {f"true {obj}.{v}" for v in space.names} <= set(names)
    assert {f"true {e.name}" for e in small_world.GRAPH.interactions} <= set(names)
    assert names[-2:] == ("heard", "echo")
    assert command_names(small_world.GRAPH)[0] == "hand.x"


def test_what_differs_between_two_robots_is_said() -> None:
    assert other_names(("a", "b"), ("a", "b")) == ""
    assert other_names(("a", "b"), ("a", "c")) == "it says nothing of b"
    assert other_names(("a", "b"), ("b", "a")) == "its values are in another order"


@pytest.mark.parametrize("address", ["udpm://239.255.76.67:7667", "239.255.76.67", "", "lcm://nowhere:7667",
                                     "lcm://239.255.76.67:99999"])  # fmt: skip
def test_an_address_that_is_none_is_refused_with_one_that_is(address: str) -> None:
    with pytest.raises(InputError, match=r"give .*lcm://239\.255\.76\.67:7667"):
        opened(address)


def test_a_bad_line_loses_its_share_and_keeps_the_order() -> None:
    line: Lossy[int] = Lossy(0.2, 3, seed=1)
    got = []
    for frame in range(2000):
        line.put(frame, frame)
        now = line.get(frame)
        assert all(k == frame - 3 for k in now)
        got += now
    assert got == sorted(got)
    assert len(got) / 1997 == pytest.approx(0.8, abs=0.03)
    again: Lossy[int] = Lossy(0.2, 0, seed=1)
    kept = []
    for frame in range(2000):
        again.put(frame, frame)
        kept += again.get(frame)
    assert kept[: len(got)] == got  # the same ones are lost


@pytest.mark.parametrize(("lost", "late", "said"), [(1.0, 0, "--lost 1"), (-0.1, 0, "--lost"), (0.1, -1, "--late")])
def test_what_no_line_does_is_refused(lost: float, late: int, said: str) -> None:
    with pytest.raises(InputError, match=said):
        Lossy(lost, late)
