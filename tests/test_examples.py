"""Every example is short, uses the public interface alone, and does what it says."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

import ichain_drake

EXAMPLES = Path(__file__).parent.parent / "examples"
FILES = sorted(EXAMPLES.glob("*.py"))


def run(name: str, *arguments: str, folder: Path) -> str:
    done = subprocess.run(
        [sys.executable, str(EXAMPLES / name), *arguments], cwd=folder, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize("file", FILES, ids=lambda f: f.name)
def test_an_example_is_short_and_uses_public_names_only(file: Path) -> None:
    text = file.read_text()
    assert len(text.splitlines()) <= 30
    tree = ast.parse(text)
    assert ast.get_docstring(tree)
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            assert not (node.module or "").startswith("ichain_drake."), f"{node.module} is not public"
            if node.module == "ichain_drake":
                assert {a.name for a in node.names} <= set(ichain_drake.__all__)
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "ic":
            assert node.attr in ichain_drake.__all__


def test_simulate_world_holds_the_stick_and_drives(tmp_path: Path) -> None:
    lines = run("simulate_world.py", folder=tmp_path).splitlines()
    assert len(lines) == 5
    numbers = [[float(n) for n in re.findall(r"-?\d+\.?\d*", line)] for line in lines]
    start, end = numbers[0], numbers[-1]
    assert start[3:5] == pytest.approx([400, 300], abs=5)
    assert all(row[1] > 0.4 and row[2] > 0.4 for row in numbers[1:]), "the arm lost the stick"
    assert abs(end[3] - start[3]) + abs(end[4] - start[4]) > 50


def test_learn_and_drive_completes_its_path(tmp_path: Path) -> None:
    text = run("learn_and_drive.py", "120", folder=tmp_path)
    rows = {name: int(n) for name, n in re.findall(r"^(\w+): (\d+) rows", text, re.MULTILINE)}
    assert set(rows) == {"play", "drive"}
    assert min(rows.values()) > 120
    found = re.search(r"completed (\w+), mean error (\d+\.\d+) px", text)
    assert found is not None
    assert found[1] == "True"
    assert float(found[2]) < 2.0


def test_learned_graph_predicts_the_same_with_and_without_gradients(tmp_path: Path) -> None:
    plain, autodiff, gradient = (
        [float(n) for n in line.split("[", 1)[1].strip(" ]").replace("rad/m]: [", "").split()]
        for line in run("learned_graph.py", folder=tmp_path).splitlines()
    )
    assert plain == autodiff
    assert 10 < plain[0] - 400 < 20, "45 px/s for a third of a second"
    assert gradient[0] > 1, "the hand steers along x"


def test_gymnasium_game_replays(tmp_path: Path) -> None:
    pytest.importorskip("gymnasium", reason="Gymnasium is missing: pip install 'ichain_drake[games]'")
    first, second = run("gymnasium_game.py", folder=tmp_path).splitlines()
    assert first == second
    cos, sin, rate = (float(n) for n in re.findall(r"-?\d+\.\d+", first))
    assert cos**2 + sin**2 == pytest.approx(1.0, abs=1e-3)
    assert rate != 0.0


def test_own_object_moves_its_load(tmp_path: Path) -> None:
    found = re.search(r"(\d\.\d+) m", run("own_object.py", folder=tmp_path))
    assert found is not None
    assert 0.5 < float(found[1]) < 1.5


def test_behaviour_cloning_follows_the_path_and_standing_still_does_not(tmp_path: Path) -> None:
    pytest.importorskip("gymnasium", reason="Gymnasium is missing: pip install 'ichain_drake[games]'")
    copy, rest = run("behaviour_cloning.py", folder=tmp_path).splitlines()
    assert copy.endswith("path done: True")
    assert rest.endswith("path done: False")
