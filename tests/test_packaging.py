"""The wheel works outside the checkout; dependencies are declared and used; the public interface is documented."""

import ast
import dataclasses
import importlib.util
import inspect
import json
import os
import re
import subprocess
import sys
import tomllib
import zipfile
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from types import FunctionType

import pytest

import ichain_drake

ROOT = Path(__file__).parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())
PACKAGE = ROOT / "ichain_drake"

# Where a distribution and what one imports from it differ in name.
DISTRIBUTIONS = {
    "pydrake": "drake",
    "sklearn": "scikit-learn",
    "yaml": "pyyaml",
    "PIL": "pillow",
    "umsgpack": "meshcat",
    "mcap_ros2": "mcap-ros2-support",
    "rerun": "rerun-sdk",
}


# The wheel.


def run(command: list[str], folder: Path, **environment: str) -> str:
    done = subprocess.run(
        command, cwd=folder, capture_output=True, text=True, check=False, env={**os.environ, **environment}
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    if importlib.util.find_spec("hatchling") is None:
        pytest.skip("hatchling is missing: pip install -e '.[dev]'")
    folder = tmp_path_factory.mktemp("wheel")
    pip = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation", "-w", str(folder)]
    run([*pip, str(ROOT)], folder)
    (file,) = folder.glob("*.whl")
    return file


@pytest.fixture(scope="module")
def installed(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the wheel's contents and nothing else of the project."""
    folder = tmp_path_factory.mktemp("installed")
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--no-index", "--target", str(folder)]
    run([*pip, str(wheel)], folder)
    return folder


def ichain(installed: Path, folder: Path, *arguments: str) -> str:
    return run([sys.executable, "-m", "ichain_drake", *arguments], folder, PYTHONPATH=str(installed))


def test_the_wheel_holds_package_and_models_and_nothing_else(wheel: Path) -> None:
    names = set(zipfile.ZipFile(wheel).namelist())
    sources = [f for f in PACKAGE.rglob("*") if f.suffix in {".py", ".js", ".css"}]
    code = {f"ichain_drake/{f.relative_to(PACKAGE)}" for f in sources}
    models = {f"ichain_drake/{f.relative_to(ROOT)}" for f in (ROOT / "models").rglob("*") if f.is_file()}
    assert "ichain_drake/visualization/page/playback.js" in code
    assert "ichain_drake/models/scenarios/car_game.yaml" in models
    assert code | models <= names
    version = PROJECT["project"]["version"]
    assert {n.split("/")[0] for n in names} == {"ichain_drake", f"ichain_drake-{version}.dist-info"}
    assert not [n for n in names if "__pycache__" in n]
    assert any(n.endswith("licenses/LICENSE") for n in names)


def test_the_installed_wheel_lists_its_scenarios_outside_the_checkout(installed: Path, tmp_path: Path) -> None:
    where = run(
        [sys.executable, "-c", "import ichain_drake; print(ichain_drake.__file__)"], tmp_path, PYTHONPATH=str(installed)
    )
    assert Path(where.strip()).is_relative_to(installed)
    assert "car_game" in ichain(installed, tmp_path, "list")
    assert (installed / "bin" / "ichain").is_file()


def test_the_installed_wheel_learns_drives_and_writes_a_playback(installed: Path, tmp_path: Path) -> None:
    options = ["--physics", "ideal", "--paths", "eight", "--set", "learning.samples=120", "-o", "out"]
    report = json.loads(ichain(installed, tmp_path, "run", "car_game", *options, "--report", "-"))
    assert report["goal_reached"]
    page = (tmp_path / "out" / "playback.html").read_text(encoding="utf-8")
    assert "ichain-hud" in page


# Dependencies.


def declared() -> dict[str, str]:
    """Requirement by distribution name, extras too."""
    extras = PROJECT["project"]["optional-dependencies"].values()
    every = [*PROJECT["project"]["dependencies"], *(r for group in extras for r in group)]
    return {re.split(r"[<>=!~\[; ]", r, maxsplit=1)[0].lower(): r for r in every}


def test_every_dependency_has_a_reason_and_a_lower_bound() -> None:
    lines = (ROOT / "pyproject.toml").read_text().splitlines()
    for requirement in declared().values():
        assert ">=" in requirement, requirement
        (line,) = [text for text in lines if text.startswith(f'    "{requirement}"')]
        assert re.search(r'",\s+# \w', line), f"{requirement} has no reason"


@cache
def parsed(file: Path) -> ast.Module:
    return ast.parse(file.read_text())


def imported(folder: Path) -> set[str]:
    """Top-level modules that a folder's code imports, the standard library and the project left out."""
    found: set[str] = set()
    for file in folder.rglob("*.py"):
        for node in ast.walk(parsed(file)):
            if isinstance(node, ast.Import):
                found |= {a.name.split(".")[0] for a in node.names}
            elif isinstance(node, ast.ImportFrom) and node.level == 0:
                found.add((node.module or "").split(".")[0])
    return found - set(sys.stdlib_module_names) - {"ichain_drake"}


def required_by_name() -> set[str]:
    """Distributions whose modules are imported where they are used, by `require("module", ...)`."""
    code = "".join(f.read_text() for f in PACKAGE.rglob("*.py"))
    names = re.findall(r'\b(?:require|import_module)\("(\w+)', code)
    return {DISTRIBUTIONS.get(n, n) for n in names}


def test_dependencies_are_what_the_package_imports() -> None:
    used = {DISTRIBUTIONS.get(m, m) for m in imported(PACKAGE)}
    extras = PROJECT["project"]["optional-dependencies"]
    core, *optional = (
        {re.split(r"[<>=!~\[; ]", r, maxsplit=1)[0].lower() for r in group}
        for group in (
            PROJECT["project"]["dependencies"],
            extras["games"],
            extras["logs"],
            extras["minari"],
            extras["onnx"],
            extras["rerun"],
        )
    )
    assert used | required_by_name() == core.union(*optional)


def test_no_wildcard_and_no_pydrake_all() -> None:
    wanted = re.compile(r"^\s*(from \S+ import \*|(from|import) pydrake\.all\b)", re.MULTILINE)
    assert wanted.search("x = 1\n    from pydrake.all import Simulator\n") and wanted.search("from a.b import *")
    for folder in (PACKAGE, ROOT / "tests", ROOT / "examples", ROOT / "docs"):
        for file in folder.rglob("*.py"):
            assert not wanted.search(file.read_text()), file


# The public interface.


def test_importing_the_package_loads_nothing_heavy(tmp_path: Path) -> None:
    code = "import sys, ichain_drake; ichain_drake.TICK; print(*sys.modules)"
    loaded = run([sys.executable, "-c", code], tmp_path, PYTHONPATH=str(ROOT)).split()
    assert "ichain_drake" in loaded
    heavy = ("pydrake", "sklearn", "pandas", "matplotlib", "scipy", "numpy")
    assert [m for m in loaded if m.split(".")[0] in heavy] == []


def test_what_pictures_alone_need_is_imported_where_they_are_drawn() -> None:
    """Matplotlib takes a sixth of the time in which a command begins."""
    for file in PACKAGE.rglob("*.py"):
        for node in parsed(file).body:
            names = (
                [a.name for a in node.names] if isinstance(node, ast.Import) else [getattr(node, "module", "") or ""]
            )
            assert not [n for n in names if n.startswith(("matplotlib", "pydrake.visualization"))], file


def test_every_public_name_resolves_and_no_other_does() -> None:
    for name in ichain_drake.__all__:
        assert getattr(ichain_drake, name) is not None
        assert name in dir(ichain_drake)
    with pytest.raises(AttributeError, match="no attribute 'Jostick'"):
        _ = ichain_drake.Jostick


def test_type_checkers_see_the_names_that_are_exported() -> None:
    tree = ast.parse((PACKAGE / "__init__.py").read_text())
    (guarded,) = [n for n in tree.body if isinstance(n, ast.If)]
    seen = {
        a.name: (node.module or "").removeprefix("ichain_drake.")
        for node in guarded.body
        if isinstance(node, ast.ImportFrom)
        for a in node.names
    }
    assert seen == ichain_drake._PUBLIC
    assert list(ichain_drake._PUBLIC) == ichain_drake.__all__


def test_the_public_interface_is_small_and_earlier_names_still_resolve() -> None:
    assert len(ichain_drake.__all__) <= 35
    for name in set(ichain_drake._HOME) - set(ichain_drake.__all__):
        assert getattr(ichain_drake, name) is not None
    with pytest.raises(AttributeError, match=r"no attribute 'learn_graph'; it is learn\(graph, demonstrations\) now"):
        _ = ichain_drake.learn_graph


def documented(text: str | None) -> set[str]:
    """Names in the Args and Attributes sections of a docstring, and names in backticks anywhere in it."""
    found: set[str] = set(re.findall(r"`(\w+)`", text or ""))
    section = False
    for line in (text or "").splitlines():
        if line and not line.startswith(" "):
            section = line.strip() in ("Args:", "Attributes:")
        elif section and (match := re.match(r"^ {4}([\w*, ]+):", line)):
            found |= {name.strip().lstrip("*") for name in match[1].split(",")}
    return found


def parameters(function: Callable) -> list[str]:
    return [p for p in inspect.signature(function).parameters if p not in ("self", "cls") and not p.startswith("_")]


def own_methods(kind: type) -> Iterator[tuple[str, object]]:
    for name, member in vars(kind).items():
        function = member.__func__ if isinstance(member, classmethod | staticmethod) else member
        if not name.startswith("_") and isinstance(function, FunctionType):
            yield name, function


PUBLIC = [
    getattr(ichain_drake, name)
    for name in ichain_drake.__all__
    if not isinstance(getattr(ichain_drake, name), int | float)
]
FUNCTIONS = [o for o in PUBLIC if inspect.isfunction(o)]
CLASSES = [o for o in PUBLIC if inspect.isclass(o)]
FEW = 2  # so many arguments may be explained by the summary line itself, unless there is a section for them


def needs_section(function: Callable) -> bool:
    text = inspect.getdoc(function) or ""
    return "Args:" in text or len(parameters(function)) > FEW


@pytest.mark.parametrize("function", FUNCTIONS, ids=lambda f: f.__name__)
def test_a_function_documents_its_arguments(function: Callable) -> None:
    text = inspect.getdoc(function)
    assert text
    if needs_section(function) and "arguments" not in text:  # "arguments as those of `X`"
        assert set(parameters(function)) <= documented(text)


@pytest.mark.parametrize("kind", CLASSES, ids=lambda c: c.__name__)
def test_a_class_documents_its_constructor_and_methods(kind: type) -> None:
    lineage = [c for c in kind.__mro__ if c.__module__.startswith("ichain_drake")]
    about_class = set().union(*(documented(inspect.getdoc(c)) for c in lineage))
    assert kind.__doc__
    if not issubclass(kind, Exception) and ("__init__" in vars(kind) or dataclasses.is_dataclass(kind)):
        wanted = parameters(kind.__init__)
        if len(wanted) > FEW:
            assert set(wanted) <= about_class | ({"name"} if "name" in wanted and len(lineage) > 1 else set())
    # Methods of one class, and of its bases, share their arguments: explained once is enough.
    anywhere = about_class.union(*(documented(inspect.getdoc(f)) for c in lineage for _, f in own_methods(c)))
    for name, member in own_methods(kind):
        assert inspect.getdoc(getattr(kind, name)), f"{kind.__name__}.{name} has no docstring"
        if needs_section(member):
            assert set(parameters(member)) <= anywhere, f"{kind.__name__}.{name}"
    for name, member in vars(kind).items():
        if isinstance(member, property) and not name.startswith("_"):
            assert member.__doc__, f"{kind.__name__}.{name} has no docstring"


@pytest.mark.parametrize("words", [["-c", "import ichain_drake"], ["-m", "ichain_drake", "--help"]])
def test_beginning_is_quick_as_nothing_large_is_imported(words: list[str]) -> None:
    done = subprocess.run(
        [sys.executable, "-X", "importtime", *words], capture_output=True, text=True, check=True, cwd=ROOT
    )
    imported = {line.rpartition("|")[2].strip() for line in done.stderr.splitlines()}
    assert "ichain_drake" in imported
    assert not imported & {"numpy", "pandas", "pydrake", "sklearn", "scipy", "matplotlib", "joblib", "rich"}
