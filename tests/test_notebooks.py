"""Notebooks are kept without outputs, use public names alone, and lead on to one another. `.ci/run` executes them."""

import ast
import json
import re
from pathlib import Path

import pytest

import ichain_drake
import ichain_drake.visualization

ROOT = Path(__file__).parent.parent
FILES = sorted((ROOT / "notebooks").glob("*.ipynb"))


def cells(file: Path, kind: str) -> list[str]:
    return ["".join(c["source"]) for c in json.loads(file.read_text())["cells"] if c["cell_type"] == kind]


def code(file: Path) -> ast.Module:
    return ast.parse("\n".join(cells(file, "code")))


def test_there_are_five_in_order_and_the_readme_links_them() -> None:
    assert [f.name[0] for f in FILES] == ["1", "2", "3", "4", "5"]
    readme = (ROOT / "README.md").read_text()
    for file in FILES:
        assert f"(notebooks/{file.name})" in readme
        assert cells(file, "markdown")[0].startswith(f"# {file.name[0]}. ")


@pytest.mark.parametrize("file", FILES, ids=lambda f: f.stem)
def test_a_notebook_is_stripped_of_outputs(file: Path) -> None:
    notebook = json.loads(file.read_text())
    assert notebook["nbformat"] == 4
    assert set(notebook["metadata"]) == {"kernelspec", "language_info"}
    assert notebook["metadata"]["kernelspec"]["name"] == "python3"
    for cell in notebook["cells"]:
        assert cell["metadata"] == {}
        if cell["cell_type"] == "code":
            assert cell["outputs"] == []
            assert cell["execution_count"] is None


@pytest.mark.parametrize("file", FILES, ids=lambda f: f.stem)
def test_a_notebook_uses_public_names_only(file: Path) -> None:
    used = set()
    for node in ast.walk(code(file)):
        if isinstance(node, ast.Import):
            assert not any(a.name.startswith("ichain_drake.") for a in node.names)
            assert not {a.name for a in node.names} & {"sys", "importlib"}, "path hacks"
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("ichain_drake"):
            assert node.module == "ichain_drake"
        if isinstance(node, ast.Attribute):
            assert not node.attr.startswith("_"), f"{node.attr} is private"
            if isinstance(node.value, ast.Name) and node.value.id == "ic":
                used.add(node.attr)
    assert used
    assert used <= set(ichain_drake.__all__)


@pytest.mark.parametrize("file", FILES, ids=lambda f: f.stem)
def test_the_links_of_a_notebook_lead_somewhere(file: Path) -> None:
    links = [t for text in cells(file, "markdown") for t in re.findall(r"\]\(([^)#]+)", text)]
    for target in links:
        assert re.match(r"\w+:", target) or (file.parent / target).exists(), target


@pytest.mark.parametrize("file", FILES[:4], ids=lambda f: f.stem)
def test_a_tutorial_ends_with_something_to_watch_and_to_look_at(file: Path) -> None:
    text = "\n".join(cells(file, "code"))
    assert re.search(r"^ic\.show\(", text, re.MULTILINE)
    assert "plt.subplots" in text


def test_your_own_graph_is_described_in_twenty_lines() -> None:
    (cell,) = [c for c in cells(FILES[3], "code") if "class Slider" in c]
    lines = [line for line in cell.splitlines() if line.strip() and not line.strip().startswith('"""')]
    assert len(lines) <= 20
