"""Learning and control know graphs, roles, models and goals; never a system's objects or variables, of any system."""

import ast
import re
from collections.abc import Iterator
from functools import cache
from importlib.util import find_spec
from pathlib import Path

import pytest

import ichain_drake
from ichain_drake.systems import SCENARIOS

ROOT = Path(ichain_drake.__file__).parent
SOURCES = sorted(f for package in ("learning", "control", "learned_graph") for f in (ROOT / package).rglob("*.py"))

# Words that systems use too, each with where learning and control have it from. Nothing else may be excused.
CONTRACT = {
    "x": "an axis of a role (`Role.axis`); paths are in the plane of x and y",
    "y": "as x",
    "z": "as x",
    "amount": "kind of a role",
    "level": "kind of a role",
    "change": "kind of a role, and of passive dynamics",
    "angle": "kind of a variable",
    "offset": "of a scaling, y * scale + offset; an event's, in a message about clocks",
    "speed": "a setting of paths, `path.speed`",
    "steps": "control steps, in a message",
    "ahead": "ticks ahead, in a message about a saved prediction",
    "t": "time, in messages",
    "slip": "of a person who flags: the probability that a flag is wrong, in a report",
}
# Systems that an extra is needed for.
EXTRA = {"car_racing"}
# Words of the world's ports that no system declares as a variable.
PORTS = {"hand_command"}
# The same for names in code.
CODE = {
    "hand": "the root of a chain, whose commands it sends (paper, appendix A)",
    "switch": "an activation or a deactivation: an interaction switches",
}


@cache
def system_words() -> tuple[frozenset[str], frozenset[str]]:
    """Of every system: names and types of its objects with its own name; all of these, and names of variables."""
    objects, variables = set(), set()
    for name, kind in SCENARIOS.items():
        if name in EXTRA and find_spec("Box2D") is None:
            continue
        graph = kind((), "ideal").graph
        objects |= {name, *graph.objects, *(s.type for s in graph.objects.values())}
        variables |= {v.name for s in graph.objects.values() for v in s.variables}
    return frozenset(objects), frozenset(objects | variables)


def strings(file: Path) -> Iterator[tuple[int, str]]:
    """String literals that are not docstrings, with their lines."""
    tree = ast.parse(file.read_text())
    docs = {id(n.value) for n in ast.walk(tree) if isinstance(n, ast.Expr)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in docs:
            yield node.lineno, node.value


def identifiers(file: Path) -> Iterator[tuple[int, str]]:
    """What is defined or assigned: functions, classes, arguments, variables and attributes, with their lines."""
    for node in ast.walk(ast.parse(file.read_text())):
        match node:
            case ast.FunctionDef(name=name) | ast.ClassDef(name=name):
                yield node.lineno, name
            case ast.arg(arg=name):
                yield node.lineno, name
            case ast.Name(id=name, ctx=ast.Store()) | ast.Attribute(attr=name, ctx=ast.Store()):
                yield node.lineno, name


def words(text: str) -> set[str]:
    """Words of a message; "can't" is one."""
    return set(re.findall(r"[\w']+", text.lower()))


def parts(name: str) -> set[str]:
    """Words of a name: `a_cup` and `ACup` have two."""
    return set(re.sub(r"([a-z])([A-Z])", r"\1_\2", name).lower().split("_"))


@pytest.mark.parametrize("file", SOURCES, ids=lambda f: str(f.relative_to(ROOT)))
def test_no_literal_names_an_object_or_variable_of_a_system(file: Path) -> None:
    _, known = system_words()
    found = {text for _, text in strings(file) if known & words(text) - CONTRACT.keys() and text not in PORTS}
    assert not found


@pytest.mark.parametrize("file", SOURCES, ids=lambda f: str(f.relative_to(ROOT)))
def test_nothing_is_called_after_an_object_of_a_system(file: Path) -> None:
    """Variables have everyday names (`level`, `phase`) which code may use of its own; objects' names are a system's."""
    known, _ = system_words()
    assert not [(line, name) for line, name in identifiers(file) if known & parts(name) - CODE.keys()]


def test_the_search_knows_every_system_and_would_find_its_words() -> None:
    objects, known = system_words()
    assert {"hand", "joystick", "car", "kettle", "microwave", "bottle", "door", "ship"} <= objects
    assert objects >= SCENARIOS.keys() - EXTRA
    assert {"x_axis", "heading", "yaw_rate", "temperature", "rudder", "grip"} <= known
    for name in ("car_game", "kettle", "microwave", "water_dispenser"):
        file = ROOT / "systems" / name / "scenario.py"
        assert any(known & words(text) - CONTRACT.keys() for _, text in strings(file)), name
        assert any(objects & parts(text) for _, text in identifiers(file)), name
    assert words("a Cup can't fly") == {"a", "cup", "can't", "fly"}
    assert parts("_RoadCar_now") == {"", "road", "car", "now"}
    assert {*CONTRACT} <= known, "an excuse that nothing needs"
