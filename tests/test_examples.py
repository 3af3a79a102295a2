"""Every example is short, uses the public interface alone, and does what it says."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
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
    assert len(text.splitlines()) <= 32
    tree = ast.parse(text)
    assert ast.get_docstring(tree)
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):  # objects that come with the library have modules of their own
            home = f"{node.module}."
            assert not home.startswith("ichain_drake.") or home.startswith("ichain_drake.objects."), home
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "ic":
            assert node.attr in ichain_drake.__all__


@pytest.mark.parametrize("name", ["follow_a_path.py", "reach_a_goal.py"])
def test_a_simulator_of_ones_own_takes_fifteen_lines(name: str) -> None:
    text = (EXAMPLES / name).read_text()
    first = ast.parse(text).body[0].end_lineno
    assert len([line for line in text.splitlines()[first:] if line.strip()]) <= 15


def test_a_path_is_followed_in_a_simulator_of_ones_own(tmp_path: Path) -> None:
    text = run("follow_a_path.py", folder=tmp_path)
    found = re.search(r"(\d+)% of the path are done, the car is at \((\d+), (\d+)\) px", text)
    assert found is not None
    assert int(found[1]) >= 95
    assert np.hypot(int(found[2]) - 400, int(found[3]) - 300) < 15, "an eight ends where it starts"


def test_a_goal_is_reached_in_a_simulator_of_ones_own(tmp_path: Path) -> None:
    cup = ast.literal_eval(run("reach_a_goal.py", folder=tmp_path))
    assert cup["water"] >= 0.55
    assert cup["temperature"] >= 0.85


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
