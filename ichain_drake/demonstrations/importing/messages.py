"""From messages of several topics to one table: fields found by their names, rows at every message's time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ichain_drake.demonstrations.importing.log_map import LogMap
from ichain_drake.demonstrations.importing.pieces import check_size, few, piece_of
from ichain_drake.demonstrations.importing.rotations import angles_of
from ichain_drake.demonstrations.importing.sources import Source
from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.files import printable
from ichain_drake.state import FloatArray

_NANO = 1e-9


@dataclass(frozen=True)
class Message:
    """A message as a reader decoded it.

    Attributes:
        topic: it was sent on.
        nanoseconds: when it was logged.
        content: an object with fields, or a mapping.
    """

    topic: str
    nanoseconds: int
    content: Any


def topic_and_field(source: Source) -> tuple[str, tuple[str, ...]]:
    """`/topic:field.part` as its topic and the names of the fields that lead to the number.

    Raises:
        InputError: on another form.
    """
    topic, colon, path = source.name.rpartition(":")
    if not colon or not topic or not all(path.split(".")):
        raise InputError(
            f"map: {printable(source.text)!r:.80} is no source here; write /topic:field or /topic:field.part"
        )
    return topic, tuple(path.split("."))


@dataclass
class MessageTable:
    """Fills a table message by message.

    Attributes:
        mapping: what is wanted. Its `time` is a field of every message that tells when it was taken, in seconds or as
            a stamp of `sec` and `nanosec`; without it, the time at which it was logged counts.
        where: what to call the log in errors.
    """

    mapping: LogMap
    where: str
    _times: list[float] = field(default_factory=list)
    _values: dict[Source, list[float]] = field(default_factory=dict)
    _rows: dict[Source, list[int]] = field(default_factory=dict)
    _seen: dict[str, None] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.wanted: dict[str, list[tuple[Source, tuple[str, ...]]]] = {}
        for source in self.mapping.values:
            topic, path = topic_and_field(source)
            self.wanted.setdefault(topic, []).append((source, path))
            self._values[source], self._rows[source] = [], []
        for rotation in self.mapping.rotations:
            topics = {topic_and_field(source)[0] for source in rotation.sources}
            if len(topics) > 1:
                raise InputError(
                    f"map: {rotation.text} is of {few(sorted(topics))}; a rotation comes in one message, of one topic"
                )

    def note(self, topic: str) -> None:
        """A topic that is there, wanted or not."""
        self._seen[topic] = None

    def add(self, message: Message) -> None:
        """Take note of a message.

        Raises:
            InputError: if a wanted field is missing or no number, or there are too many messages.
        """
        if message.topic not in self.wanted:
            return
        check_size(len(self._times), self.mapping, self.where)
        self._times.append(self._time(message))
        for source, path in self.wanted[message.topic]:
            self._values[source].append(self._number(message.content, path, source))
            self._rows[source].append(len(self._times) - 1)

    def piece(self, name: str) -> Demonstration:
        """The table: a row at each time, empty cells where a topic had no message then.

        Raises:
            InputError: if a topic has no message at all, or one without a rotation where there should be one.
        """
        for source, rows in self._rows.items():
            if not rows:
                raise InputError(
                    f"{self.where}: there is no message of {printable(topic_and_field(source)[0])}; it has "
                    f"{few(self._seen)}"
                )
        times, row_of = np.unique(np.array(self._times), return_inverse=True)
        columns = {}
        for target, (rows, values) in self._found().items():
            columns[target] = np.full(len(times), np.nan)
            columns[target][row_of[rows]] = values  # of two at one time, the later counts
        return piece_of(name, times, columns, self.mapping)

    def _found(self) -> dict[str, tuple[list[int], FloatArray]]:
        """Of each column the rows in which it has values, and these: rotations are made of whole messages."""
        values = {source: np.array(found) for source, found in self._values.items()}
        columns = {target: (self._rows[s], values[s]) for s, target in self.mapping.columns.items()}
        for rotation in self.mapping.rotations:
            rows = self._rows[rotation.sources[0]]
            columns |= {t: (rows, angle) for t, angle in angles_of(rotation, values, self.where).items()}
        return columns

    def _time(self, message: Message) -> float:
        if self.mapping.time is None:
            return message.nanoseconds * _NANO
        found = _field(message.content, tuple(self.mapping.time.name.split(".")))
        seconds, rest = _field(found, ("sec",)), _field(found, ("nanosec",))
        if isinstance(seconds, int) and isinstance(rest, int):
            return seconds + rest * _NANO
        if isinstance(found, bool) or not isinstance(found, int | float):
            name = printable(self.mapping.time.text)
            raise InputError(f"{self.where}: a message of {printable(message.topic)} has no time in {name}")
        return float(found)

    def _number(self, content: Any, path: tuple[str, ...], source: Source) -> float:
        found = _field(content, path)
        if source.place:
            try:
                found = found[int(source.place)]
            except (TypeError, ValueError, IndexError, KeyError):
                found = None
        if not isinstance(found, bool | int | float | np.number):
            raise InputError(
                f"{self.where}: {printable(source.text)} is no number; a message there has {few(_fields(content))}"
            )
        try:
            return float(found)
        except OverflowError:
            raise InputError(f"{self.where}: {printable(source.text)}: a number too large") from None


def _field(content: Any, path: tuple[str, ...]) -> Any:
    """A field of a field ...; None where there is none."""
    for name in path:
        if isinstance(content, Mapping):
            content = content.get(name)
        elif name in getattr(type(content), "__slots__", ()):  # a decoded message: its own fields, nothing of Python's
            content = getattr(content, name, None)
        else:
            return None
    return content


def _fields(content: Any) -> list[str]:
    return list(content if isinstance(content, Mapping) else getattr(type(content), "__slots__", ()))
