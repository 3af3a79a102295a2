"""Constants of learning and control: all in settings classes, each with unit and meaning, read somewhere, reported."""

import ast
import re
from dataclasses import fields, replace
from pathlib import Path

import pytest

import ichain_drake
from ichain_drake.cli.main import main
from ichain_drake.control.settings import constants
from ichain_drake.learning.settings import LearningSettings
from ichain_drake.runs.provenance import given_of
from ichain_drake.scenarios.settings_list import attribute_meanings, list_constants, markdown_table
from ichain_drake.settings import check_settings, declared_of
from ichain_drake.systems import load_scenario

PACKAGE = Path(ichain_drake.__file__).parent

# What may be a number in a module: it tunes nothing.
STAYS = {
    "format of files and texts": {
        "learning/library/form.py": {"_EXACT"},
        "learning/library/manifest.py": {"FORMAT"},
        "learning/library/saved_graph.py": {"GRAPH"},
        "learning/portable/graph.py": {"_OPSET", "_IR", "_FLOAT32", "_INT64", "_DOUBLE"},
        "learning/discovery/labels.py": {"_ASKED"},
        "control/planning/format.py": {"_CHANGED"},
    },
    "limit of what is read": {
        "learning/discovery/graph_file.py": {"_MOST_BYTES"},
        "control/tracking/path.py": {"_MIN_POINTS", "_MOST_POINTS"},
    },
    "memory and speed": {
        "learning/alike.py": {"_COPIES"},
        "learning/frozen/kernel.py": {"_ROWS", "_TABLES"},
        "learning/frozen/neighbours.py": {"_ROWS"},
    },
    "mathematics": {
        "learning/noise.py": {"_ROUNDING", "HALF_NORMAL"},
        "learning/discovery/effect_fit.py": {"_MAD"},
        "learning/effects/regression.py": {"_AS_IT_IS"},
        "control/tracking/offset.py": {"_LAGS"},
        "control/execution/sensing.py": {"_SPREAD"},
    },
    "precision, or start, steps and bounds of an optimiser": {
        "learning/checks.py": {"_DIGITS"},
        "learning/effects/screening.py": {"_RIDGE", "_BEYOND"},
        "learning/estimators/evidence.py": {"_SCALE_PRIOR", "BOUNDS", "START"},
        "learning/status/faces.py": {"_PLACES"},
        "control/planning/borders.py": {"_VALUES"},
        "control/planning/risk.py": {"_LEAST"},
        "control/planning/search_node.py": {"_DIGITS"},
        "control/planning/slope.py": {"_CORRECTIONS"},
        "control/tracking/levels.py": {"_HARM", "_SHORTER"},
        "control/tracking/turns.py": {"_STRAIGHT", "_EVERY", "_SLOWER", "_WIDER"},
    },
}


def numbers_of(text: str) -> set[str]:
    """Names of a module that are assigned something with a number in it."""
    found = set()
    for statement in ast.parse(text).body:
        if not isinstance(statement, ast.Assign | ast.AnnAssign) or statement.value is None:
            continue
        inside = (n.value for n in ast.walk(statement.value) if isinstance(n, ast.Constant))
        if any(isinstance(v, int | float) and not isinstance(v, bool) for v in inside):
            targets = statement.targets if isinstance(statement, ast.Assign) else [statement.target]
            found |= {n.id for t in targets for n in ast.walk(t) if isinstance(n, ast.Name)}
    return found


def test_a_number_is_found_whatever_it_is_in():
    text = "A = 1\nB: float = -2.5\nC, D = 1, 2\nE = {'a': (1, 2)}\nF = log(2.0)\nG = 'x1'\nH = True"
    assert numbers_of(text) == set("ABCDEF")
    assert numbers_of("def f(a=1):\n    B = 1\n\nclass C:\n    x = 1\n") == set()


def test_no_constant_that_tunes_is_left_in_a_module():
    stays = {(file, name) for files in STAYS.values() for file, names in files.items() for name in names}
    found = {
        (file.relative_to(PACKAGE).as_posix(), name)
        for part in ("learning", "control")
        for file in (PACKAGE / part).rglob("*.py")
        for name in numbers_of(file.read_text())
    }
    assert found - stays == set(), "put these into a settings class"
    assert stays - found == set(), "these are gone: take them off the list"


@pytest.mark.parametrize("part", constants())
def test_every_constant_has_a_unit_and_a_meaning_and_is_in_its_range(part: str):
    held = constants()[part]
    meanings = attribute_meanings(type(held))
    assert set(meanings) == {f.name for f in fields(held)}
    for item in fields(held):
        assert declared_of(item).unit, item.name
        assert declared_of(item).bounds(), item.name
    check_settings(held)


def test_every_constant_is_read_by_what_it_is_for():
    text = "\n".join(f.read_text() for part in ("learning", "control") for f in (PACKAGE / part).rglob("*.py"))
    read = set(re.findall(r"\b([A-Z]+)\.(\w+)", text))
    for part, held in constants().items():
        for item in fields(held):
            assert (part.upper(), item.name) in read, f"{part}.{item.name} is read by nobody: delete it"


def test_they_are_few():
    """A new one has to replace another; see the architecture page."""
    assert len(list_constants()) <= 119


def test_reports_have_them():
    given = given_of(load_scenario("car_game", (), "ideal"))["constants"]
    assert set(given) == set(constants())
    assert given["learning"]["clear"] == LearningSettings().clear
    assert sum(map(len, given.values())) == len(list_constants())


def test_they_are_listed_by_the_command(capsys):
    assert main(["settings", "--constants"]) == 0
    said = capsys.readouterr().out
    assert "learning.clear=3 [noises]  (above 0)" in said
    assert all(f"{line.key}={line.default[:20]}" in said for line in list_constants())


def test_the_page_says_what_is_in_force():
    """A changed number, unit or range is seen in what is printed of it, by whoever reads the change."""
    assert markdown_table(list_constants()) in (PACKAGE.parent / "docs" / "constants.md").read_text()


def test_the_command_asks_for_a_scenario(capsys):
    assert main(["settings"]) == 2
    assert "name a scenario from `ichain list`, or give --constants" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("part", "name", "least"),
    [("execution", "slack_noises", 0.5), ("execution", "corrected", 1), ("planning", "nodes", 1)],
)
def test_a_setting_may_be_as_small_as_it_makes_sense(part: str, name: str, least: float):
    check_settings(replace(constants()[part], **{name: least}))
