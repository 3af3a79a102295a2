"""The grammar of goal expressions.

It needs the graph alone, so that a typo is found before anything is recorded or learned.

goal       = clause, {"and", clause}
clause     = comparison | ["not"], edge | "keep", variable, "within", number
comparison = variable, sign, value | value, sign, variable | value, sign, variable, sign, value
sign       = ">=" | ">" | "<=" | "<" | "==" | "="
value      = number | "start"
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction, InteractionGraph

START = "start"
"""In place of a number: the value that the variable has when the plan is made."""

FORM = (
    "write object.variable >= value, <= value, > value, < value, == value, low <= object.variable <= high, "
    "keep object.variable within value, parent->child, or not parent->child; several joined by and"
)

_TOKEN = re.compile(r"\s*(?P<token>(?P<edge>[^\s<>=]+?\s*->\s*[^\s<>=]+)|(?P<sign><=|>=|==|=|<|>)|(?P<word>[^\s<>=]+))")
_UP, _DOWN, _SAME = ("<=", "<"), (">=", ">"), ("==", "=")
_MIRRORED = {"<=": ">=", "<": ">", ">=": "<=", ">": "<", "==": "==", "=": "="}


@dataclass(frozen=True)
class Bound:
    """One side of a wanted range.

    Attributes:
        object, variable: which.
        sign: `>=`, `>`, `<=`, `<` or `==`, with the variable on the left; `within` for what is to be kept.
        value: the number; None for the value at the start.
    """

    object: str
    variable: str
    sign: str
    value: float | None


@dataclass(frozen=True)
class Clauses:
    """What an expression says.

    Attributes:
        bounds: in order.
        active, inactive: interactions that must, or must not, be active in the end.
    """

    bounds: tuple[Bound, ...] = ()
    active: tuple[Interaction, ...] = ()
    inactive: tuple[Interaction, ...] = ()


@dataclass(frozen=True)
class _Token:
    kind: str
    text: str
    at: int


def read_goal_text(text: str, graph: InteractionGraph) -> Clauses:
    """Read one expression.

    Args:
        text: see the module's description.
        graph: has the names.

    Raises:
        InputError: on another form, an unknown name, or a value that is no finite number; says what was expected
            where.
    """
    reader = _Reader(text, graph)
    bounds: list[Bound] = []
    edges: tuple[list[Interaction], list[Interaction]] = ([], [])
    while True:
        reader.clause(bounds, *edges)
        if reader.peek() is None:
            return Clauses(tuple(bounds), tuple(edges[0]), tuple(edges[1]))
        reader.expect("and", "'and' or the end")


def check_goal_text(expressions: Sequence[str], graph: InteractionGraph) -> None:
    """Refuse expressions that can't be read, before anything is recorded.

    Raises:
        InputError: as `read_goal_text`; also on no expression at all.
    """
    if not any(text.strip() for text in expressions):
        raise InputError(f"no goal is given; {FORM}")
    for text in expressions:
        read_goal_text(text, graph)


class _Reader:
    """Goes through the tokens of one expression."""

    def __init__(self, text: str, graph: InteractionGraph) -> None:
        self._text, self._graph = text, graph
        self._tokens = [_Token(_kind(m), m["token"], m.start("token")) for m in _TOKEN.finditer(text)]
        self._next = 0

    def peek(self) -> _Token | None:
        return self._tokens[self._next] if self._next < len(self._tokens) else None

    def _take(self) -> _Token | None:
        token = self.peek()
        self._next += token is not None
        return token

    def _refuse(self, token: _Token | None, wanted: str) -> InputError:
        found = f"character {token.at + 1}, {token.text!r}" if token else "the end"
        return InputError(f"goal {self._text!r}: at {found}, {wanted} is expected; {FORM}")

    def expect(self, word: str, wanted: str) -> None:
        token = self._take()
        if token is None or token.text != word:
            raise self._refuse(token, wanted)

    def clause(self, bounds: list[Bound], active: list[Interaction], inactive: list[Interaction]) -> None:
        token = self.peek()
        if token is not None and token.text == "not":
            self._take()
            inactive.append(self._edge(self._take()))
        elif token is not None and token.kind == "edge":
            active.append(self._edge(self._take()))
        elif token is not None and token.text == "keep":
            self._take()
            name = self._name(self._take(), "object.variable")
            self.expect("within", "'within'")
            bounds.append(Bound(*name, "within", self._number(self._take())))
        else:
            bounds += self._comparison()

    def _comparison(self) -> list[Bound]:
        first = self._take()
        if first is not None and self._is_name(first):
            name = self._name(first, "object.variable")
            return [Bound(*name, self._sign("a sign such as >="), self._value(self._take()))]
        low = self._value(first, "object.variable, a number or an interaction")
        sign = self._sign("a sign such as <=")
        name = self._name(self._take(), "object.variable")
        bounds = [Bound(*name, _MIRRORED[sign], low)]
        after = self.peek()
        if after is not None and after.kind == "sign":
            same = next(group for group in (_UP, _DOWN, _SAME) if sign in group)
            if after.text not in same or same is _SAME:
                raise self._refuse(after, f"{' or '.join(same)}, as before," if same is not _SAME else "the end")
            bounds.append(Bound(*name, self._sign(""), self._value(self._take())))
        return bounds

    def _sign(self, wanted: str) -> str:
        token = self._take()
        if token is None or token.kind != "sign":
            raise self._refuse(token, wanted)
        return token.text if token.text != "=" else "=="

    def _is_name(self, token: _Token) -> bool:
        """Whether a word is meant as object.variable: it is no number, and has a dot."""
        return token.kind == "word" and _number(token.text) is None and "." in token.text

    def _name(self, token: _Token | None, wanted: str) -> tuple[str, str]:
        if token is None or not self._is_name(token):
            raise self._refuse(token, wanted)
        obj, _, variable = token.text.rpartition(".")
        objects = self._graph.objects
        where = f"goal {self._text!r}: at character {token.at + 1}"
        if obj not in objects:
            raise InputError(f"{where}, there is no object {obj!r}; objects are {', '.join(objects)}")
        names = objects[obj].observable.names
        if variable not in names:
            raise InputError(f"{where}, {obj} has no variable {variable!r}; it has {', '.join(names)}")
        return obj, variable

    def _value(self, token: _Token | None, wanted: str = "a number or 'start'") -> float | None:
        if token is not None and token.text == START:
            return None
        return self._number(token, wanted)

    def _number(self, token: _Token | None, wanted: str = "a number") -> float:
        value = _number(token.text) if token is not None and token.kind == "word" else None
        if value is None:
            raise self._refuse(token, wanted)
        if not math.isfinite(value):
            assert token is not None
            raise InputError(f"goal {self._text!r}: at character {token.at + 1}, {token.text!r} is not a finite number")
        return value

    def _edge(self, token: _Token | None) -> Interaction:
        if token is None or token.kind != "edge":
            raise self._refuse(token, "an interaction as parent->child")
        edge = Interaction.parse(token.text)
        if edge not in self._graph.interactions:
            known = ", ".join(e.name for e in self._graph.interactions)
            raise InputError(
                f"goal {self._text!r}: at character {token.at + 1}, there is no interaction {edge.name}; the graph has "
                f"{known}"
            )
        return edge


def _kind(match: re.Match[str]) -> str:
    return next(name for name in ("edge", "sign", "word") if match[name])


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None
