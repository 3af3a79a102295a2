"""Learning and control know graphs, roles, models and goals; never a scenario's objects or variables."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

import ichain_drake
from ichain_drake.graph import InteractionGraph
from ichain_drake.objects import Car, Joystick
from ichain_drake.robot import HAND
from ichain_drake.systems.car_game.scenario import CarGame

ROOT = Path(ichain_drake.__file__).parent
SOURCES = sorted(f for package in ("learning", "control", "learned_graph") for f in (ROOT / package).rglob("*.py"))

# Words of the contracts: axes of roles, the world's port for commands, what the path settings are called.
CONTRACT = {"x", "y", "z", "hand_command", "speed"}
EXTRA = {"steering", "throttle", "stick", "knob", "gas", "brake", "cup", "kettle", "button", "valve", "wheel"}


def scenario_words() -> set[str]:
    graphs: list[InteractionGraph] = [CarGame(physics="ideal").graph]
    spaces = [Car.state_space, Joystick.state_space, HAND, *(s for g in graphs for s in g.objects.values())]
    words = {v.name for s in spaces for v in s.variables} | {s.type for s in spaces}
    words |= {n for g in graphs for n in g.objects}
    return (words | EXTRA | {CarGame.name}) - CONTRACT


def strings(file: Path) -> Iterator[tuple[int, str]]:
    """String literals that are not docstrings, with their lines."""
    tree = ast.parse(file.read_text())
    docs = {id(n.value) for n in ast.walk(tree) if isinstance(n, ast.Expr)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in docs:
            yield node.lineno, node.value


@pytest.mark.parametrize("file", SOURCES, ids=lambda f: str(f.relative_to(ROOT)))
def test_no_literal_names_an_object_or_variable_of_a_scenario(file: Path) -> None:
    words = scenario_words()
    found = [(line, text) for line, text in strings(file) if words & set(re.findall(r"\w+", text.lower()))]
    assert not found


def test_the_search_would_find_them() -> None:
    words = scenario_words()
    assert {"hand", "joystick", "car", "x_axis", "heading", "yaw_rate"} <= words
    texts = " ".join(text for _, text in strings(ROOT / "systems" / "car_game" / "scenario.py"))
    assert words & set(re.findall(r"\w+", texts))


@pytest.mark.parametrize("file", SOURCES, ids=lambda f: str(f.relative_to(ROOT)))
def test_nothing_points_back_in_the_layers(file: Path) -> None:
    """Learning imports no Drake system; neither learning nor control imports a world, an object or a scenario."""
    imported = {
        (name.name if isinstance(node, ast.Import) else node.module or "")
        for node in ast.walk(ast.parse(file.read_text()))
        if isinstance(node, ast.Import | ast.ImportFrom)
        for name in node.names
    }
    package = file.relative_to(ROOT).parts[0]
    forbidden = ["objects", "robot", "world", "simulation", "scenarios", "systems", "runs", "cli", "visualization"]
    forbidden += {"learning": ["learned_graph", "control"], "learned_graph": ["control"], "control": []}[package]
    assert not [m for m in imported if m.startswith(tuple(f"ichain_drake.{f}" for f in forbidden))]
    if package == "learning":
        assert not [m for m in imported if m.startswith("pydrake.systems")]
