"""What the pages say holds: their code runs, their links lead somewhere, their commands exist."""

import re
import subprocess
import sys
from pathlib import Path

import click
import pytest

from ichain_drake.cli.main import app

ROOT = Path(__file__).parent.parent
PAGES = sorted([ROOT / "README.md", ROOT / "CHANGELOG.md", *(ROOT / "docs").glob("*.md")])
MAX_PICTURE = 300_000


def blocks(page: Path) -> list[str]:
    """Its Python code blocks, in order."""
    return re.findall(r"^```python\n(.*?)^```", page.read_text(), re.MULTILINE | re.DOTALL)


def without_code(page: Path) -> str:
    text = re.sub(r"^```.*?^```", "", page.read_text(), flags=re.MULTILINE | re.DOTALL)
    return re.sub(r"`[^`]*`", "", text)


def anchors(page: Path) -> set[str]:
    """Names under which a page's headings can be linked."""
    headings = re.findall(r"^#+ (.*)$", page.read_text(), re.MULTILINE)
    return {re.sub(r"[^\w -]", "", h).strip().lower().replace(" ", "-") for h in headings}


def run_blocks(page: Path, folder: Path) -> str:
    """What the page's code prints when pasted block after block."""
    script = folder / "pasted.py"
    script.write_text("\n".join(blocks(page)))
    done = subprocess.run([sys.executable, str(script)], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_readme_example_is_ten_lines_and_drives(tmp_path: Path) -> None:
    page = ROOT / "README.md"
    (code,) = blocks(page)
    assert len([line for line in code.splitlines() if line.strip() and not line.startswith(("from", "import"))]) <= 10
    found = re.search(r"car: \[ ?(\d+\.\d+) +(\d+\.\d+)", run_blocks(page, tmp_path))
    assert found is not None
    assert abs(float(found[1]) - 400) + abs(float(found[2]) - 300) < 15, "an eight ends where it starts"


def test_add_your_own_object_runs_and_prints_what_it_says(tmp_path: Path) -> None:
    page = ROOT / "docs" / "add_your_own_object.md"
    printed = run_blocks(page, tmp_path).strip()
    assert f"`{printed}`" in page.read_text()


def test_the_page_and_the_example_are_the_same_code() -> None:
    code = blocks(ROOT / "docs" / "add_your_own_object.md")[0].strip()
    example = (ROOT / "examples" / "own_object.py").read_text()
    assert example.split("\n", 2)[2].strip() == code


def test_lines_for_launchers_of_clusters_are_python() -> None:
    """They need a cluster to run; elsewhere code on a page is run."""
    found = re.findall(r"^```py\n(.*?)^```", (ROOT / "docs" / "clusters.md").read_text(), re.MULTILINE | re.DOTALL)
    assert len(found) == 2
    for code in found:
        compile(code, "clusters.md", "exec")


def test_no_page_has_code_that_no_test_runs() -> None:
    assert {p.name for p in PAGES if blocks(p)} == {"README.md", "add_your_own_object.md", "add_your_own_system.md"}


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_relative_links_lead_somewhere(page: Path) -> None:
    for target in re.findall(r"\]\(([^)]+)\)", without_code(page)):
        if re.match(r"\w+:", target):
            continue
        file, _, anchor = target.partition("#")
        found = (page.parent / file).resolve() if file else page
        assert found.exists(), f"{page.name}: {target}"
        if anchor:
            assert anchor in anchors(found), f"{page.name}: {target}"


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_commands_and_their_options_exist(page: Path) -> None:
    for name, rest in re.findall(r"(?:`|^    |bin/)ichain (\w+)([^`\n]*)", page.read_text(), re.MULTILINE):
        assert name in app.commands, f"{page.name}: ichain {name}"
        command = app.commands[name]
        if isinstance(command, click.Group) and rest.split():
            assert rest.split()[0] in command.commands, f"{page.name}: ichain {name}{rest}"
            command = command.commands[rest.split()[0]]
        known = {option for p in command.params for option in (*p.opts, *p.secondary_opts)}
        options = re.findall(r"(?<!\S)(--?[a-z][a-z-]*)", rest)
        assert set(options) <= known, f"{page.name}: ichain {name}{rest}"


def test_pictures_are_small() -> None:
    pictures = sorted((ROOT / "docs" / "images").glob("*"))
    assert pictures
    for picture in pictures:
        assert picture.stat().st_size < MAX_PICTURE, picture.name


def test_every_page_is_linked_from_the_readme() -> None:
    text = (ROOT / "README.md").read_text()
    for page in (ROOT / "docs").glob("*.md"):
        assert f"(docs/{page.name}" in text, page.name


def exists(path: str) -> bool:
    return (ROOT / "ichain_drake" / path).exists() or (ROOT / path).exists()


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_paths_of_code_are_those_of_the_tree(page: Path) -> None:
    """A path in backquotes exists, below `ichain_drake/` or the root; as the text of a link it is the link's own."""
    text = page.read_text()
    assert [p for p in re.findall(r"`((?:\w+/)+(?:\w+\.(?:py|yaml))?)`", text) if not exists(p)] == []
    for shown, target in re.findall(r"\[`([\w/]+\.py)`\]\(([^)#]+)", text):
        assert target.removeprefix("../").removeprefix("ichain_drake/") == shown, f"{page.name}: {shown}"


def test_the_tree_in_the_architecture_page_is_the_tree() -> None:
    text = (ROOT / "docs" / "architecture.md").read_text()
    (drawn,) = re.findall(r"^    ichain_drake/\n(.*?)^    models/", text, re.MULTILINE | re.DOTALL)
    found, above = set(), ""
    for indent, name in re.findall(r"^ {4}( {2,4})(\w+(?:/|\.py))", drawn, re.MULTILINE):
        above = name if len(indent) == 2 else above
        found.add(name if len(indent) == 2 else above + name)
    package = ROOT / "ichain_drake"
    folders = {f"{f.relative_to(package)}/" for f in package.rglob("*/") if (f / "__init__.py").exists()} - {"./"}
    folders -= {f for f in folders if f.startswith("systems/") and f != "systems/"} | {"visualization/page/"}
    assert {name for name in found if name.endswith("/")} == folders
    files = {f.name for f in package.glob("*.py")} - {"__init__.py", "__main__.py"}
    assert {name for name in found if name.count("/") == 0} == files


def test_where_to_change_something_is_there() -> None:
    """Each row of the table names a path, and what it says is in it."""
    text = (ROOT / "docs" / "architecture.md").read_text()
    table = text.split("## Where do I change ...?")[1].split("\n## ")[0]
    rows = re.findall(r"^\| (?!what \||---)(.*?) \| (.*) \|$", table, re.MULTILINE)
    assert len(rows) == 15
    for what, where in rows:
        path = re.match(r"`([\w/]+(?:\.py)?)`(?:: ((?:`[\w.]+`(?:, )?)+))?", where)
        if path is None:
            assert where.startswith("not possible yet"), what
            continue
        assert exists(path[1]), what
        for name in re.findall(r"`([\w.]+)`", path[2] or ""):
            assert name.split(".")[-1] in (ROOT / "ichain_drake" / path[1]).read_text(), what
