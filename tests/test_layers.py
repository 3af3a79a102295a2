"""Which folder may import which: the contracts in `pyproject.toml`, held by import-linter; and no circles."""

from pathlib import Path

import networkx as nx
import pytest

ROOT = Path(__file__).parents[1]
grimp = pytest.importorskip("grimp", reason="import-linter is missing: pip install ichain_drake[dev]")

# One that does not hold, to see that contracts are really checked.
BROKEN = """
[importlinter]
root_package = ichain_drake
[importlinter:contract:one]
name = Nothing imports errors
type = forbidden
source_modules = ichain_drake.state
forbidden_modules = ichain_drake.errors
"""


def lint(config: Path) -> int:
    from importlinter.cli import lint_imports

    return lint_imports(config_filename=str(config), no_cache=True)


def test_no_import_points_back(capsys: pytest.CaptureFixture) -> None:
    assert lint(ROOT / "pyproject.toml") == 0, capsys.readouterr().out


def test_an_import_that_points_back_would_be_found(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    config = tmp_path / "contracts.ini"
    config.write_text(BROKEN)
    assert lint(config) == 1
    assert "ichain_drake.state is not allowed to import ichain_drake.errors" in capsys.readouterr().out


def test_no_modules_import_each_other_in_a_circle() -> None:
    """Imports for types alone count, too: who reads one of them has to read all."""
    graph = grimp.build_graph("ichain_drake", cache_dir=None)
    edges = [(m, used) for m in graph.modules for used in graph.find_modules_directly_imported_by(m)]
    circles = [sorted(c) for c in nx.strongly_connected_components(nx.DiGraph(edges)) if len(c) > 1]
    assert len(edges) > 1000
    assert not circles
