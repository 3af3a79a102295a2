"""The documentation site is built without a warning, and holds tutorials, how-to pages, the API and linked sources."""

import base64
import importlib.util
import re
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest

import ichain_drake

ROOT = Path(__file__).parent.parent
MISSING = importlib.util.find_spec("mkdocs") is None or importlib.util.find_spec("mkdocstrings") is None

pytestmark = pytest.mark.skipif(MISSING, reason="MkDocs is missing: pip install -e '.[docs]'")


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(folder)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return folder


def links(page: Path) -> set[str]:
    found = re.findall(r'(?:href|src)="?([^"> #]+)', page.read_text())
    return {t for t in found if not re.match(r"\w+:", t)}


def test_every_page_is_there_and_no_link_is_broken(site: Path) -> None:
    for page in (ROOT / "docs").glob("*.md"):
        assert (site / f"{page.stem}.html").is_file(), page.name
    for notebook in (ROOT / "notebooks").glob("*.ipynb"):
        assert (site / "tutorials" / f"{notebook.stem}.html").is_file(), notebook.name
    for page in site.rglob("*.html"):
        if page.name != "404.html":  # its links start at the server's top
            for target in links(page):
                assert (page.parent / target).exists(), f"{page.relative_to(site)}: {target}"


def test_nothing_is_fetched_from_elsewhere(site: Path) -> None:
    for page in site.rglob("*.html"):
        text = page.read_text()
        assert not re.search(r"<(?:script|img|iframe)[^>]*\ssrc=\"?https?:", text), page.name
        assert not re.search(r"<link[^>]*rel=\"?(?:stylesheet|preconnect)[^>]*https?:", text), page.name


def test_the_reference_has_every_public_name(site: Path) -> None:
    text = "".join(p.read_text() for p in (site / "reference").glob("*.html"))
    for name in ichain_drake.__all__:
        assert re.search(rf'id="?ichain_drake\.[\w.]*{name}["> ]', text), name


def test_a_linked_source_is_shown(site: Path) -> None:
    page = site / "source" / "ichain_drake" / "graph.py.html"
    assert "source/ichain_drake/graph.py.html" in (site / "paper_map.html").read_text()
    assert "InteractionGraph" in page.read_text()


def hook(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, ROOT / "docs" / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_outputs_of_a_notebook_become_part_of_its_page() -> None:
    frame = '<iframe title="playback" srcdoc="&lt;p class=&quot;a&quot;&gt;hi&lt;/p&gt;"></iframe>'
    outputs = [
        {"output_type": "stream", "name": "stdout", "text": ["two\n", "lines\n"]},
        {"output_type": "stream", "name": "stderr", "text": ["a warning\n"]},
        {
            "output_type": "display_data",
            "data": {"image/png": base64.b64encode(b"picture").decode(), "text/plain": "x"},
        },
        {"output_type": "execute_result", "data": {"text/html": [frame], "text/plain": "PlaybackPage()"}},
        {"output_type": "execute_result", "data": {"text/plain": ["3"]}},
    ]
    cells = [
        {"cell_type": "markdown", "source": ["# Title\n", "text"]},
        {"cell_type": "code", "source": ["x = 1"], "outputs": outputs},
    ]
    text, shown = hook("site_notebooks").page_of({"cells": cells}, "n")
    assert text.startswith("# Title\ntext\n\n~~~~~~~~ python\nx = 1\n")
    assert "two\nlines" in text
    assert "a warning" not in text
    assert "![output](n_1_2.png)" in text
    assert 'src="n_1_3.html"' in text
    assert "srcdoc" not in text
    assert text.rstrip().endswith("3\n~~~~~~~~")
    assert shown == {"n_1_2.png": b"picture", "n_1_3.html": b'<p class="a">hi</p>'}
