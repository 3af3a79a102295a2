"""What MkDocs shows beside `docs/*.md`: README, changelog, the API reference, and the sources that pages link to.

The pages are written for a repository, where a link leads to any file. Here such links are turned into links to pages
of the site: a file outside `docs` gets a page that shows it. Used by `mkdocs.yml`.
"""

import importlib
import posixpath
import re
from collections.abc import Iterator
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

import ichain_drake
from ichain_drake.scenarios.settings_list import list_settings, markdown_table
from ichain_drake.systems import SCENARIOS

ROOT = Path(__file__).parent.parent
HOW_TO = "How to"
SETTINGS = "reference/settings_of_scenarios.md"
LINK = re.compile(r"(?<=\]\()([^)\s]+)(?=\))")
CODE = re.compile(r"(^```.*?^```|`[^`\n]*`)", re.MULTILINE | re.DOTALL)
FENCE = "~" * 8
LANGUAGES = {".py": "python", ".yaml": "yaml", ".toml": "toml", ".sdf": "xml", ".urdf": "xml"}

# Files of the repository that are pages of their own, and what they are called in the site.
NOTEBOOKS = {f"notebooks/{p.name}": f"tutorials/{p.stem}.md" for p in sorted((ROOT / "notebooks").glob("*.ipynb"))}
PAGES = {"README.md": "index.md", "CHANGELOG.md": "changelog.md"}


def reference() -> dict[str, list[str]]:
    """Public names with the modules that define them, by package, in the order of the public interface."""
    found: dict[str, list[str]] = {}
    for name in ichain_drake.__all__:
        home = getattr(getattr(ichain_drake, name), "__module__", "ichain_drake.timing")  # constants know no module
        found.setdefault(home.split(".")[1], []).append(f"{home}.{name}")
    return found


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """Complete the navigation: no page of `docs`, no notebook and no package is forgotten."""
    assert config.nav is not None
    sections = {title: pages for entry in config.nav for title, pages in entry.items()}
    listed = str(config.nav)
    sections[HOW_TO] += [p.name for p in sorted((ROOT / "docs").glob("*.md")) if p.name not in listed]
    sections["Tutorials"] += list(NOTEBOOKS.values())
    sections[HOW_TO].append({"settings": SETTINGS})
    sections["API reference"] += [{group: f"reference/{group}.md"} for group in sorted(reference())]
    return config


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages that are not in `docs`."""
    for source, uri in PAGES.items():
        files.append(File.generated(config, uri, content=(ROOT / source).read_text()))
    files.append(File.generated(config, SETTINGS, content=_settings()))
    for group, names in reference().items():
        text = importlib.import_module(f"ichain_drake.{group}").__doc__ or ""
        content = "\n\n".join([f"# {group}", text, *(f"::: {name}" for name in names)])
        files.append(File.generated(config, f"reference/{group}.md", content=content))
    shown = {t for page in [*PAGES, *_pages_of_docs()] for t in _sources(page)}
    for source in sorted(shown):
        files.append(File.generated(config, _uri(source), content=_listing(ROOT / source)))
    return files


def on_page_markdown(markdown: str, *, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Turn links between files of the repository into links between pages of the site."""
    here = page.file.src_uri
    source = next((s for s, uri in (PAGES | NOTEBOOKS).items() if uri == here), f"docs/{here}")
    if not (ROOT / source).is_file():
        return markdown

    def to_page(match: re.Match[str]) -> str:
        target, _, anchor = match[1].partition("#")
        if not target or re.match(r"\w+:", target) or not (ROOT / _in_repository(source, target)).exists():
            return match[1]
        uri = posixpath.relpath(_uri(_in_repository(source, target)), posixpath.dirname(here) or ".")
        return f"{uri}#{anchor}" if anchor else uri

    parts = CODE.split(markdown)  # code at odd places
    parts[::2] = [LINK.sub(to_page, text) for text in parts[::2]]
    # Code in the text of a link splits it: what follows begins with the link's end and is handled like any text.
    return "".join(parts)


def _settings() -> str:
    """The settings of every scenario, from what `ichain settings` prints."""
    parts = ["# Settings", "What `--set key=value` changes; `ichain settings SCENARIO` prints the same."]
    for name, kind in SCENARIOS.items():
        parts += [f"## {name}", markdown_table(list_settings(kind))]
    return "\n\n".join(parts)


def _pages_of_docs() -> Iterator[str]:
    for file in sorted((ROOT / "docs").glob("*.md")):
        yield f"docs/{file.name}"


def _in_repository(source: str, target: str) -> str:
    """A link's target, from the top of the repository."""
    return posixpath.normpath(posixpath.join(posixpath.dirname(source), target))


def _sources(page: str) -> Iterator[str]:
    """Files and folders outside `docs` that a page links to and that exist."""
    for text in CODE.split((ROOT / page).read_text())[::2]:
        for target in LINK.findall(text):
            path = _in_repository(page, target.partition("#")[0])
            if _uri(path).startswith("source/") and (ROOT / path).exists():
                yield path


def _uri(path: str) -> str:
    """The site's page for a file of the repository."""
    if path in PAGES | NOTEBOOKS:
        return (PAGES | NOTEBOOKS)[path]
    return path.removeprefix("docs/") if path.startswith("docs/") else f"source/{path}.md"


def _listing(path: Path) -> str:
    """A page that shows a file, or the names in a folder; searching does not find it."""
    head = f"---\nsearch:\n  exclude: true\n---\n\n# {path.relative_to(ROOT)}\n\n"
    if path.is_dir():
        inside = sorted(f.name for f in path.iterdir() if f.suffix in LANGUAGES or f.suffix == ".ipynb")
        return head + "\n".join(f"* `{name}`" for name in inside)
    return f"{head}{FENCE} {LANGUAGES.get(path.suffix, 'text')}\n{path.read_text()}\n{FENCE}\n"
