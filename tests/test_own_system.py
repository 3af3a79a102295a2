"""The page "add your own system" and its example: somebody's own objects and scenario, by the public interface."""

import ast
import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

import ichain_drake as ic

ROOT = Path(__file__).parent.parent
EXAMPLE = ROOT / "examples" / "own_system"
FILES = ("tap.py", "basin.py", "bath.py")
PAGE = (ROOT / "docs" / "add_your_own_system.md").read_text()
BLOCKS = re.findall(r"^```python\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Somebody's own folder, with what the page shows."""
    folder = tmp_path_factory.mktemp("own")
    for name, block in zip((*FILES, "use.py"), BLOCKS, strict=True):
        (folder / name).write_text(block)
    return folder


@pytest.fixture(scope="module")
def printed(folder: Path) -> str:
    done = subprocess.run([sys.executable, "use.py"], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_page_shows_the_example_whole() -> None:
    for name, block in zip(FILES, BLOCKS, strict=False):
        assert f"`{name}`\n\n```python\n{block}" in PAGE
        assert (EXAMPLE / name).read_text() == block


@pytest.mark.parametrize("name", FILES)
def test_the_example_uses_public_names_only(name: str) -> None:
    for node in ast.walk(ast.parse((EXAMPLE / name).read_text())):
        if isinstance(node, ast.ImportFrom):
            assert not (node.module or "").startswith("ichain_drake")
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "ic":
            assert node.attr in ic.__all__


def test_the_page_prints_what_it_says(printed: str, folder: Path) -> None:
    assert printed.count("goal reached") == 4, printed
    assert "\n".join(f"    {line}" for line in printed.splitlines()) in PAGE
    assert "ichain-hud" in (folder / "playback.html").read_text(encoding="utf-8")


@pytest.mark.usefixtures("printed")  # which saves the library
def test_the_command_takes_the_file_and_what_was_learned(folder: Path) -> None:
    options = ["--physics", "ideal", "--seed", "5", "--library", "library", "-o", "out", "--report", "-"]
    command = [sys.executable, "-m", "ichain_drake", "run", "bath.py", *options]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    report = json.loads(done.stdout)
    assert report["scenario"] == "bath"
    assert report["goal_reached"]
    assert report["models"]["hand->tap"]["source"] == "library"
    assert report["given"]["graph"]["interactions"] == ["hand->tap", "tap->basin"]
    assert (folder / "out" / "playback.html").is_file()


@pytest.fixture
def own(monkeypatch: pytest.MonkeyPatch) -> Path:
    """The example's file; what is imported from it is forgotten again."""
    monkeypatch.setattr(sys, "path", list(sys.path))
    for name in FILES:
        monkeypatch.delitem(sys.modules, name.removesuffix(".py"), raising=False)
    return EXAMPLE / "bath.py"


def test_its_objects_keep_the_contract(own: Path) -> None:
    scenario = ic.load_scenario(str(own), physics="ideal")
    world = ic.build_world(scenario)
    for name in ("tap", "basin"):
        ic.check_object(world.system(name))


@pytest.mark.parametrize("seed", [1, 2])
def test_other_demonstrations_reach_the_goal_as_well(own: Path, seed: int) -> None:
    scenario = ic.load_scenario(str(own), physics="ideal", seed=seed)
    model = ic.learn(scenario, scenario.record_demonstrations())
    for number in range(3):
        run = ic.run(scenario, known=model, number=number)
        assert run.goal_reached, run.reason


def test_an_arm_does_it_and_contact_says_what_is_missing(own: Path) -> None:
    scenario = ic.load_scenario(str(own), ["noise.scale=0"], physics="arm")
    piece = next(iter(scenario.record_demonstrations()))
    assert piece.table["hand->tap"].max() == 1.0
    with pytest.raises(ic.InputError, match="bath: no object has a body that a hand could touch; choose ideal or arm"):
        next(iter(ic.load_scenario(str(own)).record_demonstrations()))
