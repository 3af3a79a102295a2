"""What goes over the line: numbers with names and a count, as Drake's own message type `lcmt_drake_signal`.

Any tool that knows LCM reads and writes it (`drake/lcmt_drake_signal.lcm`): `val` and `coord`, numbers and their names,
and `timestamp`, which here counts frames of 1/30 s for a world, and decisions for a command.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from dataclasses import dataclass
from ipaddress import IPv4Address

import numpy as np
from drake import lcmt_drake_signal
from pydrake.lcm import DrakeLcm

from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.state import FloatArray

WORLD, COMMAND = "ICHAIN_WORLD", "ICHAIN_COMMAND"
"""Channels: of what a robot and its sensors say, and of what is wanted of its hand."""

HEARD, ECHO = "heard", "echo"
"""Counts of the newest command and of the newest question that a robot had when it spoke; 0 before the first."""

QUESTION = ("question",)
"""Names of a message on the commands' channel that wants no more than its count back: how long the line is."""

ADDRESS = "lcm://239.255.76.67:7667"
"""LCM's usual group; messages stay on this machine (time to live 0)."""


@dataclass(frozen=True)
class Message:
    """One message.

    Attributes:
        count: of frames, or of commands.
        names: of the numbers.
        values: shape (n_names,).
    """

    count: int
    names: tuple[str, ...]
    values: FloatArray

    def encode(self) -> bytes:
        """As LCM sends it."""
        signal = lcmt_drake_signal()
        signal.dim, signal.val, signal.coord = len(self.names), self.values.tolist(), list(self.names)
        signal.timestamp = self.count
        return bytes(signal.encode())

    @classmethod
    def decode(cls, data: bytes) -> Message | None:
        """Read what came; None for what is no such message, or holds numbers that are none."""
        try:
            signal = lcmt_drake_signal.decode(data)
            values = np.array(signal.val, dtype=float)
            names = tuple(str(name) for name in signal.coord)
        except (ValueError, struct.error, UnicodeDecodeError, IndexError, TypeError, MemoryError):
            return None
        if values.shape != (len(names),) or not np.isfinite(values).all():
            return None
        return cls(int(signal.timestamp), names, values)


def world_names(graph: InteractionGraph) -> tuple[str, ...]:
    """Names of what a world says of itself in each frame.

    For every object `object.variable` as its sensor reads it and `object valid`; then `true object.variable` and
    `true parent->child`, which only scoring reads and a real robot may send as it likes; at last `heard` and `echo`.
    """
    names = []
    for name, space in graph.objects.items():
        names += [f"{name}.{v}" for v in space.observable.names] + [f"{name} valid"]
        names += [f"true {name}.{v}" for v in space.names]
        names += [f"true {parent}->{name}" for parent in graph.parents(name)]
    return (*names, HEARD, ECHO)


def command_names(graph: InteractionGraph) -> tuple[str, ...]:
    """Names of what is commanded: the robots' observable variables."""
    return tuple(f"{root}.{v}" for root in graph.roots for v in graph.objects[root].observable.names)


def opened(address: str) -> DrakeLcm:
    """A line at an address such as `lcm://239.255.76.67:7667`; add `?ttl=1` to leave this machine.

    Raises:
        InputError: on an address that is none.
    """
    scheme, _, place = address.partition("://")
    if scheme != "lcm":
        raise InputError(f"{address!r} is no address of a robot; give one such as {ADDRESS}")
    place = place or ADDRESS.partition("://")[2]
    host, _, rest = place.partition(":")
    port, _, options = rest.partition("?")
    try:
        good = IPv4Address(host).is_multicast and 0 < int(port) < 2**16
    except ValueError:
        good = False
    if not good:  # LCM would say so on stderr, and speak to nobody
        raise InputError(f"{address}: give a multicast address and a port, such as {ADDRESS}")
    return DrakeLcm(f"udpm://{host}:{port}?{options or 'ttl=0'}")


def other_names(expected: Sequence[str], got: Sequence[str]) -> str:
    """What differs between two lists of names, in words; empty if nothing does."""
    lacking = [n for n in expected if n not in set(got)]
    if lacking:
        return f"it says nothing of {lacking[0]}"
    return "" if tuple(got) == tuple(expected) else "its values are in another order"
