"""The settings of a scenario as a list: key, unit, range, default and meaning, for the command line and the docs."""

from __future__ import annotations

import inspect
import re
import types
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, is_dataclass
from typing import Any, Union, get_args, get_origin, get_type_hints

from ichain_drake.control.settings import constants
from ichain_drake.scenarios.base import Scenario
from ichain_drake.scenarios.config import load_config
from ichain_drake.settings import Declared, declared_of

_ATTRIBUTE = re.compile(r"^ {4}(\w[\w, ]*): (.*)$")


@dataclass(frozen=True)
class SettingLine:
    """One setting.

    Attributes:
        key: as for `--set`; `[]` stands for the number of an item of a list.
        unit: of its numbers.
        allowed: its range, size or choices, in words.
        default: the scenario's own, as YAML would have it.
        meaning: from the docstring of the class that has it.
    """

    key: str
    unit: str
    allowed: str
    default: str
    meaning: str


def list_settings(kind: type[Scenario]) -> list[SettingLine]:
    """All settings of a scenario class, with the defaults of its file.

    Raises:
        InputError: if its file can't be read.
    """
    config = load_config(kind.config_class, kind.config_path())
    return list(_lines(type(config), config, "", getattr(kind, "unit", "unit")))


def list_constants() -> list[SettingLine]:
    """The constants of learning and control, the same for every system: `part.name` each, as reports have them."""
    return [line for part, held in constants().items() for line in _lines(type(held), held, f"{part}.", "unit")]


def _lines(kind: type[Any], config: Any, where: str, unit: str) -> Iterator[SettingLine]:
    meanings, hints = attribute_meanings(kind), get_type_hints(kind)
    for item in fields(kind):
        key = f"{where}{item.name}"
        value = getattr(config, item.name, None)
        inner, many = _section(hints[item.name])
        if inner is not None:
            yield from _lines(inner, None if many else value, f"{key}[]." if many else f"{key}.", unit)
            continue
        declared = declared_of(item)
        yield SettingLine(
            key, declared.unit.format(unit=unit), _allowed(declared), _text(value), meanings.get(item.name, "")
        )


def _section(hint: Any) -> tuple[type[Any] | None, bool]:
    """The dataclass of a section, and whether there is a list of them; None for a plain value."""
    if get_origin(hint) in (Union, types.UnionType):
        hint = next(h for h in get_args(hint) if h is not type(None))
    many = get_origin(hint) is list
    inner = get_args(hint)[0] if many else hint
    ours = isinstance(inner, type) and is_dataclass(inner) and not inner.__module__.startswith("pydrake.")
    return (inner if ours else None), many


def _allowed(declared: Declared) -> str:
    parts = [f"{declared.size} numbers" if declared.size else "", declared.bounds(), ", ".join(declared.choices)]
    return ", ".join(p for p in parts if p)


def _text(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:g}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(_text(v) for v in value)}]"
    if isinstance(value, dict):
        return f"{{{', '.join(f'{k}: {_text(v)}' for k, v in value.items())}}}"
    return "" if value is None else str(value)


def attribute_meanings(kind: type[Any]) -> dict[str, str]:
    """What the docstrings of a class and its bases say of its attributes, by name."""
    found: dict[str, str] = {}
    for base in reversed(kind.__mro__):
        found |= _attributes(inspect.cleandoc(vars(base).get("__doc__") or "").splitlines())
    return found


def _attributes(lines: Sequence[str]) -> dict[str, str]:
    found: dict[str, str] = {}
    names: list[str] = []
    inside = False
    for line in lines:
        if not line.startswith(" "):
            inside = line == "Attributes:" or (inside and not line)
            names = []
        elif inside and (entry := _ATTRIBUTE.match(line)):
            names = [n.strip() for n in entry[1].split(",")]
            found |= dict.fromkeys(names, entry[2])
        elif inside:
            found |= {name: f"{found[name]} {line.strip()}" for name in names}
    # "see `GraphConfig`" says nothing that the base's own docstring does not say better.
    return {name: text for name, text in found.items() if not re.match(r"see (`\w+`|there)(\W|$)", text)}


def markdown_table(lines: Sequence[SettingLine]) -> str:
    """The list as a table in Markdown."""
    rows = [("key", "unit", "allowed", "default", "meaning"), ("---",) * 5]
    for line in lines:
        default = f"`{line.default}`" if line.default else ""
        rows.append((f"`{line.key}`", line.unit, line.allowed, default, line.meaning))
    return "\n".join(f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in row)} |" for row in rows)
